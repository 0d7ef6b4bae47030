# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
How a model keeps step with a stem that slips.

A model whose friction is a hundredth off slips now and then where the valve does not, and from then
on is out of step, until the stem comes to rest or turns. What it misses there says nothing of how
far off it is. So windows in which it is out of step count no more than a fixed cost: a model is the
better the longer it keeps step, not the less it is wrong elsewhere. (A bounded cost: P. J. Huber,
Robust Statistics, Wiley 1981, ch. 4.)
"""

from dataclasses import dataclass, replace

import numpy as np

from booster_ros.diagnosis.fitting.fit import Problem
from booster_ros.diagnosis.fitting.sawtooth import rows_going
from booster_ros.diagnosis.fitting.slips import WINDOW

Array = np.ndarray

OUT_OF_STEP = 4.0
"""Mean square of the scaled residuals of a window from which on it is out of step, and what such a
window counts: noise alone leaves 1, and a slip that is missed tens."""

MISSED = 1.0 / 3.0
"""Share of the windows in which the stem goes beyond which slips are not followed."""


@dataclass(frozen=True, eq=False)
class Steps:
    """
    The rows of a problem in windows of a second, and what a model misses in each.

    `window` says of each row, shape (rows,), in which window it is; `count` how many measurements
    of a window count, and `mean` the mean of their scaled residuals' squares, shape (windows,).
    """

    window: Array
    count: Array
    mean: Array

    @property
    def cost(self) -> float:
        """The sum of squares of which no window counts more than OUT_OF_STEP."""
        return float(np.sum(self.count * np.minimum(self.mean, OUT_OF_STEP)))

    @property
    def kept(self) -> Array:
        """Which rows are in windows that are in step, a mask."""
        return (self.mean < OUT_OF_STEP)[self.window]

    def missed(self, going: Array) -> float:
        """Return the share of windows with such rows (a mask) that are out of step; of none, 1."""
        windows = np.unique(self.window[going])
        return float(np.mean(self.mean[windows] >= OUT_OF_STEP)) if len(windows) else 1.0


def steps(problem: Problem, z: Array) -> Steps:
    """Return how the model at z keeps step over the rows that count."""
    window = np.floor(problem.experiment.time / WINDOW).astype(int)
    window -= window[0]
    rows = np.concatenate([window[counts] for counts in problem.counted.values()])
    count = np.bincount(rows, minlength=window[-1] + 1)
    squares = np.bincount(rows, problem.residuals(z)[:len(rows)]**2, window[-1] + 1)
    return Steps(window, count, squares / np.maximum(count, 1))


def follows_slips(problem: Problem, z: Array) -> bool:
    """Tell whether the model at z is in step in most windows in which the stem goes."""
    return steps(problem, z).missed(rows_going(problem, z)) < MISSED


def fitted_in_step(problem: Problem, z: Array, evaluations: int) -> Array:
    """Return z fitted to the windows that are in step there, and again where these become more."""
    before = np.zeros(len(problem.rows), dtype=bool)
    for _ in range(2):
        kept = problem.rows & steps(problem, z).kept
        if not np.any(kept & ~before):
            break
        before = kept
        z = replace(problem, rows=kept).fit(z, evaluations).z
    return z


def cost_in_step(problem: Problem, z: Array) -> float:
    """Return the cost at z, priors included, of which no window counts more than OUT_OF_STEP."""
    return steps(problem, z).cost + problem.cost_of_priors(z)
