# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The one table of all parameters: the model's (see `model.parameters`) and the node's own.

The node declares them from here, files are checked against it, the documentation prints it.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

from ..faults.timetable import read_timetable
from ..model.parameters import (
    DESCRIPTIONS,
    Description,
    ParameterError,
    checked_value,
    from_values,
    shown,
    unknown_name,
)
from ..model.system import PositionerParameters

REFUSE, LIMIT = 'refuse', 'limit'
HOLD, VENT = 'hold', 'vent'

NODE_DESCRIPTIONS: dict[str, Description] = {
    description.name: description
    for description in (
        Description(
            'publish_rate', 100.0, 'Hz', 'ticks per second, each of which publishes',
            0.01, 10_000.0, 'fast enough to see the E/P lag of 34 ms'),
        Description(
            'integration_step', 1e-3, 's', 'interval of the integration, at most one tick',
            1e-6, 0.1, 'error against the reference: docs/accuracy.md'),
        Description(
            'max_catch_up', 60.0, 's', 'longest gap of the clock that is caught up, at least a '
            'tick (or 1 s); a longer one is a jump of the clock, which is reported and not '
            'simulated', 1e-4, 1e9, 'far beyond any late tick, short of a clock that is set'),
        Description(
            'start_paused', False, '-', 'wait for ~/step or ~/pause before the first tick',
            0.0, 1.0, 'a positioner runs'),
        Description(
            'step_on_command', False, '-', 'start paused, and advance by step_ticks ticks for '
            'each command that arrives while paused', 0.0, 1.0, 'a positioner runs'),
        Description(
            'step_ticks', 1, '-', 'ticks that a call of ~/step, or a command, advances', 1.0, 1e9,
            'the finest lockstep'),
        Description(
            'current_limits', (0.0, 2e-3), 'A', 'lowest and highest current taken as valid',
            -1.0, 1.0, 'the converter saturates at 0.74 mA, the paper goes up to 1.16 mA; a 4 to '
            '20 mA loop current is above'),
        Description(
            'invalid_current', REFUSE, '-', 'what is done with a current outside the limits; '
            'what is not finite is refused anyway', -1.0, 1.0,
            'a command that cannot be meant is not followed', (REFUSE, LIMIT)),
        Description(
            'command_timeout', 0.0, 's', 'age in simulated time at which a command goes stale, '
            '0 for never', 0.0, 1e9, 'a converter holds its current'),
        Description(
            'stale_command', HOLD, '-', 'what is done with a stale command: hold it, or vent '
            '(zero current) until the next one', -1.0, 1.0, 'as without a timeout', (HOLD, VENT)),
        Description(
            'deviation_band', 0.05, '-', 'with a position controller: share of the travel by which '
            'the position may be off the set point', 0.0, 1.0,
            'usual for a travel deviation alert'),
        Description(
            'deviation_delay', 10.0, 's', 'simulated time for which it must be further off before '
            '/diagnostics warns', 0.0, 1e9, 'usual: longer than a full stroke'),
        Description(
            'joint_name', '', '-', 'name of the joint in JointState messages; empty: valve_stem, '
            'behind the namespace', -1.0, 1.0, 'unique in each namespace'),
        Description(
            'frame_id', '', '-', 'frame in the headers of messages; empty: the name of the node, '
            'behind the namespace', -1.0, 1.0, 'unique in each namespace'),
        Description(
            'initial_state.chamber_pressure', 0.0, 'Pa', 'chamber pressure at the start and '
            'after ~/reset', -1e5, 1e7, 'vented'),
        Description(
            'initial_state.valve_position', -1.0, 'm', 'valve position at the start and after '
            '~/reset; negative: where the forces on the stem balance', -1.0, 10.0, 'at rest'),
        Description(
            'initial_state.control_current', 0.0, 'A', 'control current in force, and settled '
            'at, at the start and after ~/reset', -1.0, 1.0, 'vented'),
        Description(
            'faults.timetable', '', '-', 'faults to come, a list in YAML: docs/faults.md', -1.0,
            1.0, 'no fault'),
        Description(
            'faults.file', '', '-', 'file with such a list', -1.0, 1.0, 'no fault'),
        Description(
            'measurement.pressure_noise', 0.0, 'Pa', 'standard deviation of white noise on the '
            'chamber pressure that is published', 0.0, 1e6, 'neutral: none'),
        Description(
            'measurement.pressure_resolution', 0.0, 'Pa', 'steps in which the chamber pressure '
            'is published', 0.0, 1e6, 'neutral: none'),
        Description(
            'measurement.position_noise', 0.0, 'm', 'standard deviation of white noise on the '
            'valve position that is published', 0.0, 1.0, 'neutral: none'),
        Description(
            'measurement.position_resolution', 0.0, 'm', 'steps in which the valve position is '
            'published', 0.0, 1.0, 'neutral: none'),
        Description(
            'measurement.seed', 0, '-', 'number that noise and chance begin with, at the start '
            'and after each ~/reset', 0.0, 2e9, 'the same numbers every time'),
    )
}
"""The node's own parameters by name."""

READ_ONLY = frozenset({'publish_rate', 'integration_step', 'start_paused', 'joint_name', 'frame_id',
                       'position_controller.enabled'})
"""Parameters that keep their value for the life of the node."""

ALL_DESCRIPTIONS: dict[str, Description] = {**NODE_DESCRIPTIONS, **DESCRIPTIONS}
"""Every parameter that a parameter file may hold for the positioner."""

ROS_PARAMETERS = ('use_sim_time', 'start_type_description_service')
"""Parameters that every ROS 2 node has of its own."""

ROS_PREFIX = 'qos_overrides.'
"""Parameters below this name belong to ROS 2 itself as well."""

_NANOSECOND = 1e-9

_LATE = 1.0
"""Seconds by which no timer is late where nothing is wrong, however long a tick is."""


class InitialState(NamedTuple):
    """Chamber pressure (gauge, Pa), position (m, None: balanced) and settled current (A)."""

    chamber_pressure: float
    valve_position: float | None
    control_current: float


class FaultPlan(NamedTuple):
    """Faults to come, as a text in YAML and as the path of a file with one."""

    timetable: str
    file: str


class Measurement(NamedTuple):
    """What the published readings have beside the model's: Pa and m, and the seed of chance."""

    pressure_noise: float
    pressure_resolution: float
    position_noise: float
    position_resolution: float
    seed: int


class NodeSettings(NamedTuple):
    """The node's own parameters, checked; names and units as in `NODE_DESCRIPTIONS`."""

    publish_rate: float
    integration_step: float
    max_catch_up: float
    start_paused: bool
    step_on_command: bool
    step_ticks: int
    current_limits: tuple[float, float]
    invalid_current: str
    command_timeout: float
    stale_command: str
    deviation_band: float
    deviation_delay: float
    joint_name: str
    frame_id: str
    initial_state: InitialState
    faults: FaultPlan
    measurement: Measurement


class Parameters(NamedTuple):
    """All parameters of a positioner node, checked together."""

    physical: PositionerParameters
    node: NodeSettings


def belongs_to_ros(name: str) -> bool:
    """Tell whether a parameter is one of ROS 2 itself, that any node may be given."""
    return name in ROS_PARAMETERS or name.startswith(ROS_PREFIX)


def check(values: Mapping[str, Any]) -> Parameters:
    """
    Return all parameters from dotted names and values; what is missing has its default.

    Raise ParameterError, one sentence naming the parameter, for an unknown name, a wrong kind or
    range, and values that contradict each other.
    """
    for name in values:
        _description(name)
    physical = from_values({n: v for n, v in values.items() if n in DESCRIPTIONS})
    node = _node_settings({n: v for n, v in values.items() if n in NODE_DESCRIPTIONS})
    if (node.initial_state.valve_position or 0.0) > physical.actuator.travel:
        raise ParameterError(
            f'initial_state.valve_position ({node.initial_state.valve_position:g} m) must not be '
            f'beyond actuator.travel ({physical.actuator.travel:g} m)')
    return Parameters(physical, node)


def checked(name: str, value: Any) -> Any:
    """
    Return one value as ROS 2 and a file hold it: float, int, bool, text or tuple of floats.

    Integers are taken where a float is meant. ParameterError for an unknown name, a wrong kind or
    range.
    """
    return checked_as(_description(name), value)


def _description(name: str) -> Description:
    if name not in ALL_DESCRIPTIONS:
        raise ParameterError(unknown_name(name, ALL_DESCRIPTIONS))
    return ALL_DESCRIPTIONS[name]


def checked_as(description: Description, value: Any) -> Any:
    """Return a value of the kind and range that a description asks for, see `checked`."""
    name, default = description.name, description.default
    if isinstance(default, bool):
        return checked_value(description, value)
    if isinstance(default, str) and not description.choices:
        if not isinstance(value, str):
            raise ParameterError(f'{name} must be a text, got {shown(value)}')
        return value
    if isinstance(default, int):
        whole = isinstance(value, int) and not isinstance(value, bool)
        if not whole or not description.low <= value <= description.high:
            raise ParameterError(
                f'{name} must be a whole number from {description.low:g} to '
                f'{description.high:g}, got {shown(value)}')
        return value
    result = checked_value(description, value)
    return description.choices[result] if description.choices else result


def _node_settings(values: Mapping[str, Any]) -> NodeSettings:
    known = {
        name: checked(name, values.get(name, description.default))
        for name, description in NODE_DESCRIPTIONS.items()
    }
    position = known.pop('initial_state.valve_position')
    initial = InitialState(
        known.pop('initial_state.chamber_pressure'), None if position < 0.0 else position,
        known.pop('initial_state.control_current'))
    settings = NodeSettings(
        initial_state=initial, faults=FaultPlan(**_group(known, 'faults.')),
        measurement=Measurement(**_group(known, 'measurement.')), **known)
    _check_consistent(settings)
    read_timetable(settings.faults.timetable, 'faults.timetable')
    return settings


def _group(known: dict[str, Any], prefix: str) -> dict[str, Any]:
    """Take the values below a prefix out of those known, and return them without it."""
    names = [name for name in known if name.startswith(prefix)]
    return {name.removeprefix(prefix): known.pop(name) for name in names}


def _check_consistent(settings: NodeSettings) -> None:
    step, period = settings.integration_step, 1.0 / settings.publish_rate
    low, high = settings.current_limits
    if step > period * (1.0 + 1e-9):
        raise ParameterError(
            f'integration_step ({step:g} s) must not be longer than a tick, {period:g} s at a '
            f'publish_rate of {settings.publish_rate:g} Hz')
    if abs(step / _NANOSECOND - round(step / _NANOSECOND)) > 1e-3:
        raise ParameterError(
            f'integration_step ({step!r} s) must be a whole number of nanoseconds')
    if settings.max_catch_up < min(period, _LATE) * (1.0 - 1e-9):
        raise ParameterError(
            f'max_catch_up ({settings.max_catch_up:g} s) must not be shorter than '
            f'{min(period, _LATE):g} s at a publish_rate of {settings.publish_rate:g} Hz: ticks '
            'that are merely late would be taken for jumps of the clock')
    if not low < high:
        raise ParameterError(f'current_limits must rise, got [{low:g}, {high:g}] A')
    if not low <= settings.initial_state.control_current <= high:
        raise ParameterError(
            f'initial_state.control_current ({settings.initial_state.control_current:g} A) must '
            f'be within current_limits [{low:g}, {high:g}] A')
