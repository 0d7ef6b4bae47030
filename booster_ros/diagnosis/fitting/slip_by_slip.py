# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
A fit that follows a stem from slip to slip.

A model whose friction is a hundredth off slips now and then where the valve does not, and from then
on is out of step: over a whole record, the cost is as high as with any other friction, but in a
hollow around the right one that no descent finds from outside. Over the first few slips that hollow
is wide. So the record is met from its beginning (with a growing end, as for other oscillators:
H. U. Voss, J. Timmer, J. Kurths, Int. J. Bifurcation and Chaos 14 (2004) 1905):

1. sliding friction and stiction are tried on a grid around what the record itself shows (see
   sawtooth), over a few seconds from where the stem first goes;
2. all is fitted to these seconds from the best of them;
3. the end goes on by a quarter, and the fits that follow best are fitted again, as long as one of
   them is in step;
4. where none is any more, the first fits told too little, and a later first end is tried.

Every fit forms its slopes over short steps: in step, the cost is smooth. Only packings that do not
yield are followed: one that yields comes to rest softly, and the other fits meet it.
"""

from collections.abc import Iterator
from dataclasses import replace
import itertools

import numpy as np

from booster_ros.diagnosis.fitting.fit import Fit, Problem
from booster_ros.diagnosis.fitting.friction_start import with_friction
from booster_ros.diagnosis.fitting.sawtooth import Saw, first_going, read_saw
from booster_ros.diagnosis.fitting.side_by_side import side_by_side

Array = np.ndarray

FIRST_ENDS = (2.0, 4.0)
"""Times after the stem first goes, s, up to which the first fits go."""

FURTHER = 1.25
"""Factor on the time from where the stem first goes to each next end."""

HIGH, LOW = np.arange(0.96, 1.035, 0.01), np.arange(0.95, 1.165, 0.01)
"""Shares of the ends of the saw of which break-away and sliding friction are tried: a stem that
slips goes on below its sliding friction, by a tenth or so."""

STARTS = 12
FOLLOWING = (6, 6, 6, 3, 3, 3, 3, 1)
"""Number of fits at the first end, and numbers that are fitted again at the next ones; the last
number is that of all further ends."""

EVALUATIONS = 10

OUT_OF_STEP, IN_STEP = 2.5, 1.15
"""Mean squares above which the best fit has lost the slips, and up to which it met all of them."""


def fit_slip_by_slip(problem: Problem, z: Array) -> Fit | None:
    """
    Return the fit that follows all slips, with all but friction begun at z; None if none does.

    None as well where no friction is free, or where the record does not show the stem go.
    """
    saw, begins = read_saw(problem, z), first_going(problem, z)
    if saw is None or begins is None or not any(free.knob.rubs for free in problem.freedoms):
        return None
    grid = list(_grid(problem, z, saw))
    followed = (_followed(problem, grid, begins, first) for first in FIRST_ENDS)
    return next((fit for fit in followed if fit and problem.mean_square(fit) < IN_STEP), None)


def _followed(problem: Problem, grid: list[Array], begins: float, first: float) -> Fit | None:
    """Return the best fit at the end of the record, None where none was in step before."""
    part = replace(problem.until(begins + first), fine=True)
    costs = side_by_side(part.cost, grid)
    places = [grid[k] for k in np.argsort(costs)[:STARTS]]
    for following in itertools.chain(FOLLOWING, itertools.repeat(FOLLOWING[-1])):
        fits = sorted((part.fit(z, EVALUATIONS) for z in places), key=lambda fit: fit.cost)
        if begins + first >= problem.experiment.time[-1]:
            return fits[0]
        if not fits or part.mean_square(fits[0]) > OUT_OF_STEP:
            break
        first *= FURTHER
        places = [fit.z for fit in fits[:following]]
        part = replace(problem.until(begins + first), fine=True)
    return None


def _grid(problem: Problem, z: Array, saw: Saw) -> Iterator[Array]:
    """Yield z with each friction that is to be tried."""
    for high, low in itertools.product(HIGH, LOW):
        sliding = low * saw.low
        if high * saw.high >= sliding > 0.0:
            yield with_friction(problem, z, sliding, high * saw.high / sliding - 1.0, False)
