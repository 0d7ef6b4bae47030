# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where a term without a name has its knots, and how it ends."""

from dataclasses import replace

import numpy as np

from booster_ros.diagnosis.estimation.fit import Fit
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.model.discrepancy import KNOTS, has_play

Array = np.ndarray

CROWDED = 4.0
"""Power with which knots about zero lie further apart the further off they are."""

ROUNDING = 1e-6
"""Share of a variable that hardly changes, by which knots are apart: rounding shifts none over
another."""

LEAST_SIDE = 1e-3
"""Share of the further end of a variable about zero up to which the nearer end is laid at least."""


def evenly(low: float, high: float) -> Array:
    """Return knots at equal distances, shape (KNOTS,), the inner ones from `low` to `high`."""
    spacing = max((high - low) / (KNOTS - 3), ROUNDING * max(abs(low), abs(high)), 1e-12)
    return low + spacing * np.arange(-1.0, KNOTS - 1)


def about_zero(low: float, high: float) -> Array:
    """
    Return knots that are dense about zero, shape (KNOTS,), as many below it as above.

    An error fades: most rows have little of it, and rising and falling differ from zero on. Where
    one side is hardly seen, its knots go as far as LEAST_SIDE of the other.
    """
    shares = (np.arange(1.0, KNOTS // 2 + 1) / (KNOTS // 2 - 1))**CROWDED
    least = LEAST_SIDE * max(abs(low), abs(high), 1.0)
    return np.r_[-max(-low, least) * shares[::-1], max(high, least) * shares]


def with_gentle_ends(problem: Problem, fit: Fit) -> Problem:
    """
    Return the problem with a table that fades to zero no more steeply than it runs as fitted.

    A leak that grows along the travel does not vanish just beyond the last position seen: a valve
    that goes there would meet a step which no record showed. No fade is longer than the range that
    was seen. Over a play the table stays as it is: nothing is beyond a play.
    """
    table = fit.parameters.discrepancy
    if has_play(table):
        return problem
    knots, inner = np.array(table.knots[1:-1]), np.array(table.values[1:-1])
    covers = knots[-1] - knots[0]
    steepest = max(float(np.abs(np.diff(inner) / np.diff(knots)).max()), 1e-300)
    below, above = (float(np.clip(abs(end) / steepest, covers / (KNOTS - 3), covers))
                    for end in inner[[0, -1]])
    table = problem.base.discrepancy._replace(knots=tuple(
        np.r_[knots[0] - below, knots, knots[-1] + above].tolist()))
    return replace(problem, base=problem.base._replace(discrepancy=table))
