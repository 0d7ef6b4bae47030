# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The paper's open-loop step test, 0 → 0.4524 → 0 → 0.4524 mA, and what is read off it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .indices import StepIndices, step_indices, time_to_reach

STEP_CURRENT = 0.4524e-3
"""Section IV, A."""

DWELL = 4.0
"""How long a level stands, s; a step is held over several levels of the same height."""

REST = 4.0
"""How long the test waits at 0 mA before the first step, s."""

RESPONSE = 40.0
"""How long it holds a step, s: four settling times, after which 0.05 kPa are missing."""

VENTING = 12.0
"""How long it vents, s: the chamber is empty after less than 10 s."""

DURATION = REST + RESPONSE + VENTING + RESPONSE


def levels() -> list[float]:
    """Return the currents in A of the test, each of which stands for `DWELL`."""
    stretches = [(0.0, REST), (STEP_CURRENT, RESPONSE), (0.0, VENTING), (STEP_CURRENT, RESPONSE)]
    return [
        current for current, duration in stretches for _ in range(round(duration / DWELL))
    ]


class StepResponse(NamedTuple):
    """A chamber pressure (gauge, Pa) from the step on; its first row is the instant of the step."""

    time: np.ndarray
    pressure: np.ndarray

    def indices(self) -> StepIndices:
        """Return the four figures of Table III."""
        return step_indices(self.time, self.pressure)

    def delay(self) -> float:
        """Return how long the response takes to go the first hundredth of its way, s."""
        return time_to_reach(self.time, self.pressure, 0.01)


def upward_steps(
    time: np.ndarray, control_current: np.ndarray, chamber_pressure: np.ndarray
) -> list[StepResponse]:
    """
    Return the response to each upward step of a recorded test.

    Columns of a record (s, A, gauge Pa), NaN where a row does not have the value. A response ends
    with the next change of the current or with the record. ValueError for a step before which no
    pressure is known.
    """
    sent = np.isfinite(control_current)
    changes = np.flatnonzero(np.diff(control_current[sent]) != 0.0) + 1
    instants = time[sent][changes]
    before, after = control_current[sent][changes - 1], control_current[sent][changes]
    ends = np.append(instants[1:], np.inf)
    known = np.isfinite(chamber_pressure)
    upward = after > before
    return [
        _response(time[known], chamber_pressure[known], start, end)
        for start, end in zip(instants[upward], ends[upward], strict=True)
    ]


def _response(time: np.ndarray, pressure: np.ndarray, start: float, end: float) -> StepResponse:
    earlier = time <= start
    if not earlier.any():
        raise ValueError(f'no chamber_pressure is known before the step at {start:.3f} s')
    later = (time > start) & (time < end)
    return StepResponse(
        np.append(start, time[later]), np.append(pressure[earlier][-1], pressure[later])
    )
