# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The final estimate of a chosen model: every training row, to the very end, and how sure it is."""

from dataclasses import dataclass

import numpy as np

from booster_ros.diagnosis.estimation.fit import NOTICEABLE, Fit, fit, fit_at, nominal
from booster_ros.diagnosis.estimation.least_squares import SETTLED
from booster_ros.diagnosis.estimation.observation import ROWS
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.diagnosis.estimation.svd_differences import at_the_bottom
from booster_ros.diagnosis.estimation.uncertainty import block_bootstrap

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class FinalFit:
    """A problem on every training row, its fit, and draws of z, shape (draws, variables)."""

    problem: Problem
    fit: Fit
    draws: Array


def final_fit(problem: Problem, begin: Array, block_of_row: Array) -> FinalFit:
    """
    Return the estimate from z, or from there with the declared parameters as given, the better one.

    Sizes of effects that the rows do not show are put back to none.
    """
    if problem.observation is ROWS:
        other = nominal(problem, begin)
        starts = [begin, other] if np.any(other[:len(problem.freedoms)]) else [begin]
        found = at_the_bottom(problem, fit(problem, starts, tolerance=SETTLED))
    else:  # a stem that sticks was fitted from what is seen above it, and takes long
        found = fit(problem, [begin])
    found = without_unseen(problem, found)
    return FinalFit(problem, found, block_bootstrap(problem, found, block_of_row))


def without_unseen(problem: Problem, found: Fit) -> Fit:
    """
    Return the fit with those sizes back at neutral that the rows show less than their noise.

    And with those shapes typical on which nothing depends. Its slopes are those of before: nothing
    seen has moved. Slopes also call a size unseen that lies where nothing more changes, such as
    that of a seat so wide that it is never fully open. So the model with the size at neutral is run
    before it is taken.
    """
    z, seen = found.z, found.seen
    for j, free in enumerate(problem.freedoms):
        if free.as_given or np.isfinite(free.sigma) or free.knob.shape or z[j] == 0.0 or seen[j]:
            continue
        without = z.copy()
        without[j] = 0.0
        if problem.cost(without) < found.cost + NOTICEABLE:
            z = without
    shapes = [j for j, free in enumerate(problem.freedoms)
              if free.knob.shape and not free.knob.inverse]  # a stiffness of none is rigid
    for j in problem.idle(shapes, z):
        z = z.copy()
        z[j] = problem.freedoms[j].without_size
    return found if z is found.z else fit_at(problem, z, found.jacobian)
