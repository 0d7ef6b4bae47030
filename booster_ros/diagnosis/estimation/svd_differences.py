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

from booster_ros.diagnosis.estimation.fit import Fit, fit_at
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.diagnosis.estimation.parallel import side_by_side

Array = np.ndarray

ROUNDS = 3
"""Times that axes are formed from the slopes along those before: two leave a valley with slopes of
0.4 where its own are 0.005, on processors whose rounding begins them with 8."""


def slopes_along_axes(problem: Problem, z: Array, here: Array, columns: Array) -> Array:
    """
    Return d(residuals)/dz at z by differences along the principal axes of a Jacobian.

    `here` are the residuals at z, `columns` their Jacobian there by one-sided differences.

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
        columns = _along_axes(problem, z, here, columns)
    return columns


def _along_axes(problem: Problem, z: Array, here: Array, columns: Array) -> Array:
    residuals = problem.residuals
    low, high = problem.bounds()
    moving = np.flatnonzero(columns.any(axis=0))
    _, lengths, axes = np.linalg.svd(columns[:, moving], full_matrices=False)
    steps = problem.steps_for(lengths)

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
    slopes = slopes_along_axes(problem, fit.z, fit.residuals, fit.jacobian)
    low, high = problem.bounds()
    step = lsq_linear(slopes, -fit.residuals, (low - fit.z, high - fit.z)).x
    further = fit_at(problem, fit.z + step, slopes)
    return further if further.cost < fit.cost else replace(fit, jacobian=slopes)
