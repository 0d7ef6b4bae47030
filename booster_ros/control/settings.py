# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The parameters of the fake controller: one table, checked together, without ROS."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

from booster_ros.model.parameters import Description, ParameterError, shown, unknown_name
from booster_ros.parameters.schema import checked_as

CURRENT, POSITION, SET_POINT = 'current', 'position', 'set_point'
STEPS, STAIRCASE, TRIANGLE, SINES, CSV = 'steps', 'staircase', 'triangle', 'sines', 'csv'
AUTO, PLAIN, STAMPED = 'auto', 'plain', 'stamped'
MCAP, SQLITE3 = 'mcap', 'sqlite3'

_PAPER = "the paper's open-loop test"
_FOREVER = 1e9

DESCRIPTIONS: dict[str, Description] = {
    description.name: description
    for description in (
        Description(
            'mode', CURRENT, '-', 'what the profile is: the control current itself, the set point '
            'of the position loop, or that of a positioner with a position controller of its own',
            -1.0, 1.0, _PAPER, (CURRENT, POSITION, SET_POINT)),
        Description(
            'rate', 100.0, 'Hz', 'commands per second', 0.01, 10_000.0, "the positioner's rate"),
        Description(
            'profile', STEPS, '-', 'what is played', -1.0, 1.0, _PAPER,
            (STEPS, STAIRCASE, TRIANGLE, SINES, CSV)),
        Description(
            'levels', (0.0, 0.4524e-3, 0.0, 0.4524e-3), 'A or m', 'values of steps, one after the '
            'other', -1.0, 1.0, _PAPER),
        Description(
            'dwell', 20.0, 's', 'how long each level or stair is held', 1e-3, _FOREVER,
            'twice the settling time of the 0.4524 mA step'),
        Description(
            'low', 0.395e-3, 'A or m', 'lowest value of staircase, triangle and sines', -1.0, 1.0,
            'the stem leaves its closed stop at 0.401 mA'),
        Description(
            'high', 0.47e-3, 'A or m', 'highest value of staircase, triangle and sines', -1.0, 1.0,
            'the stem reaches its open stop at 0.465 mA'),
        Description(
            'stairs', 5, '-', 'stairs from low to high, and as many down', 1.0, 1e6,
            'every fifth of the travel'),
        Description(
            'period', 60.0, 's', 'period of the triangle, up and down', 1e-3, _FOREVER,
            'slow beside the chamber'),
        Description(
            'frequencies', (0.05, 0.13, 0.31), 'Hz', 'frequencies of the sines, of equal '
            'amplitude', 1e-6, 1e4, 'below the corner of the chamber'),
        Description(
            'cycles', 2, '-', 'periods of the triangle, or of the lowest of the sines', 1.0, 1e9,
            'a first period from rest, a second one settled'),
        Description(
            'csv_file', '', '-', 'record whose time and control_current (valve_position in the '
            'position loop, set_point in mode set_point) are played, held from row to row',
            -1.0, 1.0, 'none'),
        Description(
            'loop', False, '-', 'play the profile again and again until told to end', 0.0, 1.0,
            'a test ends'),
        Description(
            'keep_alive', False, '-', 'go on sending the last command when the profile is done',
            0.0, 1.0, 'a test ends'),
        Description(
            'loop_gain', 0.2, 'A/m', 'proportional gain of the position loop', 0.0, 1e6,
            'docs/fake_controller.md'),
        Description(
            'loop_integral_time', 5.0, 's', 'integral time of the position loop', 1e-6, 1e9,
            'docs/fake_controller.md'),
        Description(
            'loop_bias', 0.4e-3, 'A', 'current that the position loop starts from', -1.0, 1.0,
            'the stem leaves its closed stop at 0.401 mA'),
        Description(
            'loop_current_limits', (0.0, 0.6e-3), 'A', 'lowest and highest current of the '
            'position loop', -1.0, 1.0, 'below saturation of the E/P converter, 0.74 mA'),
        Description(
            'feedback', AUTO, '-', 'topics that are listened to: chamber_pressure and '
            'valve_position (plain), or their twins with a time stamp, whose records do not depend '
            'on when messages arrive; auto: stamped where a recording is asked for, else plain',
            -1.0, 1.0, 'the topics any positioner has, but for a recording',
            (AUTO, PLAIN, STAMPED)),
        Description(
            'wait_timeout', 30.0, 's', 'how long to wait for a positioner before giving up, in '
            'real time; 0: for ever', 0.0, _FOREVER, 'discovery takes seconds'),
        Description(
            'lockstep', False, '-', 'pause the positioner and advance it tick by tick, as fast as '
            'it goes, so that a run is repeatable', 0.0, 1.0, 'a controller runs in real time'),
        Description(
            'positioner', 'positioner', '-', 'name of the positioner node that lockstep advances',
            -1.0, 1.0, 'its default name'),
        Description(
            'record_csv', '', '-', 'CSV to record to', -1.0, 1.0, 'none'),
        Description(
            'record_bag', '', '-', 'folder of the rosbag2 bag to record to', -1.0, 1.0, 'none'),
        Description(
            'bag_format', MCAP, '-', 'how the bag is stored', -1.0, 1.0, 'the default of rosbag2',
            (MCAP, SQLITE3)),
    )
}
"""Every parameter of the fake controller by name."""


class ControllerSettings(NamedTuple):
    """The parameters of the fake controller, checked; names and units as in `DESCRIPTIONS`."""

    mode: str
    rate: float
    profile: str
    levels: tuple[float, ...]
    dwell: float
    low: float
    high: float
    stairs: int
    period: float
    frequencies: tuple[float, ...]
    cycles: int
    csv_file: str
    loop: bool
    keep_alive: bool
    loop_gain: float
    loop_integral_time: float
    loop_bias: float
    loop_current_limits: tuple[float, float]
    feedback: str
    wait_timeout: float
    lockstep: bool
    positioner: str
    record_csv: str
    record_bag: str
    bag_format: str

    @property
    def listens_to_stamped(self) -> bool:
        """Whether the outputs are taken from the topics with a time stamp."""
        records = bool(self.record_csv or self.record_bag)
        return self.feedback == STAMPED or (self.feedback == AUTO and records)


def checked(name: str, value: Any) -> Any:
    """Return one value as ROS 2 holds it; ParameterError where name, kind or range is wrong."""
    if name not in DESCRIPTIONS:
        raise ParameterError(unknown_name(name, DESCRIPTIONS))
    description = DESCRIPTIONS[name]
    if description.choices or not isinstance(description.default, (str, tuple)):
        return checked_as(description, value)
    if isinstance(description.default, str):
        if not isinstance(value, str):
            raise ParameterError(f'{name} must be a text, got {shown(value)}')
        return value
    if isinstance(value, (str, bytes)) or not hasattr(value, '__len__') or not len(value):
        raise ParameterError(f'{name} must be a list of numbers, got {shown(value)}')
    element = replace(description, default=0.0)
    return tuple(checked_as(element, item) for item in value)


def check(values: Mapping[str, Any]) -> ControllerSettings:
    """
    Return all settings from names and values; what is missing has its default.

    ParameterError, one sentence naming the parameter, for an unknown name, a wrong kind or range,
    and values that contradict each other.
    """
    defaults = {name: description.default for name, description in DESCRIPTIONS.items()}
    settings = ControllerSettings(**{
        name: checked(name, value) for name, value in (defaults | dict(values)).items()
    })
    _check_consistent(settings)
    return settings


def _check_consistent(settings: ControllerSettings) -> None:
    limits = settings.loop_current_limits
    if len(limits) != 2 or not limits[0] < limits[1]:
        raise ParameterError(f'loop_current_limits must be two rising values, got {list(limits)}')
    if settings.profile in (STAIRCASE, TRIANGLE, SINES) and not settings.low < settings.high:
        raise ParameterError(
            f'low ({settings.low:g}) must be below high ({settings.high:g})')
    if (settings.profile == CSV) != bool(settings.csv_file):
        raise ParameterError(
            f'csv_file goes with profile: csv, and profile is {settings.profile}'
            if settings.csv_file else 'profile: csv needs csv_file')
    if settings.loop and settings.lockstep:
        raise ParameterError('loop does not go with lockstep, which would never end')
    if settings.keep_alive and settings.lockstep:
        raise ParameterError('keep_alive does not go with lockstep, which runs as fast as it can')
