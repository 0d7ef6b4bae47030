# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a mapping, or the messages themselves, say of the channels of a bag."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from booster_ros.model.gas import ATMOSPHERE
from booster_ros.records.bag_topics import PRESSURE_TYPE, Channel, choose_channels
from booster_ros.records.mapping import FileMapping
from booster_ros.records.reading import HALF_VACUUM, reading
from booster_ros.records.record import (
    COLUMNS, UNKNOWN_COLUMN, Array, Defect, RecordError)

_SAME_CLOCK = 0.05
"""Share by which two clocks that run alike differ in how long a bag lasted."""


class Samples(NamedTuple):
    """What was read of one channel; `header` (ns) is empty where messages have no header."""

    received: Array
    header: Array
    values: Array


def mapped_channels(
    available: Mapping[str, str], mapping: FileMapping, stamps: str
) -> list[Channel]:
    """Return the channels that a mapping names, and no others."""
    for name in mapping.columns:
        if name not in COLUMNS:
            raise RecordError(f'{mapping.source}, columns.{name}: is not read from a bag')
    topics = {name: str(one.source) for name, one in mapping.columns.items()}
    channels = choose_channels(available, topics, stamps)
    found = []
    for channel in channels:
        if channel.column in topics:
            gauge = mapping.columns[channel.column].gauge
            if isinstance(gauge, str):
                raise RecordError(f'{mapping.source}, columns.{channel.column}.gauge: say true or '
                                  'false (absolute pressure)')
            found.append(replace(channel, gauge=gauge))
    return found


class Unread:
    """Topics of joints that no column is read from: one may be the position that is meant."""

    def __init__(self, topics: Iterable[str]):
        self.joints: dict[str, set[str]] = {topic: set() for topic in topics}
        self._times: dict[str, list[tuple[int, int]]] = {topic: [] for topic in self.joints}

    def see(self, topic: str, message: Any, received: int, stamp: int) -> None:
        """Take note of the joints in a message, and of its stamps (ns)."""
        if topic in self.joints:
            self.joints[topic].update(message.name)
            if stamp:
                self._times[topic].append((received, stamp))

    def notes(self, channels: Iterable[Channel]) -> list[Defect]:
        """Return the question which joint is the valve, where none was read, and on clocks."""
        if any(channel.column == 'valve_position' for channel in channels):
            return []
        found = []
        for topic, names in self.joints.items():
            listed = sorted(names)
            found.append(Defect(
                UNKNOWN_COLUMN, topic, 0, 0, 1,
                f'has positions of {", ".join(listed[:20])} and was not read: is one of them the '
                f'valve? Say so, as in valve_position={topic}:{listed[0] if listed else "NAME"}'))
            times = np.array(self._times[topic], dtype=np.int64).reshape(-1, 2)
            found += note_on_clocks(topic, times[:, 0], times[:, 1], 'bag')
        return found


def notes_on_clocks(samples: Mapping[Channel, Samples], stamps: str) -> list[Defect]:
    """Return a note where the stamps in messages run faster or slower than the bag's own time."""
    notes = [note_on_clocks(channel.topic, sample.received, sample.header, stamps)
             for channel, sample in samples.items() if sample.header.size]
    return next(filter(None, notes), [])


def note_on_clocks(topic: str, received: Array, stamped: Array, stamps: str) -> list[Defect]:
    """Return a note where the stamps (ns) of a topic run faster or slower than the bag's time."""
    if len(stamped) < 3 or not np.ptp(received) or not np.ptp(stamped):
        return []
    rate = float(np.ptp(stamped)) / float(np.ptp(received))
    if abs(rate - 1.0) <= _SAME_CLOCK:
        return []
    used = 'these stamps are used' if stamps == 'header' else (
        'the time of recording is used; the other is that of the headers')
    return [Defect('two_clocks', 'time', 0, 0, len(stamped),
                   f'the stamps in {topic} run at {rate:.3g} of the time of recording, as '
                   f'simulated time does; {used}')]


def notes_on_commands(samples: Mapping[Channel, Samples]) -> list[Defect]:
    """Return a note where one command stands for a whole bag."""
    return [Defect('latched_command', channel.column, 0, 0, 1,
                   f'{channel.topic} has one message, taken to stand throughout')
            for channel, sample in samples.items()
            if channel.column == 'control_current' and sample.values.size == 1
            and any(other.values.size > 1 for other in samples.values())]


def in_si(
    samples: Mapping[Channel, Samples], mapping: FileMapping | None, source: str
) -> tuple[dict[Channel, Samples], list[Defect]]:
    """Return the samples in SI units and gauge pressure, and notes on what is not as defined."""
    found, notes = {}, []
    for channel, sample in samples.items():
        values = sample.values
        one = mapping.columns.get(channel.column) if mapping else None
        if one is not None and one.unit is not None:
            how = reading(channel.column, replace(one, gauge=True), str(one.source), '', None,
                          f'{mapping.source if mapping else source}, columns.{channel.column}')
            values, told = how.of(values)
            notes += told
        if channel.message_type == PRESSURE_TYPE:
            values, told = _gauge(channel, values)
            notes += told
        elif channel.gauge is False:
            values = values - ATMOSPHERE
            notes.append(Defect('converted', channel.column, 0, 0, len(values),
                                'absolute pressure, 101325 Pa taken off'))
        found[channel] = sample._replace(values=values)
    return found, notes


def _gauge(channel: Channel, values: Array) -> tuple[Array, list[Defect]]:
    """Return the gauge pressure of a FluidPressure, which is absolute unless it cannot be."""
    if channel.gauge:
        return values, []
    if channel.gauge is None and values.size and np.quantile(values, 0.01) < HALF_VACUUM:
        return values, [Defect(
            'gauge_pressure', channel.column, 0, 0, len(values),
            f'{channel.topic} falls to {values.min():.4g} Pa, which no absolute pressure in a '
            'valve does: taken as gauge pressure, against what FluidPressure defines')]
    return values - ATMOSPHERE, []
