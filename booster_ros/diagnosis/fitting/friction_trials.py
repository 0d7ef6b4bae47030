# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Friction around a fit, by trial: a better one where there is one near, and how sure it is.

Which slip comes when makes what a stem that sticks leaves rough on every scale. A slope, over
whatever step, is then the chance of a few slips: a descent ends beside the best, and intervals from
slopes leave out the truth by many of their widths. So sizes are drawn and run:

1. draw the effects' sizes and shapes around the fit, each apart, and run them;
2. go on around the best so far, closer, round by round;
3. what the closest leave beside the best is chance: they hardly differ from it but in their slips.
   All trials, near and far, that leave no more than nine in ten of these are as good.

The declared parameters stay as they are.
"""

from dataclasses import dataclass

import numpy as np

from booster_ros.diagnosis.fitting.fit import Problem
from booster_ros.diagnosis.fitting.side_by_side import side_by_side

Array = np.ndarray

ROUNDS, TRIALS = 7, 32

WIDE, SMALL = 0.25, 0.3
"""Standard deviation of the first trials, as a share of a variable, and the size in which it counts
as small: those are drawn as if they had that."""

CLOSER = 0.6
"""Of that, the share in the next round; the last is within some percent."""

BY_CHANCE = 0.9
"""Share of the closest whose cost is taken for chance."""


@dataclass(frozen=True, eq=False)
class Trials:
    """
    What was tried: z, shape (trials, variables), and its cost through slips, (trials,).

    The first is what was begun with; `varied` are the variables that were drawn.
    """

    z: Array
    cost: Array
    varied: tuple[int, ...]

    @property
    def best(self) -> Array:
        """Return z of the trial that leaves least."""
        return self.z[int(np.argmin(self.cost))]

    @property
    def as_good(self) -> Array:
        """Return z of those that leave no more than slips by chance do, shape (some, variables)."""
        return self.z[self.are_good]

    @property
    def are_good(self) -> Array:
        """Return which these are, as a mask of shape (trials,)."""
        return self.cost <= np.quantile(self.cost[-TRIALS:], BY_CHANCE)

    def ends(self, index: int) -> tuple[float, float] | None:
        """Return how far a variable goes either way in good trials, None if it was not varied."""
        if index not in self.varied:
            return None
        good = self.as_good[:, index]
        return float(good.min()), float(good.max())

    def instead_of(self, draws: Array) -> Array:
        """Return draws of z, shape (draws, variables), with what was varied as in good trials."""
        good = self.as_good
        again = draws.copy()
        varied = list(self.varied)
        again[:, varied] = good[np.arange(len(draws)) % len(good)][:, varied]
        return again


def friction_trials(problem: Problem, z: Array) -> Trials:
    """
    Return trials around z.

    What is none in z where only much of it would be seen, a stiffness, stays none; what means
    nothing beside it, the damping of a packing that does not yield, stays as it is.
    """
    sizes_and_shapes = [
        j for j, free in enumerate(problem.freedoms) if not np.isfinite(free.sigma)
        and not (free.knob.inverse and free.value(z[j]) == free.knob.neutral)]
    varied = tuple(sorted(set(sizes_and_shapes) - problem.idle(sizes_and_shapes, z)))
    rng = np.random.default_rng(1)
    width = WIDE * np.maximum(np.abs(z[list(varied)]), SMALL)
    low, high = problem.bounds()
    tried, cost = z[np.newaxis], np.array([problem.cost_through_slips(z)])
    for _ in range(ROUNDS):
        places = np.tile(tried[int(np.argmin(cost))], (TRIALS, 1))
        places[:, varied] += width * rng.standard_normal((TRIALS, len(varied)))
        places = np.clip(places, low, high)
        tried = np.concatenate([tried, places])
        cost = np.concatenate([cost, side_by_side(problem.cost_through_slips, places)])
        width = CLOSER * width
    return Trials(tried, cost, varied)
