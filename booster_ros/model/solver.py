# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The solver: Rodas3 with error-controlled sub-steps, and dry friction that sticks.

Rodas3 is a linearly implicit (Rosenbrock) method of order 3, L-stable and stiffly accurate, with
an embedded solution of order 2 (A. Sandu et al., Atmospheric Environment 31 (1997) 3459). Stiff
corners — end stops, pressure ratios near 1, small volumes — cost it no small steps.

One call of `advance` takes the state over one interval in which all inputs stand still:

1. try a step; where the embedded error exceeds the tolerance, shorten it and try again;
2. a sliding stem whose velocity would change sign is stopped at the crossing, exactly at zero,
   and stays there while the force on it is below the break-away friction;
3. a stuck stem whose force passes the break-away friction starts to slide at that moment.

The functions work on lists (plain Python) and on numpy arrays (compiled) alike.
"""

import math
from typing import NamedTuple

from .system import (
    CHAMBER, DIRECTION, STATES, TRIAL_STEP, VELOCITY, PositionerParameters, breakaway_excess,
    derivatives, slip_direction, sticks)

FINEST_DIVISION = 4000.0
"""Sub-steps are not made shorter than the interval by this, whatever the error estimate says."""

SHORTEST_EVENT = 1e-7
"""A step to where sticking or sliding ends is at least this long, s: time must pass."""

FIRST_SLIP_STEP = 1e-5
"""Trial step after break-away, s: stiction fades within micrometres, too fast for long steps."""

EVENT_VELOCITY = 1e-7
EVENT_FORCE = 1e-3
EVENT_TRIALS = 8
"""Velocity (m/s) or force (N) at which an end of sliding or sticking counts as found, trials."""

# Error per sub-step that is tolerated: Pa, Pa, Pa, Pa, K, m, m/s.
TOLERANCE = (2.0, 2.0, 2.0, 2.0, 1e-2, 1e-7, 1e-5)

# Increments for the numerical Jacobian, in the unit of each state.
INCREMENT = (0.1, 0.1, 0.1, 0.1, 1e-4, 1e-9, 1e-7)


class Workspace(NamedTuple):
    """Scratch memory of the solver: lists of floats, or float arrays where compiled."""

    rates: list[float]
    stage_rates: list[float]
    trial: list[float]
    k1: list[float]
    k2: list[float]
    k3: list[float]
    k4: list[float]
    jacobian: list[float]
    matrix: list[float]


def new_workspace() -> Workspace:
    """Return scratch memory for plain Python."""
    return Workspace(*([0.0] * STATES for _ in range(7)), *([0.0] * STATES**2 for _ in range(2)))


def _jacobian(p, time, current, direction, y, active, count, w) -> None:
    """Fill w.jacobian with d(rate)/d(state) of the active states, by forward differences."""
    for j in range(count):
        state = active[j]
        kept = y[state]
        y[state] = kept + INCREMENT[state]
        derivatives(p, time, current, direction, y, w.stage_rates)
        y[state] = kept
        inverse = 1.0 / INCREMENT[state]
        for i in range(count):
            row = active[i]
            w.jacobian[i * STATES + j] = (w.stage_rates[row] - w.rates[row]) * inverse


def _factorise(jacobian, scale, count, matrix) -> None:
    """Put the LU factors of (scale·1 - jacobian) in `matrix`; the diagonal holds inverses."""
    for i in range(count):
        for j in range(count):
            matrix[i * STATES + j] = -jacobian[i * STATES + j]
        matrix[i * STATES + i] += scale
    for k in range(count):
        inverse = 1.0 / matrix[k * STATES + k]
        matrix[k * STATES + k] = inverse
        for i in range(k + 1, count):
            factor = matrix[i * STATES + k] * inverse
            matrix[i * STATES + k] = factor
            if factor != 0.0:
                for j in range(k + 1, count):
                    matrix[i * STATES + j] -= factor * matrix[k * STATES + j]


def _solve(matrix, count, b) -> None:
    """Replace `b` by the solution of (factorised matrix) x = b."""
    for i in range(1, count):
        total = b[i]
        for j in range(i):
            total -= matrix[i * STATES + j] * b[j]
        b[i] = total
    for i in range(count - 1, -1, -1):
        total = b[i]
        for j in range(i + 1, count):
            total -= matrix[i * STATES + j] * b[j]
        b[i] = total * matrix[i * STATES + i]


def _rodas3(p, time, current, direction, y, h, active, count, w) -> float:
    """
    Try one step of length `h` from `y`; the result is in w.trial.

    Return the error estimate relative to the tolerance. w.rates and w.jacobian hold the
    derivatives at `y`.
    """
    _factorise(w.jacobian, 2.0 / h, count, w.matrix)
    for i in range(count):
        w.k1[i] = w.rates[active[i]]
    _solve(w.matrix, count, w.k1)
    for i in range(count):
        w.k2[i] = w.rates[active[i]] + 4.0 / h * w.k1[i]
    _solve(w.matrix, count, w.k2)
    for i in range(STATES):
        w.trial[i] = y[i]
    for i in range(count):
        w.trial[active[i]] += 2.0 * w.k1[i]
    derivatives(p, time, current, direction, w.trial, w.stage_rates)
    for i in range(count):
        w.k3[i] = w.stage_rates[active[i]] + (w.k1[i] - w.k2[i]) / h
    _solve(w.matrix, count, w.k3)
    for i in range(count):
        w.trial[active[i]] += w.k3[i]
    derivatives(p, time, current, direction, w.trial, w.stage_rates)
    for i in range(count):
        w.k4[i] = w.stage_rates[active[i]] + (w.k1[i] - w.k2[i] - 8.0 / 3.0 * w.k3[i]) / h
    _solve(w.matrix, count, w.k4)
    error = 0.0
    for i in range(count):
        state = active[i]
        w.trial[state] += w.k4[i]
        error = max(error, abs(w.k4[i]) / TOLERANCE[state])
    return error


def _step_factor(error: float) -> float:
    """Return by what to multiply the step for an error just within the tolerance."""
    return min(max(0.9 * (max(error, 1e-9)) ** (-1.0 / 3.0), 0.2), 5.0)


def _event(p, time, current, direction, y) -> float:
    """
    Return a quantity that rises through zero when the stem's regime ends.

    While sliding: velocity against the direction, m/s. While stuck: force beyond break-away, N, by
    so much that a stem which is found there does slide.
    """
    if direction != 0.0:
        return -y[VELOCITY] * direction
    return breakaway_excess(p, time, current, y) - EVENT_FORCE


def _step_to_event(p, time, current, direction, y, step, active, count, w) -> float:
    """
    Shorten the step so that it ends where the regime does; the result is in w.trial.

    False position with the Illinois weights: stick-slip is sensitive to when and where the stem
    stops, so the crossing is found far better than a step's error.
    """
    early, before = 0.0, _event(p, time, current, direction, y)
    late, after = step, _event(p, time, current, direction, w.trial)
    enough = EVENT_VELOCITY if direction != 0.0 else EVENT_FORCE
    middle = late
    for _ in range(EVENT_TRIALS if before < 0.0 else 0):
        middle = early + (late - early) * before / (before - after)
        _rodas3(p, time, current, direction, y, middle, active, count, w)
        value = _event(p, time, current, direction, w.trial)
        if abs(value) < enough:
            break
        if value > 0.0:
            late, after = middle, value
            before *= 0.5
        else:
            early, before = middle, value
            after *= 0.5
    if before >= 0.0 or middle < SHORTEST_EVENT:
        middle = SHORTEST_EVENT
        _rodas3(p, time, current, direction, y, middle, active, count, w)
    return middle


def advance(
    p: PositionerParameters, time: float, current: float, length: float, y, memory,
    active, count: int, tolerance: float, w: Workspace,
) -> None:
    """
    Take the state `y` from `time` over `length` s of standing inputs, in place.

    `active[:count]` are the states to integrate in rising order, the others stand still;
    `tolerance` multiplies `TOLERANCE` (infinite: one step however large the error).
    """
    smallest = length / FINEST_DIVISION
    dry = sticks(p) and count > 0 and active[count - 1] == VELOCITY
    left = length
    while left > 0.0:
        direction = 0.0
        moving = count
        if dry:
            if memory[DIRECTION] == 0.0:
                memory[DIRECTION] = slip_direction(p, time, current, y)
                if memory[DIRECTION] != 0.0:
                    memory[TRIAL_STEP] = FIRST_SLIP_STEP
            direction = memory[DIRECTION]
            if direction == 0.0:
                y[VELOCITY] = 0.0
                moving = count - 2
        derivatives(p, time, current, direction, y, w.rates)
        _jacobian(p, time, current, direction, y, active, moving, w)
        step = min(memory[TRIAL_STEP], left)
        tried = step
        error = _rodas3(p, time, current, direction, y, step, active, moving, w)
        while not error <= tolerance and step > smallest:
            step = max(step * min(_step_factor(error / tolerance), 0.5), smallest)
            error = _rodas3(p, time, current, direction, y, step, active, moving, w)
        if math.isnan(error):
            y[CHAMBER] = math.nan  # nothing sensible can follow; do not creep on with tiny steps
            return
        whole = step == tried
        proposal = step * _step_factor(error / tolerance)

        landed = False
        if direction != 0.0 and w.trial[VELOCITY] * direction <= 0.0:
            landed = True
            if y[VELOCITY] * direction > 0.0:
                step = _step_to_event(p, time, current, direction, y, step, active, moving, w)
            else:
                # it would not even get going: stuck over this step, though barely
                _rodas3(p, time, current, 0.0, y, step, active, count - 2, w)
        elif dry and direction == 0.0 and breakaway_excess(p, time, current, w.trial) > 0.0:
            step = _step_to_event(p, time, current, direction, y, step, active, moving, w)

        for i in range(STATES):
            y[i] = w.trial[i]
        if landed:
            y[VELOCITY] = 0.0
            memory[DIRECTION] = 0.0
        # a step cut short by an event or by the end of the interval says nothing against long ones
        memory[TRIAL_STEP] = max(proposal, memory[TRIAL_STEP]) if whole else proposal
        left = left - step if left - step > 1e-12 * length else 0.0
        time += step
