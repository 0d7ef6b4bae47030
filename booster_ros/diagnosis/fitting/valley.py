# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Slopes where variables do nearly the same, and the bottom of the valley that they make.

The E/P converter's offset and the preloads of both seats make such a valley: only the prior of the
offset tells where in it a fit has to end.
"""

from dataclasses import replace

import numpy as np
from scipy.optimize import lsq_linear

from booster_ros.diagnosis.fitting.descent import Residuals
from booster_ros.diagnosis.fitting.fit import Fit, Problem
from booster_ros.diagnosis.fitting.side_by_side import side_by_side

Array = np.ndarray

ROUNDS = 3
"""Times that axes are formed from the slopes along those before: two leave a valley with slopes of
0.4 where its own are 0.005, on processors whose rounding begins them with 8."""


def slopes_along_axes(
    problem: Problem, residuals: Residuals, z: Array, here: Array, columns: Array
) -> Array:
    """
    Return d(residuals)/dz at z by differences along the principal axes of a Jacobian.

    `residuals` are those of the problem, or its means; `here` is what they are at z, `columns`
    their Jacobian there by one-sided differences.

    Columns of one-sided differences bend by a percent over their steps. Where variables do nearly
    the same, that percent is more than what differs between them, and what the rows cannot tell
    looks as if they told it well. Along an axis the step is as long as is needed to see that axis.

    A size that is none stands at its bound. Where a bound is in the way on one side of an axis,
    the difference is formed on the other, of second order. Where bounds are in the way on both,
    variables that would go over theirs are left out of the step, and their own columns count.

    The axes of a Jacobian that is a percent off are off as well. So it is done again with what came
    of it, ROUNDS times in all.
    """
    for _ in range(ROUNDS):
        columns = _along_axes(problem, residuals, z, here, columns)
    return columns


def _along_axes(
    problem: Problem, residuals: Residuals, z: Array, here: Array, columns: Array
) -> Array:
    low, high = problem.bounds()
    moving = np.flatnonzero(columns.any(axis=0))
    _, lengths, axes = np.linalg.svd(columns[:, moving], full_matrices=False)
    steps = problem.steps_for(z, lengths)

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


def at_the_bottom(problem: Problem, fit: Fit) -> Fit:
    """Return the fit with `slopes_along_axes`, a Gauss-Newton step further if that is better."""
    here = problem.residuals(fit.z)
    slopes = slopes_along_axes(problem, problem.residuals, fit.z, here, fit.jacobian)
    low, high = problem.bounds()
    step = lsq_linear(slopes, -here, (low - fit.z, high - fit.z)).x
    z = fit.z + step
    cost = problem.cost(z)
    if cost >= fit.cost:
        return replace(fit, jacobian=slopes)
    p = problem.parameters(z)
    return replace(fit, z=z, parameters=p, initial=problem.initial(z, p), cost=cost,
                   jacobian=slopes)
