# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The profile of a cost over some variables: all others are where they leave least.

A trial takes one run of the model, for the others go by the slopes at a fit (variable projection:
G. H. Golub and V. Pereyra, SIAM Journal on Numerical Analysis 10 (1973) 413). What is left is
bounded, so that one slip more or less does not hide how well all else is met.
"""

import numpy as np

from booster_ros.diagnosis.data.experiment import Array
from booster_ros.diagnosis.estimation.problem import Problem

UNLIKELY = 5.0
"""Standard deviations beyond which a statistic tells of a slip more or less, not of noise."""

REWEIGHTED = 3
"""Times that weights of bounded residuals are formed: a fourth changes nothing that counts."""


def bounded_cost(residuals: Array) -> float:
    """
    Return a sum of squares that grows as a logarithm where residuals are UNLIKELY.

    It is that of Cauchy's distribution, sum c² log(1 + r²/c²): one slip that comes in another
    window is up to hundreds of standard deviations there.
    """
    return float(np.sum(UNLIKELY**2 * np.log1p((residuals / UNLIKELY)**2)))


def profiled(problem: Problem, z: Array, residuals: Array, slopes: Array, held: int
             ) -> tuple[float, Array]:
    """
    Return the least bounded cost as all but the one `held` go by the slopes, and z there.

    `residuals` are those at z. Weighted squares lead there, by the shortest step: slopes say
    nothing of where variables go that hardly matter.
    """
    low, high = (bound - z for bound in problem.bounds())
    columns = slopes.copy()
    columns[:, held] = 0.0
    left, step = residuals, np.zeros(len(z))
    for _ in range(REWEIGHTED):
        weight = 1.0 / np.sqrt(1.0 + (left / UNLIKELY)**2)
        step = np.linalg.lstsq(weight[:, None] * columns, -weight * residuals, rcond=None)[0]
        step = np.clip(step, low, high)
        step[held] = 0.0  # the solver leaves it at next to nothing
        left = residuals + columns @ step
    return bounded_cost(left), z + step
