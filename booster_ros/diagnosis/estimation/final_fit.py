# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The final estimate of a chosen model: every training row, to the very end, and how sure it is.

What the rows do not show is put back: a size to none, a shape to what is typical. All else is
fitted on without it, as it had made up for it.

Where variables do nearly the same they make a valley, as the E/P converter's offset and the
preloads of both seats do. So slopes are formed along its axes at last, and a step goes to its
bottom.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import lsq_linear

from booster_ros.diagnosis.data.experiment import Array
from booster_ros.diagnosis.estimation.fit import NOTICEABLE, Fit, fit, fit_at, nominal
from booster_ros.diagnosis.estimation.parallel import side_by_side
from booster_ros.diagnosis.estimation.parametrisation import put
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.diagnosis.estimation.uncertainty import block_bootstrap
from booster_ros.numerics.least_squares import SETTLED

ROUNDS, PAYS = 3, 0.1
"""Times that axes are formed: on some processors two leave slopes of 0.4 in a valley of 0.005; and
that a descent over slips is begun anew, while a tenth less is left."""


@dataclass(frozen=True, eq=False)
class FinalFit:
    """A problem on every training row, its fit, and draws of z, shape (draws, variables)."""

    problem: Problem
    fit: Fit
    draws: Array


def final_fit(problem: Problem, begin: Array, block_of_row: Array) -> FinalFit:
    """
    Return the estimate from z, or from there with the declared parameters as given, if better.

    Sizes that the rows do not show are none, and shapes typical where that is as good.
    """
    if not problem.observation.summary:
        other = nominal(problem, begin)
        starts = [begin, other] if np.any(other[:len(problem.freedoms)]) else [begin]
        found = fit(problem, starts, tolerance=SETTLED)
    else:
        found = _over_slips(problem, begin)
    found = at_the_bottom(problem, without_unseen(problem, found))
    return FinalFit(problem, found, block_bootstrap(problem, found, block_of_row))


def _over_slips(problem: Problem, begin: Array) -> Fit:
    """Return the fit to a summary, rough as slips make it: new slopes lead on from its end."""
    found = fit(problem, [begin, nominal(problem, begin)])
    for _ in range(ROUNDS):
        before, found = found, min(found, fit(problem, [found.z]), key=lambda one: one.cost)
        if found.cost > (1.0 - PAYS) * before.cost:
            break
    return found


def without_unseen(problem: Problem, found: Fit) -> Fit:
    """
    Return the fit without what the rows show less than their noise, all else fitted on.

    Such a size goes back to neutral, a shape to what is typical. Its slopes are those of before.
    As a size may lie where nothing more changes, such as that of a seat so wide that it is never
    fully open, the model without it is run before.
    """
    z, seen = found.z, found.seen
    for j, free in enumerate(problem.freedoms):
        if not free.of_effect or (seen[j] and not free.knob.shape):
            continue
        without = z.copy()
        without[j] = free.without_size
        if problem.cost(without) < found.cost + NOTICEABLE:
            z = without
    return found if np.array_equal(z, found.z) else _fitted_beside(problem, z, found.jacobian)


def _put_back(problem: Problem, z: Array) -> list[int]:
    """Return the variables of effects that are none or typical at z: they stay so."""
    return [j for j, free in enumerate(problem.freedoms)
            if free.of_effect and z[j] == free.without_size]


def _fitted_beside(problem: Problem, z: Array, slopes: Array) -> Fit:
    """Return the fit of all variables but those that have been put back."""
    held, base = _put_back(problem, z), problem.base
    for free in (problem.freedoms[j] for j in held):
        base = put(base, free.knob.parameter, free.value(free.without_size), free.element)
    others = np.setdiff1d(np.arange(len(z)), held)
    if len(others):
        beside = replace(problem, base=base, freedoms=tuple(
            free for j, free in enumerate(problem.freedoms) if j not in held))
        z = z.copy()
        z[others] = fit(beside, [z[others]], tolerance=SETTLED, slopes=slopes[:, others]).z
    return fit_at(problem, z, slopes)


def slopes_along_axes(problem: Problem, z: Array, here: Array, columns: Array) -> Array:
    """
    Return d(residuals)/dz at z by differences along the principal axes of a Jacobian.

    `here` are the residuals at z, `columns` their Jacobian there by one-sided differences.

    Columns of one-sided differences bend by a percent over their steps, which is more than what
    differs between variables that do nearly the same. Along an axis the step is as long as is
    needed to see that axis; as the axes are off as well, it is done ROUNDS times.

    Where a bound is in the way on one side of an axis, the difference is formed on the other, of
    second order; where on both, variables that would go over theirs keep their own columns.
    """
    for _ in range(ROUNDS):
        columns = _along_axes(problem, z, here, columns)
    return columns


def _along_axes(problem: Problem, z: Array, here: Array, columns: Array) -> Array:
    residuals = problem.residuals
    low, high = problem.bounds()
    moving = np.flatnonzero(columns.any(axis=0))
    _, lengths, axes = np.linalg.svd(columns[:, moving], full_matrices=False)
    steps = problem.steps_for(lengths, problem.observation.last)

    def within(moved: Array) -> bool:
        return bool(np.all((low <= moved) & (moved <= high)))

    def along(k: int) -> Array:
        step = np.zeros(len(z))
        step[moving] = steps[k] * axes[k]
        over = (z - np.abs(step) < low) | (z + np.abs(step) > high)
        inwards = next((side for side in (1.0, -1.0) if within(z + 2.0 * side * step)), None)
        if over.any() and inwards:
            ahead, further = residuals(z + inwards * step), residuals(z + 2.0 * inwards * step)
            return inwards * (4.0 * ahead - further - 3.0 * here) / (2.0 * steps[k])
        free = np.where(over, 0.0, step)
        change = residuals(z + free) - residuals(z - free)
        return (0.5 * change + columns @ (step - free)) / steps[k]

    slopes = columns.copy()
    slopes[:, moving] = np.transpose(side_by_side(along, range(len(axes)))) @ axes
    return slopes


def at_the_bottom(problem: Problem, found: Fit) -> Fit:
    """
    Return the fit with `slopes_along_axes`, a Gauss-Newton step further if that is better.

    What has been put back stays so.
    """
    slopes = slopes_along_axes(problem, found.z, found.residuals, found.jacobian)
    room = np.array(problem.bounds()) - found.z
    others = np.setdiff1d(np.arange(len(found.z)), _put_back(problem, found.z))
    step = np.zeros(len(found.z))
    step[others] = lsq_linear(slopes[:, others], -found.residuals, room[:, others]).x
    further = fit_at(problem, found.z + step, slopes)
    return further if further.cost < found.cost else replace(found, jacobian=slopes)
