# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
A fit that follows a stem from slip to slip.

Over a whole record, the cost of a model whose friction is a hundredth off is as high as with any
other friction, but in a hollow around the right one that no descent finds from outside. Over the
first few slips that hollow is wide. So the record is met from its beginning (with a growing end, as
for other oscillators: H. U. Voss, J. Timmer, J. Kurths, Int. J. Bifurcation and Chaos 14 (2004)
1905):

1. sliding friction and stiction are tried on a grid around what the record itself shows (see
   sawtooth), over a few seconds from where the stem first goes;
2. all is fitted to these seconds from the best of them;
3. the end goes on by a quarter, and the fits that keep step best (see in_step) are fitted again to
   the windows in which they are in step, and once more where these have become more;
4. where too many windows are missed at the end, the first seconds told too little, and a later
   first end is tried.

Where the model misses a slip, it may be in step again after the stem has come to rest or turned: no
window that is missed ends the search. Every fit forms its slopes over short steps: in step, the
cost is smooth. Only packings that do not yield are followed: one that yields comes to rest softly,
and the other fits meet it.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
import itertools

import numpy as np

from booster_ros.diagnosis.fitting.fit import Fit, Problem
from booster_ros.diagnosis.fitting.friction_start import with_friction
from booster_ros.diagnosis.fitting.in_step import MISSED, cost_in_step, fitted_in_step, steps
from booster_ros.diagnosis.fitting.sawtooth import Saw, read_saw, rows_going
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
FOLLOWING = (6, 6, 6, 3, 2)
"""Number of fits at the first end, and numbers that are fitted again at the next ones; the last
number is that of all further ends."""

EVALUATIONS, EVALUATIONS_IN_STEP = 10, 6


def fit_slip_by_slip(problem: Problem, z: Array) -> Fit | None:
    """
    Return the fit that follows the slips, with all but friction begun at z; None if none does.

    None as well where no friction is free, or where the record does not show the stem go.
    """
    saw, going = read_saw(problem, z), rows_going(problem, z)
    if saw is None or not any(free.knob.rubs for free in problem.freedoms):
        return None
    problem = replace(problem, fine=True)
    grid = list(_grid(problem, z, saw))
    begins = float(problem.experiment.time[going][0])
    for first in FIRST_ENDS if grid else ():
        found = _followed(problem, grid, begins, first)
        missed = steps(problem, found).missed(going)
        if missed < MISSED:
            return problem.at(found) if missed else problem.fit(found, EVALUATIONS)
    return None


def _followed(problem: Problem, grid: list[Array], begins: float, first: float) -> Array:
    """Return z of the fit that keeps step best at the end of the record."""
    part = problem.until(begins + first)
    places = [part.fit(z, EVALUATIONS).z for z in _best(part.cost, grid, STARTS)]
    for following in itertools.chain(FOLLOWING, itertools.repeat(FOLLOWING[-1])):
        places = _best(partial(cost_in_step, part), places, following)
        if begins + first >= problem.experiment.time[-1]:
            break
        first *= FURTHER
        part = problem.until(begins + first)
        places = [fitted_in_step(part, z, EVALUATIONS_IN_STEP) for z in places]
    return places[0]


def _best(cost: Callable[[Array], float], places: list[Array], number: int) -> list[Array]:
    """Return so many of the places as cost least, the best first."""
    return [places[k] for k in np.argsort(side_by_side(cost, places))[:number]]


def _grid(problem: Problem, z: Array, saw: Saw) -> Iterator[Array]:
    """Yield z with each friction that is to be tried."""
    for high, low in itertools.product(HIGH, LOW):
        sliding = low * saw.low
        if high * saw.high >= sliding > 0.0:
            yield with_friction(problem, z, sliding, high * saw.high / sliding - 1.0, False)
