# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The estimate of a valve whose stem sticks, in two steps: what lies above the stem, then the rest.

Over slips the cost has many minima, and in each of them the variables above the stem have run into
whatever meets the slips of this record by chance. The subsystem above, driven by the measured stem,
knows no slips. So these variables are held where it has them, and all else is fitted. How sure they
are carries over: with steps a of theirs, all else moves by -(J_b' J_b)^-1 J_b' J_a a (J: slopes).

Two-step estimators: K. M. Murphy and R. H. Topel, J. Business & Econ. Statistics 3 (1985) 370.
"""

from collections.abc import Sequence

import numpy as np

from booster_ros.diagnosis.data.experiment import Array
from booster_ros.diagnosis.estimation.final_fit import FinalFit, final_fit
from booster_ros.diagnosis.estimation.fit import fit_at
from booster_ros.diagnosis.estimation.parametrisation import label
from booster_ros.diagnosis.estimation.problem import SMALLEST_DIFFERENCE, Problem
from booster_ros.diagnosis.estimation.uncertainty import information
from booster_ros.numerics.parallel import side_by_side


def in_two_steps(problem: Problem, begin: Array, block_of_row: Array, above: FinalFit) -> FinalFit:
    """Return the estimate from z with the variables of the subsystem above held where it is."""
    theirs, ours = ([label(free) for free in each.freedoms] for each in (above.problem, problem))
    held, at = ([names.index(name) for name in ours if name in theirs] for names in (ours, theirs))
    rest = np.setdiff1d(np.arange(len(begin)), held)
    z = begin.copy()
    z[held] = above.fit.z[at]
    below = final_fit(problem.holding(z, held), z[rest], block_of_row)
    z[rest] = below.fit.z
    steps = above.draws[:, at] - z[held]
    slopes = np.zeros((problem.observed + len(problem.known), len(z)))
    slopes[:problem.observed, rest] = below.fit.jacobian[:problem.observed]
    slopes[problem.observed:] = (np.eye(len(z)) / problem.sigma)[problem.known]
    slopes[:problem.observed, held] = slopes_within(problem, z, held, steps)
    own = slopes[:, rest]
    draws = np.empty((len(steps), len(z)))
    draws[:, held] = z[held] + steps
    moves = -np.linalg.solve(information(own), own.T @ slopes[:, held])
    draws[:, rest] = below.draws + steps @ moves.T
    return FinalFit(problem, fit_at(problem, z, slopes), draws)


def slopes_within(problem: Problem, z: Array, which: Sequence[int], steps: Array) -> Array:
    """
    Return d(observed residuals)/dz of some variables at z, by differences as long as their steps.

    They are along the principal axes of these, shape (draws, variables), over a standard deviation
    to either side, or as far as several slips, if that is less (`last` of the observation).
    """
    _, lengths, axes = np.linalg.svd(steps / np.sqrt(len(steps)), full_matrices=False)
    seen = np.flatnonzero(lengths > SMALLEST_DIFFERENCE)

    def over(length: float, axis: Array) -> Array:
        step = np.zeros(len(z))
        step[which] = length * axis
        ahead, behind = (problem.residuals(np.clip(z + side * step, *problem.bounds()))
                         for side in (1.0, -1.0))
        return (ahead - behind)[:problem.observed] / (2.0 * length)

    def along(k: int) -> Array:
        slope = over(lengths[k], axes[k])
        several = problem.steps_for(np.array(np.linalg.norm(slope)), problem.observation.last)
        return slope if several >= lengths[k] else over(float(several), axes[k])

    slopes = np.reshape(side_by_side(along, seen.tolist()), (len(seen), problem.observed))
    return np.asarray(slopes.T @ axes[seen])
