# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Look at a bag: what its topics hold, and the mapping that most likely reads them."""

from __future__ import annotations

from dataclasses import dataclass, field
import os
from pathlib import Path
from typing import Any

import numpy as np

from booster_ros.records.bag_mapping import note_on_clocks
from booster_ros.records.bag_runs import in_run, listed, longest, run_starts
from booster_ros.records.bag_topics import (
    JOINT_TYPE, PRESSURE_TYPE, READERS, STATE_TYPE, Channel, choose_channels)
from booster_ros.records.mapping_text import scalar
from booster_ros.records.reading import HALF_VACUUM
from booster_ros.records.record import COLUMNS, Array, RecordError

_MOST_MESSAGES = 1_000_000


@dataclass
class Topic:
    """What a topic, or one joint of it, holds; `column` is what it is taken for."""

    topic: str
    kind: str
    element: str = ''
    column: str = ''
    asked: str = ''
    received: list[int] = field(default_factory=list)
    header: list[int] = field(default_factory=list)
    values: list[float] = field(default_factory=list)
    messages: int = 0

    @property
    def count(self) -> int:
        """How many messages have a number."""
        return len(self.values)

    @property
    def low(self) -> float:
        """The least number."""
        return float(np.min(self.values))

    @property
    def high(self) -> float:
        """The largest number."""
        return float(np.max(self.values))


@dataclass(frozen=True)
class BagInspection:
    """The topics of a bag, the mapping as YAML, notes and questions."""

    source: str
    topics: list[Topic]
    text: str
    notes: tuple[str, ...]
    asked: tuple[str, ...]
    starts: list[int]
    run: int

    def series(self) -> list[tuple[str, Array, Array]]:
        """Return name, time (s from the first message on) and values of each topic in the run."""
        found = []
        for one in self.topics:
            times = np.array(one.received[:one.count], dtype=np.int64)
            kept = in_run(times, self.starts, self.run)
            if kept.any():
                found.append((f'{one.topic}{":" * bool(one.element)}{one.element}',
                              (times[kept] - self.starts[self.run - 1]) * 1e-9,
                              np.array(one.values)[kept]))
        return found


def inspect_bag(path: str | os.PathLike[str]) -> BagInspection:
    """Return what a bag holds; RecordError where it cannot be read."""
    source = os.fspath(path)
    topics = _read(Path(path), source)
    available = {one.topic: one.kind for one in topics}
    notes: list[str] = []
    try:
        channels = choose_channels(available, None, 'bag')
    except RecordError as error:
        channels = []
        notes.append(str(error))
    asked = _guess(topics, channels)
    for one in topics:
        if len(one.header) == len(one.received):
            clock = note_on_clocks(one.topic, np.array(one.received), np.array(one.header), 'bag')
            notes += [str(note) for note in clock if str(note) not in notes]
    for one in topics:
        if one.column and not one.messages:
            notes.append(f'{one.topic} has no message: leave {one.column} out')
        if one.column == 'control_current' and one.count == 1:
            notes.append(f'{one.topic} has one message, taken to stand throughout')
        if one.kind == PRESSURE_TYPE and one.values and (
                np.quantile(one.values, 0.01) < HALF_VACUUM):
            notes.append(f'{one.topic} is of a type for absolute pressure and falls to '
                         f'{one.low:.4g} Pa: it carries gauge pressure')
    times = [np.array(one.received, dtype=np.int64) for one in topics if one.received]
    starts = run_starts(times) if times else [0]
    run = longest(times, starts) if times else 1
    text = _text(source, topics, channels)
    if len(starts) > 1:
        text += f'run: {run}  # of several in this bag, as its clock was set\n'
        notes.append(f'its clock was set on the way: {len(starts)} runs, each a record of its own '
                     f'({listed(times, starts)}); the mapping takes {run}')
    return BagInspection(source, topics, text, tuple(notes), tuple(asked), starts, run)


def _read(path: Path, source: str) -> list[Topic]:
    try:
        from booster_ros.records.bag_reader import check_complete, messages
    except ModuleNotFoundError as missing:
        raise RecordError(f'{source}: reading a bag needs the Python package {missing.name}, which '
                          'is not installed') from None
    check_complete(path)
    found: dict[tuple[str, str], Topic] = {}
    for topic, kind, received, stamp, message in messages(path, source, _MOST_MESSAGES):
        plain = found.setdefault((topic, ''), Topic(topic, kind))
        if message is None:
            continue
        plain.messages += 1
        for element, value in _values(topic, kind, message):
            one = found.setdefault((topic, element), Topic(topic, kind, element))
            one.messages += element != ''
            one.received.append(received)
            one.values.append(value)
            if stamp:
                one.header.append(stamp)
    return [one for one in found.values()
            if not (one.kind == JOINT_TYPE and not one.element and one.messages)]


def _values(topic: str, kind: str, message: Any) -> list[tuple[str, float]]:
    if kind == JOINT_TYPE:
        return [(name, float(value)) for name, value in zip(message.name, message.position)]
    if kind not in READERS or kind == STATE_TYPE:
        return []
    value = READERS[kind](message, Channel('', topic, kind))
    return [] if value is None else [('', value)]


def _guess(topics: list[Topic], channels: list[Channel]) -> list[str]:
    """Set what each topic is taken for, and return what has to be asked."""
    asked = []
    taken = {channel.topic: channel.column for channel in channels}
    for one in topics:
        one.column = taken.get(one.topic, '')
    joints = [one for one in topics if one.kind == JOINT_TYPE and one.element]
    if joints and 'valve_position' not in taken.values():
        if len(joints) == 1:
            joints[0].column = 'valve_position'
        else:
            asked.append('columns.valve_position.from: which of '
                         f'{", ".join(one.element for one in joints)} is the valve?')
    return asked


def _text(source: str, topics: list[Topic], channels: list[Channel]) -> str:
    lines = [f'# How {os.path.basename(source.rstrip("/"))} is read. A ? has to be replaced; a '
             'line that is wrong may go.',
             f'# Columns of a record: {", ".join(name for name in COLUMNS if name != "time")}.',
             'time: {stamps: bag}  # or header, for the stamps in the messages', 'columns:']
    state = [channel for channel in channels if channel.message_type == STATE_TYPE]
    lines += [f'  {channel.column}: {{from: {scalar(channel.topic)}}}  # the state'
              for channel in state]
    for one in topics:
        if one.kind == STATE_TYPE or not one.column:
            continue
        name = f'{one.topic}:{one.element}' if one.element else one.topic
        gauge = ''
        if one.kind == PRESSURE_TYPE:
            is_gauge = bool(one.values) and np.quantile(one.values, 0.01) < HALF_VACUUM
            gauge = f', gauge: {str(bool(is_gauge)).lower()}'
        line = f'{one.column}: {{from: {scalar(name)}, unit: {COLUMNS[one.column].unit}{gauge}}}'
        lines.append(f'  # {line}  # no message' if not one.messages else f'  {line}')
    joints = [one for one in topics if one.kind == JOINT_TYPE and one.element]
    if len(joints) > 1 and not any(one.column for one in joints):
        lines.append(f'  valve_position: {{from: {scalar(joints[0].topic + ":?")}, unit: m}}  # '
                     f'{" or ".join(one.element for one in joints[:20])}?')
    for one in topics:
        if not one.column and one.values and one.kind != JOINT_TYPE:
            lines.append(f'  # NAME: {{from: {scalar(one.topic)}, unit: "?"}}  # {one.low:.6g} to '
                         f'{one.high:.6g}')
    return '\n'.join(lines) + '\n'
