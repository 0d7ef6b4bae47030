# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
What users would integrate the model with instead: scipy, SUNDIALS, a Runge-Kutta loop.

Each peer solves a case and returns back pressure, chamber pressure, position and velocity at its
rows, shape (rows, 4). All but `stick_slip_peer` know no dry friction. All evaluate the model's own
`derivatives`, compiled by numba unless the name says Python, and start anew wherever the current
changes unless told not to.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import Any

import numba
import numpy as np
from scipy.integrate import solve_ivp

from ..model import system
from ..model.compiled import compiled_modules
from ..model.state import BACK, CHAMBER, POSITION, STATE_NAMES, STATES, VELOCITY
from ..model.stream import settled_state
from ..model.system import PositionerParameters
from .cases import Case
from .reference import Integrator, Piece, reference

MOVING = np.array([BACK, CHAMBER, POSITION, VELOCITY])
SCALES = np.array([1e4, 1e4, 1e-2, 1.0])
"""Absolute tolerance per relative tolerance: Pa, Pa, m, m/s."""

Rates = Callable[..., None]


def _rates_of(derivatives: Any) -> Rates:
    """Return f(p, current, moving states, full state, full rates, moving rates)."""
    def rates(p, current, z, y, full, out):  # type: ignore[no-untyped-def]
        for i in range(4):
            y[MOVING[i]] = z[i]
        derivatives(p, 0.0, current, 0.0, y, full)
        for i in range(4):
            out[i] = full[MOVING[i]]
    return rates


def machine_rates() -> Rates:
    """Return the model's derivatives as machine code."""
    modules = compiled_modules()
    assert modules is not None
    return numba.njit(error_model='numpy')(_rates_of(modules['system']['derivatives']))


def python_rates() -> Rates:
    """Return the model's derivatives in plain Python."""
    return _rates_of(system.derivatives)


def start(case: Case) -> np.ndarray:
    """Return the state in which a case begins."""
    first = float(case.control_current[0])
    return np.array(settled_state(
        case.parameters, first, case.initial.get('chamber_pressure', 0.0),
        case.initial.get('valve_position')))


def _pieces(case: Case, restart: bool) -> Iterator[tuple[slice, Callable[[float], float]]]:
    """
    Yield stretches of rows, both ends included, and their current as a function of time.

    With `restart` a stretch ends where the current changes, else there is one stretch only.
    """
    current = case.control_current
    if not restart:
        row = (case.time[-1] - case.time[0]) / (len(case.time) - 1)
        yield slice(None), lambda t: current[
            min(int((t - case.time[0]) / row + 1e-9), len(current) - 1)]
        return
    edges = [0, *(np.flatnonzero(np.diff(current[:-1])) + 1).tolist(), len(current) - 1]
    for first, last in pairwise(edges):
        level = float(current[first])
        yield slice(first, last + 1), lambda _, level=level: level  # type: ignore[misc]


def scipy_peer(
    method: str, rates: Rates, restart: bool = True
) -> Callable[[Case, float], np.ndarray]:
    """Return a run of `solve_ivp` at a relative tolerance."""
    def run(case: Case, rtol: float) -> np.ndarray:
        y, full = start(case), np.zeros(STATES)
        result = np.empty((len(case.time), 4))
        z = y[MOVING]

        def with_current(current: Callable[[float], float]) -> Callable[..., np.ndarray]:
            def f(t: float, z: np.ndarray) -> np.ndarray:
                out = np.empty(4)
                rates(case.parameters, current(t), z, y, full, out)
                return out
            return f

        for rows, current in _pieces(case, restart):
            t = case.time[rows]
            solution = solve_ivp(
                with_current(current), (t[0], t[-1]), z, method, t_eval=t,
                rtol=rtol, atol=rtol * SCALES)
            result[rows] = solution.y.T
            z = solution.y[:, -1]
        return result
    return run


def cvode_integrator() -> Integrator:
    """Return the integration by CVODE and its own search for events."""
    from sksundae.cvode import CVODE

    def integrate(rates, end, time, until, start, rtol, atol):  # type: ignore[no-untyped-def]
        def f(t: float, z: np.ndarray, out: np.ndarray) -> None:
            out[:] = rates(t, z)

        def event(t: float, z: np.ndarray, out: np.ndarray) -> None:
            out[0] = end(t, z)

        event.terminal, event.direction = [True], [1]  # type: ignore[attr-defined]
        solver = CVODE(
            f, rtol=rtol, atol=np.array(atol), max_num_steps=10**6,
            **({'eventsfn': event, 'num_events': 1} if end else {}))
        found = solver.solve(np.array([time, *until]), np.array(start))
        ended = found.status == 2
        rows = np.isin(found.t[1:], until)  # between two moments it returns all its steps
        return Piece(found.y[1:][rows], (float(found.t[-1]), found.y[-1]) if ended else None)
    return integrate


def stick_slip_peer(integrate: Integrator) -> Callable[[Case, float], np.ndarray]:
    """
    Return a run at a relative tolerance that finds where a stem sticks and slips.

    The search for events is the integrator's; which equations hold between two is in `reference`.
    """
    modules = compiled_modules()
    assert modules is not None
    derivatives = modules['system']['derivatives']

    @numba.njit(error_model='numpy')
    def machine(p, time, current, direction, y, out):  # type: ignore[no-untyped-def]
        derivatives(p, time, current, direction, y, out)

    state, rate = np.zeros(STATES), np.zeros(STATES)

    def rates(
        p: PositionerParameters, time: float, current: float, direction: float, y: list[float],
        out: list[float],
    ) -> None:
        state[:] = y
        machine(p, time, current, direction, state, rate)
        out[:] = rate.tolist()

    def run(case: Case, rtol: float) -> np.ndarray:
        states = reference(case, rtol, integrate, rates)
        return np.stack([states[STATE_NAMES[s]] for s in MOVING], axis=1)
    return run


def cvode_peer(rates: Rates, restart: bool = True) -> Callable[[Case, float], np.ndarray]:
    """Return a run of SUNDIALS' CVODE (BDF, dense Newton) at a relative tolerance."""
    from sksundae.cvode import CVODE

    def run(case: Case, rtol: float) -> np.ndarray:
        y, full = start(case), np.zeros(STATES)
        result = np.empty((len(case.time), 4))
        z = y[MOVING]

        def with_current(current: Callable[[float], float]) -> Rates:
            def f(t: float, z: np.ndarray, out: np.ndarray) -> None:
                rates(case.parameters, current(t), z, y, full, out)
            return f

        for rows, current in _pieces(case, restart):
            solver = CVODE(
                with_current(current), rtol=rtol, atol=rtol * SCALES, max_num_steps=10**6)
            t = case.time[rows]
            found = np.array(solver.solve(t, z).y)
            # asked for two moments only, it returns all its steps in between
            result[rows] = found if len(t) > 2 else found[[0, -1]]
            z = found[-1]
        return result
    return run


def runge_kutta_peer(rates: Rates) -> Callable[[Case, float], np.ndarray]:
    """Return a run of the classical explicit method of order 4, all in machine code, at a step."""
    @numba.njit(error_model='numpy')
    def loop(p, rows, parts, current, y, z, result):  # type: ignore[no-untyped-def]
        full = np.zeros(STATES)
        k1, k2, k3, k4 = np.empty(4), np.empty(4), np.empty(4), np.empty(4)
        for k in range(len(rows)):
            result[k] = z
            if k + 1 == len(rows):
                break
            h = (rows[k + 1] - rows[k]) / parts
            for _ in range(parts):
                rates(p, current[k], z, y, full, k1)
                rates(p, current[k], z + 0.5 * h * k1, y, full, k2)
                rates(p, current[k], z + 0.5 * h * k2, y, full, k3)
                rates(p, current[k], z + h * k3, y, full, k4)
                z = z + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)

    def run(case: Case, step: float) -> np.ndarray:
        y = start(case)
        result = np.empty((len(case.time), 4))
        parts = round((case.time[1] - case.time[0]) / step)
        loop(case.parameters, case.time, parts, case.control_current, y, y[MOVING], result)
        return result
    return run
