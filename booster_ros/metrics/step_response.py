# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
What the position does after a step of the set point.

Terms of ISA-75.25.01 (dead time, step response time, travel gain, overshoot) and of the EnTech
Control Valve Dynamic Specification 3.0 (T63, T98); times count from the step.
"""

from typing import NamedTuple

import numpy as np

from .segments import Course, Level, rest_of, steps

Array = np.ndarray

SHARES = (0.632, 0.865, 0.98)
"""Shares of the final change of position that T63, T86 and T98 are the times of."""

NOISE_BAND = 4.0
"""Standard deviations of the noise beyond which a position has moved."""

LEAST_BAND = 0.01
"""Share of the final change within which a position has not moved yet."""

LEAST_MOTION = 0.1
"""Share of a step up to which a change of position is no answer to it: a stem that creeps on."""

SETTLED = 0.03
"""Share of the final change within which a settled position rests."""


class StepResponse(NamedTuple):
    """
    One step of the set point and its response; what cannot be told is None.

    Times in s, from `time` (s), the moment of the step. `size` is that of the step, m, `change`
    the final one of the position, m; `gain` is their ratio. `overshoot` is a share of `change`.
    `offset` is set point less position at the end, m. `first` and `last` are rows. A step that
    moves nothing has a `change` of 0.
    """

    time: float
    first: int
    last: int
    size: float
    change: float
    settled: bool
    dead_time: float | None
    t63: float | None
    t86: float | None
    t98: float | None
    overshoot: float | None
    gain: float | None
    offset: float | None


def step_responses(course: Course, found: list[Level], noise: float) -> list[StepResponse]:
    """Return the responses to all steps between levels; `noise` in m, see `noise_level`."""
    return [_response(course, before, after, noise) for before, after in steps(found)]


def _response(course: Course, before: Level, after: Level, noise: float) -> StepResponse:
    origin = float(np.mean(course.position[rest_of(course, before)]))
    rest = course.position[rest_of(course, after)]
    end = float(np.mean(rest))
    size, change = after.value - before.value, end - origin
    band = NOISE_BAND * noise
    moment = float(course.time[after.first])
    if abs(change) <= max(band, LEAST_MOTION * abs(size)):
        return StepResponse(moment, after.first, after.last, size, 0.0, True, None, None, None,
                            None, None, 0.0, after.value - end)
    settled = bool(
        np.ptp(course.position[rest_of(course, before)]) <= SETTLED * abs(change) + 2.0 * band
        and np.ptp(rest) <= SETTLED * abs(change) + 2.0 * band)
    rows = slice(after.first, after.last + 1)
    time = course.time[rows] - moment
    share = (course.position[rows] - origin) / change
    times = [_crossing(time, share, level) for level in SHARES]
    if (1.0 - SHARES[-1]) * abs(change) < 2.0 * noise:
        times[-1] = None  # noise crosses it, not the stem
    return StepResponse(
        moment, after.first, after.last, size, change, settled,
        _dead_time(time, share, max(band / abs(change), LEAST_BAND)),
        *(times if settled else (None,) * len(times)),  # type: ignore[call-arg]
        _overshoot(share, band / abs(change)) if settled else None,
        change / size if settled else None, after.value - end if settled else None)


def _crossing(time: Array, share: Array, level: float) -> float | None:
    """Return when a course first comes to a level, straight between rows; None if it does not."""
    above = np.flatnonzero(share >= level)
    if not len(above):
        return None
    k = int(above[0])
    if k == 0:
        return float(time[0])
    part = (level - share[k - 1]) / (share[k] - share[k - 1])
    return float(time[k - 1] + part * (time[k] - time[k - 1]))


def _dead_time(time: Array, share: Array, band: float) -> float | None:
    """Return until when the position, before it has gone 63 %, was within the band for the last."""
    there = np.flatnonzero(share >= SHARES[0])
    if not len(there) or band >= SHARES[0]:
        return None
    until = int(there[0])
    within = np.flatnonzero(share[:until + 1] <= band)
    if not len(within):
        return 0.0
    k = int(within[-1])
    part = (band - share[k]) / (share[k + 1] - share[k])
    return float(time[k] + part * (time[k + 1] - time[k]))


def _overshoot(share: Array, band: float) -> float:
    """Return by how much the position goes too far, 0 where that is within the noise."""
    beyond = float(np.max(share)) - 1.0
    return beyond if beyond > band else 0.0
