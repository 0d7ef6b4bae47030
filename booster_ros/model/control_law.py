# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The control law: what the position controller does at each of its samples.

    i = bias + K (e + ∫ e dt/T_i) - K T_d dy/dt

K. J. Åström, T. Hägglund, Advanced PID Control, ISA, 2006: derivative of the measurement (ch. 3.4),
conditional integration (ch. 3.5). Dead zone, cut-offs and the pulses of on/off piezo valves are
what smart positioners have (IEC 61514-2).
"""

import math

from .ep_converter import play
from .position_controller import (
    AIR_TO_OPEN, PULSES, ControllerState, PositionController, opening_at, target_of)
from .sensors import lagged

CUT_OFF_HYSTERESIS = 0.005
"""How far, as a share of the signal, it must come back before a cut-off lets go."""

NEARLY = 1e-6
"""Share of a period within which a moment counts as that of a sample."""


def cut_off_of(c: PositionController, before: float, signal: float) -> float:
    """Return whether a signal (0 to 1) drives the process valve shut, -1, wide open, 1, or not."""
    shut = c.tight_shut_off + (CUT_OFF_HYSTERESIS if before < 0.0 else 0.0)
    wide = c.full_open - (CUT_OFF_HYSTERESIS if before > 0.0 else 0.0)
    if c.tight_shut_off > 0.0 and signal < shut:
        return -1.0
    if c.full_open < 1.0 and signal > wide:
        return 1.0
    return 0.0


def filtered(value: float, target: float, time_constant: float, period: float) -> float:
    """Return a first-order lag's output, one period (s) on, its input standing at `target`."""
    if time_constant <= 0.0:
        return target
    return target + (value - target) * math.exp(-period / time_constant)


def rate_limited(c: PositionController, before: float, target: float) -> float:
    """Return the set point, m, one period on from `before`, as fast as it may move."""
    if c.rate_limit_up > 0.0:
        target = min(target, before + c.rate_limit_up * c.period)
    if c.rate_limit_down > 0.0:
        target = max(target, before - c.rate_limit_down * c.period)
    return target


def quantised(value: float, step: float) -> float:
    """Return the multiple of `step` nearest to a value; the value itself where `step` is 0."""
    return (value / step + 0.5) // 1.0 * step if step > 0.0 else value


def seen_position(c: PositionController, position: float) -> float:
    """Return the position, m, that the controller sees where its linkage shows this one (m)."""
    return quantised(
        position * (1.0 + c.feedback_span_error) + c.feedback_bias, c.feedback_resolution)


def beyond_dead_zone(error: float, width: float) -> float:
    """Return what of an error is beyond a dead zone of ± `width`."""
    return error - min(max(error, -width), width)


def gain_of(c: PositionController) -> float:
    """Return the gain, A/m, as it is: the declared one and how far it is off."""
    return c.gain * math.exp(c.gain_change)


def integrated(c: PositionController, integral: float, error: float, damping: float) -> float:
    """
    Return the integral part, A, one period on.

    It stands still where the current is at a limit and the error drives it further. `error` in m,
    `damping` is the current that the velocity takes off, A.
    """
    if c.integral_time <= 0.0:
        return 0.0
    gain = gain_of(c)
    more = gain * error * c.period / (c.integral_time * math.exp(c.integral_time_change))
    wanted = c.bias + gain * error + integral + more - damping
    low, high = c.current_limits
    if (wanted > high and more > 0.0) or (wanted < low and more < 0.0):
        return integral
    return integral + more


def pulse(c: PositionController, current: float, wish: float) -> tuple[float, float]:
    """
    Return slope, A/s, and width, s, of the pulse that moves the current (A) by `wish` (A).

    It ends with the period at the latest, or where the current meets its limit.
    """
    low, high = c.current_limits
    room = max(high - current, 0.0) if wish > 0.0 else max(current - low, 0.0)
    width = min(abs(wish) / c.pulse_slew, c.period)
    if wish == 0.0 or width < c.least_pulse:
        return 0.0, 0.0
    return math.copysign(c.pulse_slew, wish), min(width, room / c.pulse_slew)


def ramp(time: float, width: float) -> float:
    """Return the integral over `time` (s) of a ramp of slope 1 that ends after `width` s, s²."""
    if time <= width:
        return 0.5 * time * time
    return width * (time - 0.5 * width)


def mean_current(current: float, slope: float, width: float, begin: float, end: float) -> float:
    """
    Return the mean current, A, from `begin` to `end` (s since a sample).

    At the sample it was `current` (A), from there it moves by `slope` (A/s) for `width` s.
    """
    if slope == 0.0:
        return current
    if end <= begin:
        return current + slope * min(begin, width)
    return current + slope * (ramp(end, width) - ramp(begin, width)) / (end - begin)


def driven(c: PositionController, cut_off: float) -> float:
    """Return the current, A, that drives the process valve shut (-1) or wide open (1)."""
    opens = cut_off > 0.0
    return c.current_limits[1 if opens == (c.action == AIR_TO_OPEN) else 0]


def sampled(
    c: PositionController, travel: float, state: ControllerState, set_point: float
) -> ControllerState:
    """Return the state after a sample at which the set point is `set_point` (m)."""
    first = filtered(state.filtered, set_point, c.set_point_lag, c.period)
    second = filtered(state.twice_filtered, first, c.set_point_second_lag, c.period)
    signal = opening_at(c, second, travel)
    followed = rate_limited(c, state.followed, target_of(c, second, travel))
    cut_off = cut_off_of(c, state.cut_off, signal)
    seen = seen_position(c, state.lagged_linkage)
    velocity = filtered(
        state.velocity, (seen - state.seen) / c.period, c.derivative_filter, c.period)
    error = beyond_dead_zone(followed - seen, c.dead_zone + c.added_dead_zone)
    gain = gain_of(c)
    damping = gain * c.derivative_time * velocity
    # what the last pulse has come to
    current, slope, width = state.current + state.slope * state.width, 0.0, 0.0
    integral = state.integral
    if c.output == PULSES:
        wish = 0.0 if error == 0.0 else gain * error - damping
        if cut_off != 0.0:
            wish = driven(c, cut_off) - current
        slope, width = pulse(c, current, wish)
    elif cut_off != 0.0:
        current = driven(c, cut_off)
    else:
        integral = integrated(c, integral, error, damping)
        wish = quantised(c.bias + gain * error + integral - damping, c.output_resolution)
        current = min(max(wish, c.current_limits[0]), c.current_limits[1])
    return ControllerState(
        state.due + c.period, current, slope, width, integral, first, second, followed, cut_off,
        state.linkage, state.lagged_linkage, seen, velocity)


def linkage_followed(
    c: PositionController, state: ControllerState, position: float, step: float
) -> ControllerState:
    """Return the state after `step` s at whose end the stem is at `position` (m)."""
    linkage = play(state.linkage, position, c.feedback_backlash)
    lag = lagged(state.lagged_linkage, state.linkage, linkage, c.feedback_lag, step)
    return ControllerState(
        state.due - step, state.current, state.slope, state.width, state.integral, state.filtered,
        state.twice_filtered, state.followed, state.cut_off, linkage, lag, state.seen,
        state.velocity)


def is_due(c: PositionController, state: ControllerState) -> bool:
    """Tell whether it is time for a sample."""
    return state.due <= NEARLY * c.period


def at_rest(
    c: PositionController, travel: float, set_point: float, position: float, current: float
) -> ControllerState:
    """
    Return the state of a controller that has long held the stem, with a sample due now.

    The set point (m) has stood, the stem is at `position` (m), and the integral part is such that
    the current, A, is the one that holds it there. Of all places in its play the linkage has the
    one at which the controller has least to correct.
    """
    integral = current - c.bias if c.integral_time > 0.0 else 0.0
    target, half = target_of(c, set_point, travel), 0.5 * c.feedback_backlash
    linkage = min(max(target, position - half), position + half)
    return ControllerState(
        0.0, current, 0.0, 0.0, integral, set_point, set_point, target, 0.0, linkage, linkage,
        seen_position(c, linkage), 0.0)
