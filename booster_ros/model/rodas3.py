# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The method for long steps: Rodas3, linearly implicit (Rosenbrock), of order 3.

A. Sandu et al., Atmospheric Environment 31 (1997) 3459. L-stable and stiffly accurate, with an
embedded solution of order 2. Stiff corners — end stops, pressure ratios near 1, small volumes —
cost it no small steps.
"""

import math

from .state import STATES
from .system import derivatives
from .undefined import infinite_where_undefined
from .workspace import TOLERANCE

ORDER = 3.0

# Increments for the numerical Jacobian, in the unit of each state.
INCREMENT = (0.1, 0.1, 0.1, 0.1, 1e-4, 1e-6, 1e-9, 1e-7, 1e-3)


def fill_jacobian(p, time, current, direction, y, active, count, w) -> None:
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


@infinite_where_undefined
def implicit_step(p, time, current, direction, y, h, active, count, w) -> float:
    """
    Try one step of length `h` from `y`; the result is in w.trial.

    Return the error estimate relative to the tolerance, infinite where the step leads to no value.
    w.rates and w.jacobian hold the derivatives at `y`.
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
    error, total = 0.0, 0.0
    for i in range(count):
        state = active[i]
        w.trial[state] += w.k4[i]
        one = abs(w.k4[i]) / TOLERANCE[state]
        error = max(error, one)
        total += one
    return error if total == total else math.inf  # `max` does not see NaN
