# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How sure a fitted parameter is, when residuals are coloured."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import lsq_linear

from booster_ros.diagnosis.data.experiment import Array
from booster_ros.diagnosis.estimation.fit import NOTICEABLE, Fit
from booster_ros.diagnosis.estimation.parametrisation import Free
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.model.catalogue import Knob
from booster_ros.model.parameters import DESCRIPTIONS

DRAWS = 400
"""Number of draws: ten of them lie beyond either end of an interval."""

LEVEL = 0.95
"""Confidence of intervals, and of decisions: the usual one."""

WIDEST = 30.0
"""Standard deviation of a size before anything is seen of it, in typical sizes."""

AT_BOUND = 1e-2
"""Distance of a size from its bound, as a share of that, below which it has run into it."""


@dataclass(frozen=True)
class Interval:
    """
    A value with its 95 % interval.

    With `open_above` anything from `low` up may be true, and none as well: none of a stiffness is
    0, and stands beyond all that is large. `high` is then the largest that is looked for.
    """

    value: float
    low: float
    high: float
    unit: str
    open_above: bool = False

    @property
    def is_none(self) -> bool:
        """Whether the value itself is none, as that of a stiffness may be."""
        return self.open_above and self.value < self.low

    def holds_none(self, knob: Knob) -> bool:
        """Tell whether what this knob turns may as well be none."""
        return self.open_above or self.low <= knob.neutral <= self.high


def information(slopes: Array) -> Array:
    """Return J' J + I / WIDEST**2, by which even sizes that hardly show are of typical order."""
    return np.asarray(slopes.T @ slopes + np.eye(slopes.shape[1]) / WIDEST**2)


def block_bootstrap(problem: Problem, fit: Fit, block_of_row: Array) -> Array:
    """
    Return draws of z, shape (DRAWS, variables), by a block bootstrap.

    `block_of_row` says in which block each row of the experiment is. Each draw weighs the blocks by
    how often they were drawn and makes one Gauss-Newton step from the fit. Within a block residuals
    may be as coloured as they like. Priors of declared parameters are drawn too.

    Shapes are drawn with all else free; all else is drawn with the shapes as they were found:
    together they would run through nonsense, as a drift of half the size in half the time is the
    same drift while it is young.
    """
    label = block_of_row[np.concatenate(problem.first_rows)]
    residual, jacobian, data = fit.residuals, fit.jacobian, problem.observed
    blocks = [np.flatnonzero(label == k) for k in np.unique(label)]
    gradients = np.array([jacobian[rows].T @ residual[rows] for rows in blocks])
    hessians = np.array([jacobian[rows].T @ jacobian[rows] for rows in blocks])
    prior = jacobian[data:]
    rng = np.random.default_rng(1)
    several = [(np.bincount(rng.integers(len(blocks), size=len(blocks)), minlength=len(blocks)),
                residual[data:] + rng.standard_normal(len(prior))) for _ in range(DRAWS)]

    def system(counts: Array, centres: Array, which: Array) -> tuple[Array, Array]:
        """Return Hessian and gradient over some variables, of blocks that count so often."""
        hessian = np.tensordot(counts, hessians, 1) + information(prior)
        gradient = counts @ gradients + prior.T @ centres + fit.z / WIDEST**2
        return hessian[np.ix_(which, which)], gradient[which]

    def drawn(which: Array) -> Array:
        """Return draws of some variables with all else as it was found."""
        steps = np.array([np.linalg.solve(*system(*one, which)) for one in several])
        whole = system(np.ones(len(blocks)), residual[data:], which)
        room = np.array(problem.bounds()) - fit.z
        return np.asarray(fit.z[which] - steps + _held_back(*whole, room[:, which]))

    draws = drawn(np.arange(len(fit.z)))
    shapes = [j for j, free in enumerate(problem.freedoms) if free.knob.shape]
    if shapes:
        rest = np.setdiff1d(np.arange(len(fit.z)), shapes)
        draws[:, rest] = drawn(rest)
    return draws


def _held_back(hessian: Array, gradient: Array, room: Array) -> Array:
    """
    Return by how much bounds hold back a Gauss-Newton step; `room` are its least and most.

    A size at its bound would go on beyond it, and draws around there say that it is none for sure.
    """
    # of a record with next to no noise, rounding leaves less of the flattest axes than the ridge
    squares, axes = np.linalg.eigh(hessian)
    lengths = np.sqrt(np.maximum(squares, 1.0 / WIDEST**2))
    aim = -(axes.T @ gradient) / lengths
    free = axes @ (aim / lengths)
    if np.all((room[0] <= free) & (free <= room[1])):
        return np.zeros(len(free))
    return np.asarray(lsq_linear(lengths[:, None] * axes.T, aim, (room[0], room[1])).x - free)


def interval_of(problem: Problem, draws: Array, fit: Fit, index: int) -> Interval:
    """
    Return the value and 95 % interval of a parameter, within its bounds.

    The interval is as long to either side, in z, as 95 % of the draws are off the fit: quantiles of
    skewed draws are off to the wrong side (Hall, 1992, The Bootstrap and Edgeworth Expansion,
    section 3.5). Of a variable that shows nowhere, such as the lift of a seat that is never
    reached, it is all of its range. That of a stiffness or restriction that may as well be none is
    open above.
    """
    free = problem.freedoms[index]
    off = np.quantile(np.abs(draws[:, index] - fit.z[index]), LEVEL)
    if np.linalg.norm(fit.jacobian[:, index]) < NOTICEABLE:
        off = np.inf
    ends = [free.value(float(np.clip(z, free.low, free.high)))
            for z in (fit.z[index] - off, fit.z[index] + off)]
    open_above = free.knob.inverse > 0 and free.knob.neutral in ends
    if open_above:
        ends = [free.knob.high if end == free.knob.neutral else end for end in ends]
    return Interval(free.value(fit.z[index]), min(ends), max(ends),
                    DESCRIPTIONS[free.knob.parameter].unit, open_above)


def at_bound(free: Free, z: float) -> bool:
    """Tell whether a parameter has run into a bound that is not its neutral value, 0."""
    return any(abs(z - end) < AT_BOUND * abs(end) for end in (free.low, free.high))
