# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The model's equations integrated by scipy's Radau: slow, exact, and not our solver.

The equations are the model's own; the integrator, its step control and the search for the moments
at which a stem sticks and slips are scipy's.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import OptimizeResult

from ..model.simulation import active_states, settled_state
from ..model.system import (
    POSITION,
    STATE_NAMES,
    STATES,
    VELOCITY,
    PositionerParameters,
    breakaway_excess,
    derivatives,
    hold_inactive_states,
    net_stem_force,
    slip_direction,
    sticks,
)
from .cases import Case

# Absolute tolerance per relative tolerance: Pa, Pa, Pa, Pa, K, m, m/s.
SCALES = (1e4, 1e4, 1e4, 1e4, 10.0, 1e-2, 1.0)


def reference(case: Case, rtol: float = 1e-10) -> dict[str, np.ndarray]:
    """
    Return the states over the case's rows, by name.

    Dead time, hysteresis and sensors are outside the differential equations and not in here.
    """
    p = case.parameters
    y = settled_state(
        p,
        float(case.control_current[0]),
        case.initial.get('chamber_pressure', 0.0),
        case.initial.get('valve_position'),
        float(case.time[0]),
    )
    result = np.empty((len(case.time), STATES))
    result[0] = y
    direction = 0.0
    for first, last in _standing(case.control_current):
        current = float(case.control_current[first])
        direction = _integrate(
            p, current, direction, y, case.time[first:last + 1], result[first:last + 1], rtol)
        y[:] = result[last]
    return dict(zip(STATE_NAMES, result.T))


def _standing(current: np.ndarray) -> list[tuple[int, int]]:
    """Return first and last row of every stretch over which the current stands."""
    changes = np.flatnonzero(np.diff(current[:-1])) + 1
    edges = [0, *changes.tolist(), len(current) - 1]
    return list(pairwise(edges))


class _Regime:
    """The equations between two events: sliding one way, stuck, or without dry friction."""

    def __init__(
        self, p: PositionerParameters, current: float, direction: float, state: Sequence[float]
    ) -> None:
        stuck = sticks(p) and direction == 0.0
        self.moving = [s for s in active_states(p) if not (stuck and s in (POSITION, VELOCITY))]
        self._p, self._current, self._direction = p, current, direction
        self._start = list(state)
        if stuck:
            self._start[VELOCITY] = 0.0

    def full_state(self, time: float, moving: Sequence[float]) -> list[float]:
        full = list(self._start)
        for s, value in zip(self.moving, moving):
            full[s] = float(value)
        hold_inactive_states(self._p, time, full, ())
        return full

    def rates(self, time: float, moving: Sequence[float]) -> list[float]:
        rate = [0.0] * STATES
        full = self.full_state(time, moving)
        derivatives(self._p, time, self._current, self._direction, full, rate)
        return [rate[s] for s in self.moving]

    def end(self, time: float, moving: Sequence[float]) -> float:
        """Return what rises through zero when the stem stops sliding or breaks away."""
        full = self.full_state(time, moving)
        if self._direction != 0.0:
            return -full[VELOCITY] * self._direction
        return breakaway_excess(self._p, time, self._current, full)

    def next_direction(self, time: float, state: list[float]) -> float:
        """Return the direction of sliding after the end."""
        if self._direction != 0.0:
            state[VELOCITY] = 0.0
            return slip_direction(self._p, time, self._current, state)
        return 1.0 if net_stem_force(self._p, time, self._current, state) > 0.0 else -1.0

    def solve(self, time: float, until: np.ndarray, rtol: float) -> OptimizeResult:
        """Integrate from `time` to the last of `until`, or to the end of the regime."""
        def end(t: float, moving: Sequence[float]) -> float:
            return self.end(t, moving)

        end.terminal = True  # type: ignore[attr-defined]
        end.direction = 1.0  # type: ignore[attr-defined]
        return solve_ivp(
            self.rates, (time, until[-1]), [self._start[s] for s in self.moving], 'Radau',
            t_eval=until, rtol=rtol, atol=[rtol * SCALES[s] for s in self.moving],
            events=end if sticks(self._p) else None,
        )


def _integrate(
    p: PositionerParameters, current: float, direction: float, y: Sequence[float],
    time: np.ndarray, result: np.ndarray, rtol: float,
) -> float:
    """Fill `result[1:]` with the states at `time[1:]`; return the direction of sliding then."""
    now, state, row = float(time[0]), list(y), 1
    if sticks(p) and direction == 0.0:
        direction = slip_direction(p, now, current, state)
    while row < len(time):
        regime = _Regime(p, current, direction, state)
        solution = regime.solve(now, time[row:], rtol)
        for k, t in enumerate(solution.t):
            result[row] = regime.full_state(float(t), solution.y[:, k])
            row += 1
        if solution.status == 1:
            now = float(solution.t_events[0][0])
            state = regime.full_state(now, solution.y_events[0][0])
            direction = regime.next_direction(now, state)
    return direction
