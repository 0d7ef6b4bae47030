# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Least squares where a Jacobian costs a simulation per variable.

scipy's trust region reflective method, with a Jacobian that is

1. formed by differences where the descent begins;
2. after a step that it foresaw well, corrected by the smallest change that agrees with the step
   (Broyden's update), after any other formed anew;
3. formed anew where the descent ends with a corrected one: an end is an end only if the slopes of
   that very place say so; not where it is broken off.

C. G. Broyden, A class of methods for solving nonlinear simultaneous equations, Mathematics of
Computation 19 (1965) 577-593.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares, lsq_linear

Array = np.ndarray
Residuals = Callable[[Array], Array]
Differences = Callable[[Array, Array, Array | None], Array]

FORESEEN = 0.1
"""Largest share of the residuals' change that a Jacobian misses if it foresaw the step."""

CONVERGED, SETTLED = 1e-4, 3e-6
"""Relative change of cost and variables at which a descent ends: the first where models are
compared, the second for a model that is handed on, as 1e-4 of the squared errors of thousands of
rows may be two standard deviations of a parameter that this record hardly shows."""

NO_STEP = 1e-9
"""Length below which steps are rounding, and say nothing of slopes."""

_SHIFT = 5.0
"""Shift that is added to all variables: the first trust region is as large as they are."""


@dataclass(frozen=True)
class Descent:
    """Where a descent ended: variables, cost (sum of squares) and Jacobian."""

    z: Array
    cost: float
    jacobian: Array


class _Slopes:
    """Residuals where they were last asked for, and the Jacobian, which follows the steps."""

    def __init__(self, residuals: Residuals, differences: Differences, begun: Array | None,
                 evaluations: int):
        self._residuals, self._differences = residuals, differences
        self._jacobian, self._left = begun, evaluations
        self._here: tuple[Array, Array] | None = None
        self._asked: tuple[Array, Array] | None = None
        self.corrected = begun is not None
        self.formed = begun

    def residuals(self, v: Array) -> Array:
        for place in (self._asked, self._here):
            if place is not None and np.array_equal(place[0], v):
                return place[1]
        self._asked = v.copy(), self._residuals(v)
        self._left -= 1
        return self._asked[1]

    def jacobian(self, v: Array) -> Array:
        r = self.residuals(v)
        jacobian = self._jacobian
        if jacobian is None:
            jacobian = self._formed(v, r)
        elif self._here is not None and np.linalg.norm(v - self._here[0]) > NO_STEP:
            step, change = v - self._here[0], r - self._here[1]
            missed = change - jacobian @ step
            if not self._left or np.linalg.norm(missed) < FORESEEN * np.linalg.norm(change):
                jacobian = jacobian + np.outer(missed, step / (step @ step))
                self.corrected = True
            else:
                jacobian = self._formed(v, r)
        self._here, self._jacobian = (v.copy(), r), jacobian
        return jacobian

    def renew(self, v: Array) -> None:
        """Form the Jacobian anew at a place where the residuals were asked for."""
        self._jacobian = self._formed(v, self.residuals(v))

    def _formed(self, v: Array, r: Array) -> Array:
        self.corrected = False
        self.formed = self._differences(v, r, self._jacobian)
        return self.formed


def descend(residuals: Residuals, differences: Differences, begin: Array, low: Array, high: Array,
            evaluations: int, converged: float = CONVERGED, slopes: Array | None = None
            ) -> Descent:
    """
    Return where, downhill from `begin`, the squared residuals are least between `low` and `high`.

    `differences` forms a Jacobian from a place, the residuals there, and an earlier Jacobian or
    None; `evaluations` is the largest number of evaluations beside those that form Jacobians,
    `converged` the relative change at which the descent ends, `slopes` a Jacobian to begin with,
    which need not be quite that of `begin`. Variables are of order one.
    """
    known = _Slopes(lambda v: residuals(v - _SHIFT),
                    lambda v, r, before: differences(v - _SHIFT, r, before), slopes, evaluations)
    v, cost = begin + _SHIFT, np.inf
    while True:
        found = least_squares(
            known.residuals, v, known.jacobian, bounds=(low + _SHIFT, high + _SHIFT),
            max_nfev=evaluations, ftol=converged, xtol=converged, method='trf')
        v = found.x
        evaluations -= found.nfev - 1
        ended = not known.corrected or cost - found.cost < converged * cost
        if ended or evaluations < 2:
            # steps too short to gain anything have corrected it by the solver's error alone
            told = known.formed if ended and known.formed is not None else found.jac
            return Descent(v - _SHIFT, 2.0 * found.cost, told)
        cost = found.cost
        known.renew(v)


def straight(q: Array, upper: Array, r: Array, room: tuple[Array, Array]) -> Array:
    """
    Return the step within `room` (lower, upper) that leaves least by linear reckoning.

    `q` and `upper` are the factors of the Jacobian, numpy.linalg.qr of it; `r` are the residuals.
    """
    return np.asarray(lsq_linear(upper, -(q.T @ r), room, method='bvls').x)
