# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which topic of a bag holds which column of a record."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from booster_ros.records.record import COLUMNS, RecordError


@dataclass(frozen=True)
class Channel:
    """
    A column of a record, the topic it is read from, and the element of the message, if named.

    `gauge` says whether a pressure is gauge where the type defines it as absolute: None as defined.
    """

    column: str
    topic: str
    message_type: str
    element: str = ''
    gauge: bool | None = None


def _data(message: Any, channel: Channel) -> float:
    return float(message.data)


def _fluid_pressure(message: Any, channel: Channel) -> float:
    return float(message.fluid_pressure)


def _joint_position(message: Any, channel: Channel) -> float | None:
    """Return the position of the joint asked for, or of the only one; None if it is not there."""
    if channel.element:
        named = channel.element in message.name
        return float(message.position[message.name.index(channel.element)]) if named else None
    if len(message.name) == 1:
        return float(message.position[0])
    raise several_names(channel, message.name)


def several_names(channel: Channel, names: Iterable[str]) -> RecordError:
    """Return the error to raise where a topic names several things and none was asked for."""
    return RecordError(
        f'topic {channel.topic} names {", ".join(names) or "nothing"}; '
        f'say which is {channel.column}, as in {channel.column}={channel.topic}:NAME'
    )


def _state(message: Any, channel: Channel) -> float:
    """Return a value of the positioner's state: named fields, their numbers written as text."""
    for status in message.status:
        for entry in status.values:
            if entry.key == channel.element:
                return float(entry.value)
    raise RecordError(f'topic {channel.topic} has no value {channel.element}')


STATE_TYPE = 'diagnostic_msgs/msg/DiagnosticArray'
PRESSURE_TYPE = 'sensor_msgs/msg/FluidPressure'
JOINT_TYPE = 'sensor_msgs/msg/JointState'

READERS: Mapping[str, Callable[[Any, Channel], float | None]] = {
    'std_msgs/msg/Float64': _data,
    'std_msgs/msg/Float32': _data,
    PRESSURE_TYPE: _fluid_pressure,
    JOINT_TYPE: _joint_position,
    STATE_TYPE: _state,
}
"""Function that reads a value from a message, by message type; None if the message lacks it."""

_STAMPED = (PRESSURE_TYPE, JOINT_TYPE)
_SUFFIX = '_stamped'
_STATE_TOPIC = 'state'
_STATE_FIELDS = {
    'chamber_pressure': 'measured_chamber_pressure',
    'valve_position': 'measured_valve_position',
}
_NOT_IN_EVERY_STATE = {'set_point', 'pressure_drop'}


def choose_channels(
    available: Mapping[str, str], topics: Mapping[str, str] | None, stamps: str
) -> list[Channel]:
    """
    Return the channels to read from the available topics (name to message type).

    A topic belongs to the column it is called after, in whatever namespace, with or without
    `_stamped`. Where both are there, bag time prefers the plain type and header time the stamped
    one. A column without a topic of its own is taken from the state of the positioner, where there
    is one such topic. RecordError where two namespaces offer a column, or a topic asked for cannot
    be read.
    """
    wanted = dict(topics or {})
    for column in wanted:
        if column not in COLUMNS or column == 'time':
            raise RecordError(f'topics: {column!r} is not a column of a record')
    channels = []
    states = [topic for topic in available if _is_state(topic, available)]
    for column in list(COLUMNS)[1:]:
        if column in wanted:
            channels.append(_asked_for(column, wanted[column], available))
        elif candidates := [topic for topic in available if _belongs(topic, column, available)]:
            channels.append(_preferred(column, candidates, available, stamps))
        elif len(states) == 1 and column not in _NOT_IN_EVERY_STATE:
            field = _STATE_FIELDS.get(column, column)
            channels.append(Channel(column, states[0], STATE_TYPE, field))
    if not channels:
        raise RecordError(f'no topic is called after a column; there are {_listing(available)}')
    return channels


def unread(available: Mapping[str, str], channels: Iterable[Channel]) -> list[str]:
    """Return the topics of joints that no channel is read from: one may be the position meant."""
    used = {channel.topic for channel in channels}
    return [topic for topic, kind in available.items() if kind == JOINT_TYPE and topic not in used]


def _asked_for(column: str, target: str, available: Mapping[str, str]) -> Channel:
    topic, _, element = target.partition(':')
    topic = '/' + topic.lstrip('/')
    if topic not in available:
        raise RecordError(
            f'topic {topic} for column {column} is not in the bag; there are {_listing(available)}'
        )
    if available[topic] not in READERS:
        raise RecordError(
            f'topic {topic} for column {column} is of type {available[topic]}, not one of '
            f'{", ".join(READERS)}'
        )
    if available[topic] == STATE_TYPE and not element:
        element = _STATE_FIELDS.get(column, column)
    return Channel(column, topic, available[topic], element)


def _is_state(topic: str, available: Mapping[str, str]) -> bool:
    return available[topic] == STATE_TYPE and _stem(topic) == _STATE_TOPIC


def _belongs(topic: str, column: str, available: Mapping[str, str]) -> bool:
    return available[topic] in READERS and _stem(topic) == column


def _stem(topic: str) -> str:
    return topic.rsplit('/', 1)[-1].removesuffix(_SUFFIX)


def _preferred(
    column: str, candidates: list[str], available: Mapping[str, str], stamps: str
) -> Channel:
    namespaces = sorted({topic.rsplit('/', 1)[0] for topic in candidates})
    if len(namespaces) > 1:
        raise RecordError(
            f'column {column} could be {" or ".join(sorted(candidates))}; '
            f'say which, as in {column}={sorted(candidates)[0]}'
        )

    def rank(topic: str) -> tuple[bool, str]:
        is_stamped = available[topic] in _STAMPED
        return is_stamped != (stamps == 'header'), topic

    topic = min(candidates, key=rank)
    return Channel(column, topic, available[topic])


def _listing(topics: Iterable[str]) -> str:
    return ', '.join(sorted(topics)) or 'none'
