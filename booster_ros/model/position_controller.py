# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Position controller: its parameters and state, and what a set point or signal asks for."""

from typing import Annotated, NamedTuple

from .quantity import Quantity

CONTINUOUS, PULSES = range(2)
OUTPUTS = ('continuous', 'pulses')
LINEAR, EQUAL_PERCENTAGE, TABLE = range(3)
CHARACTERISTICS = ('linear', 'equal_percentage', 'table')
AIR_TO_OPEN, AIR_TO_CLOSE = range(2)
ACTIONS = ('air_to_open', 'air_to_close')

POINTS = 11
"""Openings in the table of a characteristic, at every tenth of the signal."""

FINEST = 2.0**-14
"""What a positioner's converter resolves of the travel at the best, 14 bits."""

_NONE = 'neutral: none'


class PositionController(NamedTuple):
    """The controller of a positioner that holds its position, and what it sees of the stem."""

    enabled: Annotated[bool, Quantity(
        '-', 'the set point is commanded, and the controller makes the control current of it',
        0.0, 1.0, 'the paper is open loop')] = False
    output: Annotated[int, Quantity(
        '-', 'what the current does: it follows the equation, or is moved by pulses whose width '
        'follows it', 0.0, 1.0, 'one that a coil has')] = CONTINUOUS
    gain: Annotated[float, Quantity(
        'A/m', 'K: current per error of position', 0.0, 1e4,
        'tuned, see config/closed_loop.yaml')] = 0.17
    integral_time: Annotated[float, Quantity(
        's', 'T_i: of the integral part, 0 = none; pulses integrate anyway', 0.0, 1e6,
        'tuned, see config/closed_loop.yaml')] = 4.2
    derivative_time: Annotated[float, Quantity(
        's', 'T_d: velocity feedback', 0.0, 1e3, 'tuned, see config/closed_loop.yaml')] = 0.0
    derivative_filter: Annotated[float, Quantity(
        's', 'time constant of the lag on the velocity, 0 = none', 0.0, 1e3, _NONE)] = 0.0
    bias: Annotated[float, Quantity(
        'A', 'current at no error, beside the integral part', -1.0, 1.0,
        'holds the declared stem at mid travel')] = 0.4325e-3
    current_limits: Annotated[tuple[float, float], Quantity(
        'A', 'lowest and highest current', -1.0, 1.0,
        'the converter saturates at 0.74 mA')] = (0.0, 0.74e-3)
    dead_zone: Annotated[float, Quantity(
        'm', 'error that is ignored; of a larger one what is beyond counts', 0.0, 1.0,
        _NONE)] = 0.0
    period: Annotated[float, Quantity(
        's', 'time from one sample to the next', 1e-4, 10.0, 'assumed')] = 0.01
    pulse_slew: Annotated[float, Quantity(
        'A/s', 'change of the current during a pulse', 1e-9, 1e3, 'assumed')] = 1e-3
    least_pulse: Annotated[float, Quantity(
        's', 'shortest pulse; a shorter one is left out', 0.0, 1.0,
        'assumed: a piezo valve opens in 1 to 2 ms')] = 2e-3
    output_resolution: Annotated[float, Quantity(
        'A', 'steps of a continuous current, 0 = none', 0.0, 1e-2, _NONE)] = 0.0
    feedback_resolution: Annotated[float, Quantity(
        'm', 'steps of the position that it sees, 0 = none', 0.0, 0.1, _NONE)] = 0.0
    feedback_backlash: Annotated[float, Quantity(
        'm', 'feedback_backlash: lost motion of the linkage through which it sees the stem', 0.0,
        1.0, _NONE)] = 0.0
    feedback_lag: Annotated[float, Quantity(
        's', 'time constant of the lag in what it sees, 0 = none', 0.0, 60.0, _NONE)] = 0.0
    feedback_span_error: Annotated[float, Quantity(
        '-', 'relative error of the span of what it sees', -0.9, 10.0, _NONE)] = 0.0
    feedback_bias: Annotated[float, Quantity(
        'm', 'added to what it sees', -1.0, 1.0, _NONE)] = 0.0
    set_point_lag: Annotated[float, Quantity(
        's', 'time constant of the filter on the set point, 0 = none', 0.0, 1e3, _NONE)] = 0.0
    set_point_second_lag: Annotated[float, Quantity(
        's', 'time constant of a second filter behind the first, 0 = none', 0.0, 1e3,
        _NONE)] = 0.0
    rate_limit_up: Annotated[float, Quantity(
        'm/s', 'slew_limit: fastest rise of the set point that is followed, 0 = any', 0.0, 1e3,
        _NONE)] = 0.0
    rate_limit_down: Annotated[float, Quantity(
        'm/s', 'slew_limit: fastest fall of the set point that is followed, 0 = any', 0.0, 1e3,
        _NONE)] = 0.0
    action: Annotated[int, Quantity(
        '-', 'what air does to the process valve: whether its opening rises with the position of '
        'the stem', 0.0, 1.0, 'the paper: air opens')] = AIR_TO_OPEN
    signal_range: Annotated[tuple[float, float], Quantity(
        'A', 'loop current at which the process valve is to be closed, and wide open', -1.0, 1.0,
        'IEC 60381-1')] = (4e-3, 20e-3)
    characteristic: Annotated[int, Quantity(
        '-', 'opening of the process valve over the signal', 0.0, 2.0, 'as wired')] = LINEAR
    rangeability: Annotated[float, Quantity(
        '-', 'R of the equal percentage characteristic', 1.001, 1e4, 'IEC 60534-2-4: 50')] = 50.0
    characteristic_table: Annotated[tuple[float, ...], Quantity(
        '-', f'openings at {POINTS} signals from 0 to 1, of the characteristic by table', 0.0, 1.0,
        'a straight line')] = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
    tight_shut_off: Annotated[float, Quantity(
        '-', 'signal below which the process valve is driven shut, 0 = none', 0.0, 0.5,
        _NONE)] = 0.0
    full_open: Annotated[float, Quantity(
        '-', 'signal above which the process valve is driven wide open, 1 = none', 0.5, 1.0,
        _NONE)] = 1.0
    added_dead_zone: Annotated[float, Quantity(
        'm', 'positioner_dead_zone: added to dead_zone', 0.0, 1.0, _NONE)] = 0.0
    gain_change: Annotated[float, Quantity(
        '-', 'positioner_tuning: natural logarithm of what gain is multiplied by', -5.0, 5.0,
        _NONE)] = 0.0
    integral_time_change: Annotated[float, Quantity(
        '-', 'positioner_tuning: natural logarithm of what integral_time is multiplied by', -5.0,
        5.0, _NONE)] = 0.0


class ControllerState(NamedTuple):
    """
    What the controller remembers.

    `due` is the time until the next sample, s. The current was `current` (A) at the last sample,
    and has moved by `slope` (A/s) for `width` s since. `integral` is the integral part, A;
    `filtered` and `twice_filtered` are the set point (m) behind the filters, `followed` behind
    characteristic and rate limit. `cut_off` is -1 where the process valve is driven shut, 1 where
    it is driven wide open, else 0. `linkage` and `lagged_linkage` (m) are the stem seen through
    play and lag; at the last sample it was seen at `seen` (m), moving at `velocity` (m/s).
    """

    due: float
    current: float
    slope: float
    width: float
    integral: float
    filtered: float
    twice_filtered: float
    followed: float
    cut_off: float
    linkage: float
    lagged_linkage: float
    seen: float
    velocity: float


def set_point_of(c: PositionController, signal: float, travel: float) -> float:
    """Return the set point, m, that a loop current (A) means."""
    low, high = c.signal_range
    return position_of(c, (signal - low) / (high - low), travel)


def position_of(c: PositionController, opening: float, travel: float) -> float:
    """Return the position of the stem, m, at which the process valve is this far open (0 to 1)."""
    return travel * (1.0 - opening if c.action == AIR_TO_CLOSE else opening)


def opening_at(c: PositionController, position: float, travel: float) -> float:
    """Return how far open, 0 to 1, the process valve is at a position of the stem, m."""
    share = position / travel
    return 1.0 - share if c.action == AIR_TO_CLOSE else share


def characterised(c: PositionController, signal: float) -> float:
    """
    Return the opening that a signal (0 to 1) asks for.

    Equal percentage through the origin: (R^s - 1)/(R - 1), with the exponent of IEC 60534-2-4.
    """
    if c.characteristic == LINEAR:
        return signal
    inside = min(max(signal, 0.0), 1.0)
    if c.characteristic == EQUAL_PERCENTAGE:
        return (c.rangeability**inside - 1.0) / (c.rangeability - 1.0)
    place = inside * (POINTS - 1.0)
    left = min(int(place), POINTS - 2)
    share = place - left
    return c.characteristic_table[left] * (1.0 - share) + c.characteristic_table[left + 1] * share


def target_of(c: PositionController, set_point: float, travel: float) -> float:
    """Return the position, m, that a set point (m) asks for by way of the characteristic."""
    if c.characteristic == LINEAR:
        return set_point
    return position_of(c, characterised(c, opening_at(c, set_point, travel)), travel)
