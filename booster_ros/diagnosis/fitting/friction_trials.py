# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Trials of friction around a fit, for a better value if one is near, and for how sure it is.

Where a stem sticks, the timing of slips makes the cost rough on every scale. A slope, over
whatever step, is then the chance of a few slips: a descent ends beside the best, and intervals from
slopes leave out the truth by many of their widths. So sizes are drawn and run:

1. draw the effects' sizes and shapes around the fit, each independently, and run the model with
   them;
2. go on around the best trial so far, closer, round by round;
3. what the closest trials leave more than the best one is chance, as they hardly differ from it
   but in their slips. All trials, near or far, that leave no more than nine in ten of the closest
   ones do are as good.

The declared parameters stay as they are.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from booster_ros.diagnosis.fitting.fit import Problem
from booster_ros.diagnosis.fitting.side_by_side import side_by_side

Array = np.ndarray

ROUNDS, TRIALS = 7, 32

WIDE, SMALL = 0.25, 0.3
"""Standard deviation of the first trials, as a share of each variable, and the size below which a
variable counts as small: small ones are drawn as if they had this size."""

NARROW = 0.02
"""The same share around a fit that keeps step: a hundredth further, all slips are out of step."""

CLOSER = 0.6
"""Factor on the standard deviation from each round to the next; the last round is within some
percent."""

BY_CHANCE = 0.9
"""Share of the closest trials whose cost is taken for chance."""


@dataclass(frozen=True, eq=False)
class Trials:
    """
    What was tried: z, shape (trials, variables), and its cost, through slips or in step, (trials,).

    The first trial is what the others began with; `varied` are the variables that were drawn.
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
        """Return z of trials that leave no more than chance does, shape (some, variables)."""
        return self.z[self.are_good]

    @property
    def are_good(self) -> Array:
        """Return which trials leave no more than that, as a mask of shape (trials,)."""
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


def friction_trials(problem: Problem, z: Array, share: float = WIDE,
                    cost_of: Callable[[Problem, Array], float] = Problem.cost_through_slips
                    ) -> Trials:
    """
    Return trials around z by this cost, the first ones within about this share of it.

    An inverse parameter that is none at z, such as a stiffness, stays none, as only a large step
    from there would be seen. What means nothing at z, such as the damping of a packing that does
    not yield, stays as it is.
    """
    sizes_and_shapes = [
        j for j, free in enumerate(problem.freedoms) if not np.isfinite(free.sigma)
        and not (free.knob.inverse and free.value(z[j]) == free.knob.neutral)]
    varied = tuple(sorted(set(sizes_and_shapes) - problem.idle(sizes_and_shapes, z)))
    rng = np.random.default_rng(1)
    width = share * np.maximum(np.abs(z[list(varied)]), SMALL)
    low, high = problem.bounds()
    tried, cost = z[np.newaxis], np.array([cost_of(problem, z)])
    for _ in range(ROUNDS):
        places = np.tile(tried[int(np.argmin(cost))], (TRIALS, 1))
        places[:, varied] += width * rng.standard_normal((TRIALS, len(varied)))
        places = np.clip(places, low, high)
        tried = np.concatenate([tried, places])
        cost = np.concatenate([cost, side_by_side(lambda place: cost_of(problem, place), places)])
        width = CLOSER * width
    return Trials(tried, cost, varied)
