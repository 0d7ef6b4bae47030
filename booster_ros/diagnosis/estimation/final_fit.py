# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The final estimate of a chosen model: every training row, to the very end, and how sure it is.

What the rows do not show, or do not call for, is put back: a size to none, a shape to what is
typical. All else is fitted on without it, as it had made up for it.

Where variables do nearly the same they make a valley, as the E/P converter's offset and preloads
of both seats do. So slopes are formed along its axes at last, and a step goes to its bottom.
"""

from dataclasses import dataclass, replace
from math import log

import numpy as np
from scipy.optimize import lsq_linear

from booster_ros.diagnosis.data.experiment import Array
from booster_ros.diagnosis.estimation.fit import NOTICEABLE, Fit, fit, fit_at, nominal
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.diagnosis.estimation.profile import profiled
from booster_ros.diagnosis.estimation.uncertainty import block_bootstrap, information
from booster_ros.model.catalogue import EFFECTS
from booster_ros.numerics.least_squares import SETTLED
from booster_ros.numerics.parallel import side_by_side
from booster_ros.signals.dispersion import dispersion

ROUNDS = 3
"""Times that axes are formed: on some processors two leave slopes of 0.4 in a valley of 0.005."""

BESIDE = {knob.parameter for effect in EFFECTS.values() for knob in effect.knobs[1:]
          if not knob.shape}
"""Sizes that an effect may have beside its first, which makes it what it is."""


@dataclass(frozen=True, eq=False)
class FinalFit:
    """A problem on every training row, its fit, and draws of z, shape (draws, variables)."""

    problem: Problem
    fit: Fit
    draws: Array


def final_fit(problem: Problem, begin: Array, block_of_row: Array) -> FinalFit:
    """Return the best estimate from z and, by rows, from there with what is declared as given."""
    other = nominal(problem, begin)  # over slips it would lead to some other minimum
    far = not problem.observation.summary and np.any(other[:len(problem.freedoms)])
    found = _descended(problem, [begin, other] if far else [begin])
    found = at_the_bottom(problem, without_unseen(problem, found))
    smaller = called_for(problem, found)
    if smaller is not found:
        found = at_the_bottom(problem, smaller)
    return FinalFit(problem, found, block_bootstrap(problem, found, block_of_row))


def _descended(problem: Problem, starts: list[Array], slopes: Array | None = None) -> Fit:
    """
    Return the best fit from several starts, followed to its very end by ever finer slopes.

    Those over several slips lead to the right minimum, and stall in it: it is narrow and bends.
    """
    found, before = fit(problem, starts, tolerance=SETTLED, slopes=slopes), np.inf
    while problem.observation.finer and found.cost < before - NOTICEABLE:
        before = found.cost
        for steps in problem.observation.finer:
            near = replace(problem, observation=replace(problem.observation, steps=steps))
            end = fit(near, [found.z], tolerance=SETTLED)
            found = min(found, end, key=lambda one: one.cost)
    return found


def without_unseen(problem: Problem, found: Fit) -> Fit:
    """
    Return the fit without what the rows show less than their noise, all else fitted on.

    Such a size goes back to none, a shape to what is typical. As a size may lie where nothing more
    changes, as that of a seat so wide that it is never fully open, the model without it is run.
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


def called_for(problem: Problem, found: Fit) -> Fit:
    """
    Return the fit without sizes that the record does not call for, but the first of an effect.

    Where slopes say that little is lost without a size, all else is fitted without it. So it stays
    where what is left grows by less than c log n for each variable that no longer matters, with n
    observations and their over-dispersion c (G. Schwarz, The Annals of Statistics 6 (1978) 461).
    """
    each = dispersion(problem.series(found.residuals[:problem.observed])) * log(problem.observed)
    for j, free in enumerate(problem.freedoms):
        if free.knob.parameter not in BESIDE or found.z[j] == free.without_size:
            continue
        without = found.z.copy()
        without[j] = free.without_size
        if (without[j] - found.z[j])**2 > each * np.linalg.inv(information(found.jacobian))[j, j]:
            continue
        _, without = profiled(problem, without, problem.residuals(without), found.jacobian, j)
        smaller = _fitted_beside(problem, without, found.jacobian)
        idle = 1 + np.sum(found.jacobian.any(axis=0)) - np.sum(smaller.jacobian.any(axis=0))
        if smaller.cost < found.cost + each * idle:
            found = without_unseen(problem, smaller)
    return found


def _put_back(problem: Problem, z: Array) -> list[int]:
    """Return the variables of effects that are none or typical at z: they stay so."""
    return [j for j, free in enumerate(problem.freedoms)
            if free.of_effect and z[j] == free.without_size]


def _fitted_beside(problem: Problem, z: Array, slopes: Array) -> Fit:
    """Return the fit of all variables but those that have been put back."""
    held = _put_back(problem, z)
    others = np.setdiff1d(np.arange(len(z)), held)
    if len(others):
        z, slopes = z.copy(), slopes.copy()
        end = _descended(problem.holding(z, held), [z[others]], slopes[:, others])
        z[others], slopes[:, others] = end.z, end.jacobian
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
    """Return the fit with `slopes_along_axes`, and a step further, but of what was put back."""
    columns = found.jacobian if not problem.observation.finer else problem.jacobian(
        found.z, found.residuals, found.jacobian)  # over several slips again
    slopes = slopes_along_axes(problem, found.z, found.residuals, columns)
    room = np.array(problem.bounds()) - found.z
    others = np.setdiff1d(np.arange(len(found.z)), _put_back(problem, found.z))
    step = np.zeros(len(found.z))
    step[others] = lsq_linear(slopes[:, others], -found.residuals, room[:, others]).x
    further = fit_at(problem, found.z + step, slopes)
    return further if further.cost < found.cost else replace(found, jacobian=slopes)
