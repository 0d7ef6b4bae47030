# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Indices of a step response, defined as for the paper's Table III.

Each takes the response alone: `time` in s, from the step on and rising, and `response` in any
unit, both of shape (n,). Between two rows the response is taken to be a straight line. The final
value is the last one, unless it is known better. ValueError where an index does not exist, which
is so for a response that never leaves its first value.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

RISE_FROM = 0.10
RISE_TO = 0.90
SETTLING_BAND = 0.05


class StepIndices(NamedTuple):
    """The four indices of Table III in its units: kPa, s, s, kPa² s."""

    final_pressure: float
    rise_time_10_90: float
    settling_time_5_percent: float
    integral_square_error: float


def step_indices(time: np.ndarray, pressure: np.ndarray) -> StepIndices:
    """Return the four indices of a pressure response in Pa; it must have settled at its end."""
    kilopascals = pressure / 1e3
    return StepIndices(
        float(kilopascals[-1]),
        rise_time(time, kilopascals),
        settling_time(time, kilopascals),
        integral_square_error(time, kilopascals),
    )


def rise_time(time: np.ndarray, response: np.ndarray, final: float | None = None) -> float:
    """Return the time in s from 10 % to 90 % of the way to the final value."""
    start = time_to_reach(time, response, RISE_FROM, final)
    return time_to_reach(time, response, RISE_TO, final) - start


def time_to_reach(
    time: np.ndarray, response: np.ndarray, share: float, final: float | None = None
) -> float:
    """Return the time in s until the response first is this share of the way to the final value."""
    progress = _progress(response, final)
    reached = np.flatnonzero(progress >= share)
    if len(reached) == 0:
        raise ValueError(f'the response does not reach {share:.0%} of its final value')
    after = int(reached[0])
    before = after - 1  # progress starts at 0, below any share
    into = (share - progress[before]) / (progress[after] - progress[before])
    return float(time[before] + into * (time[after] - time[before]) - time[0])


def settling_time(
    time: np.ndarray,
    response: np.ndarray,
    final: float | None = None,
    band: float = SETTLING_BAND,
) -> float:
    """
    Return the time in s after which the response stays in the band about the final value.

    The half-width of the band is `band` times the step's height.
    """
    distance = np.abs(1.0 - _progress(response, final))
    outside = np.flatnonzero(distance > band)
    if len(outside) == 0:
        return 0.0
    last = int(outside[-1])
    if last == len(time) - 1:
        raise ValueError('the response has not settled at its end')
    into = (distance[last] - band) / (distance[last] - distance[last + 1])
    return float(time[last] + into * (time[last + 1] - time[last]) - time[0])


def integral_square_error(
    time: np.ndarray, response: np.ndarray, final: float | None = None
) -> float:
    """
    Return ∫ (response − final)² dt, in the square of the response's unit times s.

    The paper calls it ISE and takes each curve, measured or simulated, against its own final
    value: it says how fast a response is, not how far two curves lie apart.
    """
    error = response - (response[-1] if final is None else final)
    # A line's square, integrated exactly.
    squares = (error[:-1] ** 2 + error[:-1] * error[1:] + error[1:] ** 2) / 3.0
    return float(np.sum(squares * np.diff(time)))


def _progress(response: np.ndarray, final: float | None) -> np.ndarray:
    """Return the response as a share of the step: 0 at its first value, 1 at the final value."""
    height = (response[-1] if final is None else final) - response[0]
    if not abs(height) > 0.0:
        raise ValueError('the response ends where it began, so it has no step indices')
    return np.asarray((response - response[0]) / height)
