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

from booster_ros.diagnosis.fitting.fit import LARGEST_DIFFERENCE, Fit, Problem
from booster_ros.diagnosis.fitting.side_by_side import side_by_side

Array = np.ndarray

ROUNDS = 3
"""Times that axes are formed from the slopes along those before: two leave a valley with slopes of
0.4 where its own are 0.005, on processors whose rounding begins them with 8."""


def slopes_along_axes(problem: Problem, fit: Fit) -> Array:
    """
    Return d(residuals)/dz at a fit by differences along the principal axes of its Jacobian.

    Columns of one-sided differences bend by a percent over their steps. Where variables do nearly
    the same, that percent is more than what differs between them, and what the rows cannot tell
    looks as if they told it well. Along an axis the step is as long as is needed to see that axis.
    A variable with a bound within reach keeps the column that it has.

    The axes of a Jacobian that is a percent off are off as well. So it is done again with what came
    of it, ROUNDS times in all.
    """
    slopes = fit.jacobian
    for _ in range(ROUNDS):
        slopes = _along_axes(problem, replace(fit, jacobian=slopes))
    return slopes


def _along_axes(problem: Problem, fit: Fit) -> Array:
    low, high = problem.bounds()
    roomy = (fit.z - LARGEST_DIFFERENCE > low) & (fit.z + LARGEST_DIFFERENCE < high)
    inner = np.flatnonzero(roomy & fit.jacobian.any(axis=0))
    _, lengths, axes = np.linalg.svd(fit.jacobian[:, inner], full_matrices=False)
    steps = problem.steps_for(fit.z, lengths)

    def along(k: int) -> Array:
        step = np.zeros(len(fit.z))
        step[inner] = steps[k] * axes[k]
        ahead, behind = problem.residuals(fit.z + step), problem.residuals(fit.z - step)
        return (ahead - behind) / (2.0 * steps[k])

    slopes = fit.jacobian.copy()
    slopes[:, inner] = np.transpose(side_by_side(along, range(len(axes)))) @ axes
    return slopes


def at_the_bottom(problem: Problem, fit: Fit) -> Fit:
    """Return the fit with `slopes_along_axes`, a Gauss-Newton step further if that is better."""
    slopes = slopes_along_axes(problem, fit)
    low, high = problem.bounds()
    step = lsq_linear(slopes, -problem.residuals(fit.z), (low - fit.z, high - fit.z)).x
    z = fit.z + step
    cost = problem.cost(z)
    if cost >= fit.cost:
        return replace(fit, jacobian=slopes)
    p = problem.parameters(z)
    return replace(fit, z=z, parameters=p, initial=problem.initial(z, p), cost=cost,
                   jacobian=slopes)
