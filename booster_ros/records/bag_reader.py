# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Read the topics of a rosbag2 bag (sqlite3 or mcap) into the columns of a record."""

from collections import defaultdict
from collections.abc import Iterator, Mapping
import itertools
import os
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore

from booster_ros.records.bag_limits import (
    check_metadata, check_packed_files, unpack_myself, unpacked_message)
from booster_ros.records.bag_mapping import (
    Samples, Unread, in_si, mapped_channels, notes_on_clocks, notes_on_commands)
from booster_ros.records.bag_runs import chosen_run
from booster_ros.records.bag_topics import (
    READERS, STATE_TYPE, Channel, choose_channels, several_names, unread)
from booster_ros.records.mapping import FileMapping
from booster_ros.records.record import Array, Defect, RecordError
from booster_ros.records.time_base import Signal, merge
from booster_ros.records.units import check_finite, check_units

STAMPS = ('bag', 'header')

_LONGEST_TRANSPORT = 1.0
_NANOSECONDS = 1e-9


class Bag(NamedTuple):
    """The columns of a bag on one time base, as `clean` takes them."""

    columns: dict[str, Array]
    rows: Array
    source: str
    defects: tuple[Defect, ...]


def read_bag(
    path: str | os.PathLike[str], topics: Mapping[str, str] | None = None, stamps: str = 'bag',
    mapping: FileMapping | None = None,
) -> Bag:
    """
    Return the columns that the topics of a bag hold, on one time base.

    `topics` maps columns to topics, as {'valve_position': '/left/joint_states:valve'}; without it
    topics are taken by name. `stamps` is 'bag' (time of recording) or 'header'. A `mapping` names
    all columns that are read, with unit and gauge where the types do not tell. RecordError says
    what is wrong with the bag.
    """
    if mapping is not None and mapping.time is not None and mapping.time.stamps:
        stamps = mapping.time.stamps
    if stamps not in STAMPS:
        raise RecordError(f'stamps must be bag or header, not {stamps!r}')
    source = str(path)
    check_complete(Path(path))
    try:
        samples, left = _read_samples(Path(path), topics, stamps, mapping)
    except RecordError as error:
        raise RecordError(f'{source}: {error}') from None
    except Exception as error:
        # On a damaged bag rosbags raises whatever it meets: its own errors, struct.error, KeyError,
        # sqlite3.Error, YAMLError … There is nothing else in this block.
        raise RecordError(f'{source} is not a readable bag: {_one_line(error)}') from None
    notes = [*left, *notes_on_clocks(samples, stamps), *notes_on_commands(samples)]
    samples, converted = in_si(samples, mapping, source)
    signals, run = _signals(samples, stamps, mapping, source)
    columns, rows, defects = merge(signals)
    defects += [*run, *notes, *converted]
    for name, values in columns.items():
        check_finite(name, values, rows, source)
        check_units(name, values, rows, source)
    return Bag(columns, rows, source, tuple(defects))


def check_complete(path: Path) -> None:
    """Raise RecordError where there is no bag, or one without its metadata."""
    if not path.exists():
        raise RecordError(f'{path}: No such file or directory')
    if path.is_dir() and not (path / 'metadata.yaml').exists():
        raise RecordError(
            f'{path} is not a complete bag, it has no metadata.yaml: give the .mcap or .db3 file '
            'in it, or repair it with ros2 bag reindex'
        )


def messages(path: Path, source: str, most: int) -> Iterator[tuple[str, str, int, int, Any]]:
    """
    Yield topic, type, time of recording and stamp (ns) and message of the first of a bag.

    Each topic comes once without a message first, as some have none. RecordError where the bag
    cannot be read.
    """
    types = get_typestore(Stores.ROS2_JAZZY)
    try:
        with Reader(path) as bag:
            for connection in bag.connections:
                yield connection.topic, connection.msgtype, 0, 0, None
            wanted = [one for one in bag.connections if one.msgtype in READERS]
            for connection, received, data in itertools.islice(bag.messages(wanted), most):
                message = types.deserialize_cdr(data, connection.msgtype)
                yield (connection.topic, connection.msgtype, received, _header_stamp(message),
                       message)
    except RecordError:
        raise
    except Exception as error:  # as in read_bag
        raise RecordError(f'{source} is not a readable bag: {_one_line(error)}') from None


def _one_line(error: Exception) -> str:
    text = ' '.join(str(error).split()) or type(error).__name__
    return text[:200]


def _read_samples(
    path: Path, topics: Mapping[str, str] | None, stamps: str, mapping: FileMapping | None
) -> tuple[dict[Channel, Samples], list[Defect]]:
    types = get_typestore(Stores.ROS2_JAZZY)
    if path.is_dir():
        check_metadata(path)
        check_packed_files(path)
    with Reader(path) as bag:
        packed = unpack_myself(bag)
        available = {connection.topic: connection.msgtype for connection in bag.connections}
        channels = (choose_channels(available, topics, stamps) if mapping is None
                    else mapped_channels(available, mapping, stamps))
        left = Unread([] if mapping else unread(available, channels))
        by_topic = defaultdict(list)
        for channel in channels:
            by_topic[channel.topic].append(channel)
        wanted = [connection for connection in bag.connections
                  if connection.topic in by_topic or connection.topic in left.joints]
        raw: dict[Channel, list[tuple[int, int, float]]] = {channel: [] for channel in channels}
        joints: dict[Channel, set[str]] = {channel: set() for channel in channels}
        for connection, received, data in bag.messages(wanted):
            message = types.deserialize_cdr(
                unpacked_message(data) if packed else data, connection.msgtype)
            stamp = _header_stamp(message)
            left.see(connection.topic, message, received, stamp)
            for channel in by_topic[connection.topic]:
                value = READERS[channel.message_type](message, channel)
                joints[channel].update(getattr(message, 'name', ()))
                if value is not None:
                    raw[channel].append((received, stamp, value))
    for channel, names in joints.items():
        # several publishers may share a topic, each with its own joint
        if (len(names) > 1 and not channel.element) or (names and not raw[channel]):
            raise several_names(channel, sorted(names))
    return {channel: _as_arrays(triples) for channel, triples in raw.items()}, left.notes(channels)


def _header_stamp(message: object) -> int:
    """Return the nanoseconds in the header of a message, 0 where it has none or it was not set."""
    header = getattr(message, 'header', None)
    return 0 if header is None else header.stamp.sec * 10**9 + header.stamp.nanosec


def _as_arrays(triples: list[tuple[int, int, float]]) -> Samples:
    received = np.array([triple[0] for triple in triples], dtype=np.int64)
    header = np.array([triple[1] for triple in triples], dtype=np.int64)
    values = np.array([triple[2] for triple in triples], dtype=float)
    return Samples(received, header if header.any() else header[:0], values)


def _signals(
    samples: Mapping[Channel, Samples], stamps: str, mapping: FileMapping | None, source: str
) -> tuple[dict[str, Signal], list[Defect]]:
    for channel, sample in samples.items():
        if not sample.values.size:
            raise RecordError(
                f'{source}: topic {channel.topic} of column {channel.column} has no message'
            )
    if stamps == 'header':
        chosen = _header_stamps(samples, source)
    else:
        chosen = {channel: sample.received for channel, sample in samples.items()}
    used, notes = chosen_run(chosen, mapping, source)
    for channel, kept in used.items():
        if not kept.any():
            raise RecordError(f'{source}: topic {channel.topic} of column {channel.column} has no '
                              'message in this run')
    zero = min(int(time[used[channel]].min()) for channel, time in chosen.items())
    signals = {}
    for channel, time in chosen.items():
        order = np.argsort(time, kind='stable')
        order = order[used[channel][order]]
        seconds = (time[order] - zero) * _NANOSECONDS
        signal = Signal(channel.topic, seconds, samples[channel].values[order])
        if channel.message_type == STATE_TYPE and channel.column == 'control_current':
            if len(order) < 2:
                raise RecordError(
                    f'{source}: topic {channel.topic} has one message: the current in it led to '
                    'that state, and from none')
            signal = _from_tick_before(signal)
        signals[channel.column] = signal
    return signals, notes


def _from_tick_before(state: Signal) -> Signal:
    """Return the current in the state as a command: it led from the tick before to this one."""
    return Signal(state.source, state.time[:-1], state.values[1:])


def _header_stamps(samples: Mapping[Channel, Samples], source: str) -> dict[Channel, Array]:
    """
    Return the header stamps, and the time of recording of topics whose messages have none.

    The time of recording is of the same clock, late by the transport, unless the bag was recorded
    against another clock.
    """
    stamped = {channel: sample for channel, sample in samples.items() if sample.header.size}
    if not stamped:
        raise RecordError(f'{source}: no topic has stamps in its header; use the time of recording')
    for channel, sample in stamped.items():
        backwards = np.flatnonzero(np.diff(sample.header) < 0)
        if backwards.size:
            raise RecordError(
                f'{source}: the header stamps of topic {channel.topic} run backwards at message '
                f'{backwards[0] + 2}'
            )
        delay = np.median(sample.received - sample.header) * _NANOSECONDS
        plain = [other for other in samples if other not in stamped]
        if plain and abs(delay) > _LONGEST_TRANSPORT:
            raise RecordError(
                f'{source}: topic {plain[0].topic} has no header, and the header stamps of '
                f'{channel.topic} are of another clock ({delay:.3g} s from the time of recording); '
                'use the time of recording'
            )
    return {
        channel: sample.header if channel in stamped else sample.received
        for channel, sample in samples.items()
    }
