# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The one way to estimate: bounded least squares (Gauss-Newton, trust region) from given starts."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from booster_ros.diagnosis.data.experiment import Array, Initial
from booster_ros.diagnosis.estimation.parametrisation import Free
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.model.system import PositionerParameters
from booster_ros.numerics.least_squares import CONVERGED, Descent, descend
from booster_ros.numerics.parallel import side_by_side

EVALUATIONS = 30
"""Steps of a descent beside its Jacobians, at the most: most end after four to eight."""

FIRST_STEPS = 4
"""Steps of a descent that only tells which way things go."""

NOTICEABLE = 1.0
"""Change of the residuals (norm), or of the cost, that is no more than chance: one of noise."""


@dataclass(frozen=True, eq=False)
class Fit:
    """An estimate: z, parameters and start at z, the cost there, residuals and Jacobian."""

    freedoms: tuple[Free, ...]
    z: Array
    parameters: PositionerParameters
    initial: Initial
    cost: float
    residuals: Array = field(repr=False)
    jacobian: Array = field(repr=False)

    @property
    def seen(self) -> Array:
        """Which variables move the residuals by more than noise, compared with z = 0."""
        return np.linalg.norm(self.jacobian, axis=0) * np.abs(self.z) > NOTICEABLE


def fit_at(problem: Problem, z: Array, jacobian: Array | None = None) -> Fit:
    """Return z as a fit of the problem, not moved; the Jacobian is formed if it is not given."""
    here = problem.residuals(z)
    slopes = problem.jacobian(z, here) if jacobian is None else jacobian
    p = problem.parameters(z)
    return Fit(problem.freedoms, z, p, problem.initial(z, p), float(np.sum(here**2)), here, slopes)


def fit(problem: Problem, starts: Sequence[Array] = (), evaluations: int = EVALUATIONS,
        tolerance: float = CONVERGED, slopes: Array | None = None) -> Fit:
    """
    Return the best of the descents of a problem from several starts (default: as given).

    A descent ends where cost and variables change by less than `tolerance` (relative), or after so
    many evaluations. `slopes` is a Jacobian to begin with, not quite that of the starts.
    """
    low, high = problem.bounds()
    margin = 1e-6 * np.minimum(high - low, 1.0)

    def descended(begin: Array) -> Descent:
        return descend(problem.residuals, problem.jacobian,
                       np.clip(begin, low + margin, high - margin), low, high, evaluations,
                       tolerance, slopes)

    best = min(side_by_side(descended, starts if len(starts) else [problem.start()]),
               key=lambda end: end.cost)
    return fit_at(problem, best.z, best.jacobian)


def carried(target: Problem, *sources: Fit) -> Array:
    """
    Return z of `target` with the values that its parameters have in the sources: a warm start.

    Later sources count before earlier ones, for the start the first; what is in none stands at 0.
    """
    known = {(f.knob.parameter, f.element): z for source in sources
             for f, z in zip(source.freedoms, source.z)}
    body = [known.get((f.knob.parameter, f.element), 0.0) for f in target.freedoms]
    tail = sources[0].z[len(sources[0].freedoms):]
    return np.concatenate([body, tail if len(tail) == target.nuisances
                           else np.zeros(target.nuisances)])


def nominal(problem: Problem, z: Array) -> Array:
    """
    Return z with only the effects kept: declared parameters and start as given.

    Those had imitated an effect before it was in the model, and come back only in tiny steps.
    """
    kept = [free.of_effect for free in problem.freedoms] + [False] * problem.nuisances
    return np.where(kept, z, 0.0)
