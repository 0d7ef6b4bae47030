# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The model's equations integrated by scipy's Radau: slow, exact, and not our solver.

The equations are the model's own; the integrator, its step control and the search for the moments
at which a stem sticks and slips are scipy's.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from ..model.simulation import active_states, settled_state
from ..model.state import POSITION, STATE_NAMES, STATES, VELOCITY
from ..model.sticking import breakaway_excess, slip_direction, sticks
from ..model.system import PositionerParameters, derivatives, hold_inactive_states, net_stem_force
from .cases import Case

# Absolute tolerance per relative tolerance: Pa, Pa, Pa, Pa, K, -, m, m/s, N.
SCALES = (1e4, 1e4, 1e4, 1e4, 10.0, 1.0, 1e-2, 1.0, 100.0)


Rates = Callable[[PositionerParameters, float, float, float, list[float], list[float]], None]


class Piece(NamedTuple):
    """States at the moments that were reached, and moment and state of the event that ended it."""

    states: Sequence[np.ndarray]
    event: tuple[float, np.ndarray] | None


Integrator = Callable[
    [Callable[..., list[float]], Callable[..., float] | None, float, np.ndarray, list[float],
     float, list[float]], Piece]
"""
Integrates rates(t, z) to the given moments, or to where an event function rises through zero.

Arguments: rates, event function or None, start, moments, states at the start, tolerances.
"""


def scipy_integrator(method: str) -> Integrator:
    """Return the integration by a method of `solve_ivp`."""
    def integrate(rates, end, time, until, start, rtol, atol):  # type: ignore[no-untyped-def]
        def event(t: float, z: np.ndarray) -> float:
            return end(t, z)

        event.terminal = True  # type: ignore[attr-defined]
        event.direction = 1.0  # type: ignore[attr-defined]
        found = solve_ivp(
            rates, (time, until[-1]), start, method, t_eval=until, rtol=rtol, atol=atol,
            events=event if end else None)
        ended = found.status == 1
        return Piece(
            found.y.T if len(found.t) else [],
            (float(found.t_events[0][0]), found.y_events[0][0]) if ended else None)
    return integrate


def reference(
    case: Case, rtol: float = 1e-10, integrate: Integrator | None = None,
    rates: Rates = derivatives,
) -> dict[str, np.ndarray]:
    """
    Return the states over the case's rows, by name.

    By Radau unless told to `integrate` otherwise; `rates` is the model's `derivatives` or what
    gives the same. Dead time, hysteresis and sensors are outside the differential equations.
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
            p, current, direction, y, case.time[first:last + 1], result[first:last + 1], rtol,
            integrate or scipy_integrator('Radau'), rates)
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
        self, p: PositionerParameters, current: float, direction: float, state: Sequence[float],
        derivatives: Rates,
    ) -> None:
        stuck = sticks(p) and direction == 0.0
        self.moving = [s for s in active_states(p) if not (stuck and s in (POSITION, VELOCITY))]
        self._p, self._current, self._direction = p, current, direction
        self._derivatives = derivatives
        self._start = list(state)
        if stuck:
            self._start[VELOCITY] = 0.0

    @property
    def start(self) -> list[float]:
        """The moving states at the start."""
        return [self._start[s] for s in self.moving]

    def full_state(self, time: float, moving: Sequence[float] | np.ndarray) -> list[float]:
        full = list(self._start)
        for s, value in zip(self.moving, moving):
            full[s] = float(value)
        hold_inactive_states(self._p, time, full, ())
        return full

    def rates(self, time: float, moving: Sequence[float]) -> list[float]:
        rate = [0.0] * STATES
        full = self.full_state(time, moving)
        self._derivatives(self._p, time, self._current, self._direction, full, rate)
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


def _integrate(
    p: PositionerParameters, current: float, direction: float, y: Sequence[float],
    time: np.ndarray, result: np.ndarray, rtol: float, integrate: Integrator,
    rates: Rates,
) -> float:
    """Fill `result[1:]` with the states at `time[1:]`; return the direction of sliding then."""
    now, state, row = float(time[0]), list(y), 1
    if sticks(p) and direction == 0.0:
        direction = slip_direction(p, now, current, state)
    while row < len(time):
        regime = _Regime(p, current, direction, state, rates)
        piece = integrate(
            regime.rates, regime.end if sticks(p) else None, now, time[row:], regime.start, rtol,
            [rtol * SCALES[s] for s in regime.moving])
        for z in piece.states:
            result[row] = regime.full_state(float(time[row]), z)
            row += 1
        if piece.event is not None:
            now = piece.event[0]
            state = regime.full_state(*piece.event)
            direction = regime.next_direction(now, state)
    return direction
