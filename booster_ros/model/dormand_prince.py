# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The method for short steps: the explicit Runge-Kutta pair of orders 5 and 4.

J. R. Dormand and P. J. Prince, Journal of Computational and Applied Mathematics 6 (1980) 19. Its
last stage is evaluated at the result, so that a next step can take over those rates.
"""

import math

from .state import STATES
from .system import derivatives
from .undefined import infinite_where_undefined
from .workspace import TOLERANCE

ORDER = 5.0

_NODES = (0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0)
_WEIGHTS = (
    (0.2, 0.0, 0.0, 0.0, 0.0, 0.0),
    (3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0),
    (44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0),
    (19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0),
    (9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0.0),
    (35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0),
)
# the result of order 5 less the embedded one of order 4
_ERROR = (71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339200.0,
          22.0 / 525.0, -1.0 / 40.0)


@infinite_where_undefined
def explicit_step(p, time, current, direction, y, h, active, count, w) -> float:
    """
    Try one step of length `h` from `y`; the result is in w.trial, its rates in w.stage_rates.

    Return the error estimate relative to the tolerance, infinite where the step leads to no value.
    w.rates holds the derivatives at `y`.
    """
    for i in range(STATES):
        w.trial[i] = y[i]
        w.slopes[i] = w.rates[i]
    for stage in range(6):
        for i in range(count):
            state = active[i]
            slope = 0.0
            for j in range(stage + 1):
                slope += _WEIGHTS[stage][j] * w.slopes[j * STATES + state]
            w.trial[state] = y[state] + h * slope
        derivatives(p, time + _NODES[stage] * h, current, direction, w.trial, w.stage_rates)
        for i in range(count):
            w.slopes[(stage + 1) * STATES + active[i]] = w.stage_rates[active[i]]
    error, total = 0.0, 0.0
    for i in range(count):
        state = active[i]
        slope = 0.0
        for j in range(7):
            slope += _ERROR[j] * w.slopes[j * STATES + state]
        one = abs(h * slope) / TOLERANCE[state]
        error = max(error, one)
        total += one
    return error if total == total else math.inf  # `max` does not see NaN


def contraction(active, count, w) -> float:
    """
    Return the rate at which neighbouring solutions ran together in the last step, times the step.

    It is from the last two stages, both at the end of the step. The method is stable up to about
    3.3. (E. Hairer and G. Wanner, Solving Ordinary Differential Equations II, section IV.2, there
    without the sign: solutions that run apart, as those of a stem that breaks away, are no sign of
    stiffness.)
    """
    together, apart = 0.0, 0.0
    for i in range(count):
        state = active[i]
        distance = 0.0
        for j in range(6):
            sixth = _WEIGHTS[4][j] if j < 5 else 0.0
            distance += (_WEIGHTS[5][j] - sixth) * w.slopes[j * STATES + state]
        change = w.slopes[6 * STATES + state] - w.slopes[5 * STATES + state]
        together -= change / TOLERANCE[state] * (distance / TOLERANCE[state])
        apart += (distance / TOLERANCE[state]) ** 2
    return together / apart if apart > 0.0 else 0.0
