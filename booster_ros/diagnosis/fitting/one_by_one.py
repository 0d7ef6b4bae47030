# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Trials that make a fit keep step with more of the slips of a packing that yields.

A fit through slips ends near the right friction, but of the cost in step (see in_step) no descent
is to be had there: a change of any variable by a ten-thousandth moves slips, and its slope is the
same in all directions. The hollow in which a model keeps step is narrow in every variable, and much
narrower in some than in others; draws of all variables at once do not meet it. So

1. the widths of the draws are what changes the means and strengths of slips by a standard
   deviation, which is smooth (`Problem.through_slips`);
2. of each of the best places so far, one or two variables are drawn anew, nearby or further off;
3. now and then all variables are fitted, from the best place, to the windows in which it is in
   step.

(Random search: F. J. Solis, R. J.-B. Wets, Mathematics of Operations Research 6 (1981) 19.)
"""

from dataclasses import replace
from functools import partial

import numpy as np

from booster_ros.diagnosis.fitting.fit import Problem
from booster_ros.diagnosis.fitting.in_step import cost_in_step, fitted_in_step
from booster_ros.diagnosis.fitting.side_by_side import side_by_side

Array = np.ndarray

ROUNDS, TRIALS = 18, 48

KEPT = 4
"""Number of best places around which a round draws."""

NEAR, FAR = 0.3, 30.0
"""Range of the standard deviations of the draws, in widths."""

OF_THE_EFFECT = 0.7
"""Share of the draws that move sizes and shapes only, as these are known least."""

ROUNDS_TO_A_FIT, EVALUATIONS = 6, 6

FLAT, WIDEST = 1e-3, 1.0
"""Slope of means and strengths up to which a variable moves nothing, and the largest width."""


def more_in_step(problem: Problem, z: Array) -> Array:
    """Return the place from z on that keeps step best, by the cost in step."""
    widths, rng = _widths(problem, z), np.random.default_rng(1)
    seen = np.flatnonzero(widths)
    sizes = np.intersect1d(seen, [
        j for j, free in enumerate(problem.freedoms) if not np.isfinite(free.sigma)])
    low, high = problem.bounds()

    def drawn(place: Array) -> Array:
        """Return the place with one or two of its variables drawn anew."""
        among = sizes if len(sizes) and rng.random() < OF_THE_EFFECT else seen
        number = min(int(rng.integers(1, 3)), len(among))
        moved = place.copy()
        for j in rng.choice(among, number, replace=False):
            reach = np.exp(rng.uniform(np.log(NEAR), np.log(FAR)))
            moved[j] += reach * widths[j] * rng.standard_normal()
        return np.clip(moved, low, high)

    problem = replace(problem, fine=True)
    cost = partial(cost_in_step, problem)
    best = [(cost(z), z)]
    for number in range(1, ROUNDS + 1):
        places = [drawn(best[k % len(best)][1]) for k in range(TRIALS)]
        best = _least([*best, *zip(side_by_side(cost, places), places)])
        if number % ROUNDS_TO_A_FIT == 0:
            fitted = fitted_in_step(problem, best[0][1], EVALUATIONS)
            best = _least([*best, (cost(fitted), fitted)])
    return best[0][1]


def _least(places: list[tuple[float, Array]]) -> list[tuple[float, Array]]:
    """Return the places that cost least, each with its cost, the best first."""
    return sorted(places, key=lambda place: place[0])[:KEPT]


def _widths(problem: Problem, z: Array) -> Array:
    """Return the widths of the variables, shape (variables,); 0 where one moves nothing seen."""
    here = problem.through_slips(z)
    first = problem.slopes_through_slips(z, here)
    slopes = problem.slopes_through_slips(z, here, first)
    priors = problem.nuisances + sum(bool(np.isfinite(one.sigma)) for one in problem.freedoms)
    seen = np.linalg.norm(slopes[:len(here) - priors], axis=0) > FLAT
    steepness = np.maximum(np.linalg.norm(slopes, axis=0), 1.0 / WIDEST)
    return np.where(seen, 1.0 / steepness, 0.0)
