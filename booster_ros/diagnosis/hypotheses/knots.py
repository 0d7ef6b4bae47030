# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where a term without a name has its knots: dense where it bends, and how it ends."""

from dataclasses import replace

import numpy as np

from booster_ros.diagnosis.estimation.fit import Fit
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.model.discrepancy import KNOTS, Discrepancy, has_play, interpolate

Array = np.ndarray

EVENLY = 0.4
"""Share of the knots that stay spread evenly, however much a term bends in one place."""

CROWDED = 4.0
"""Power with which knots about zero lie further apart the further off they are."""

ROUNDING = 1e-6
"""Share of the steepest slope, up to which slopes are the same but for rounding, and of a variable
that hardly changes, by which knots are apart: rounding shifts none over another."""

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


def with_knots(problem: Problem, knots: Array) -> Problem:
    """Return the problem with a table that has its values there: rising, shape (KNOTS,)."""
    table = problem.base.discrepancy._replace(knots=tuple(knots.tolist()))
    return replace(problem, base=problem.base._replace(discrepancy=table))


def where_it_bends(table: Discrepancy) -> Array:
    """
    Return knots over the same range that are dense where the term bends, shape (KNOTS,).

    What a broken line misses of a curve between two knots goes with the curvature times their
    distance squared. It is the same everywhere if knots are as dense as the square root of the
    curvature (de Boor, A Practical Guide to Splines, ch. XII, NEWNOT).
    """
    knots, values = np.array(table.knots[1:-1]), np.array(table.values[1:-1])
    widths = np.diff(knots)
    slopes = np.diff(values) / widths
    turns = np.abs(np.diff(slopes))
    turns[turns < ROUNDING * np.abs(slopes).max()] = 0.0
    bends = turns / (0.5 * (widths[1:] + widths[:-1]))
    curvature = 0.5 * (np.r_[bends[:1], bends] + np.r_[bends, bends[-1:]])
    due = np.sqrt(curvature) * widths
    even = widths / widths.sum()
    due = (1.0 - EVENLY) * due / due.sum() + EVENLY * even if due.sum() > 0.0 else even
    inner = np.interp(np.linspace(0.0, 1.0, KNOTS - 2), np.r_[0.0, np.cumsum(due)], knots)
    inner[[0, -1]] = knots[[0, -1]]
    return np.r_[table.knots[0], inner, table.knots[-1]]


def looking_closer(problem: Problem, fit: Fit) -> tuple[Problem, Array]:
    """Return the problem with knots where its fitted term bends, and z with the term as fitted."""
    table = fit.parameters.discrepancy
    knots, z = where_it_bends(table), fit.z.copy()
    for j, free in enumerate(problem.freedoms):
        if free.knob.parameter == 'discrepancy.values':
            z[j] = free.variable(interpolate(table, float(knots[free.element])))
    return with_knots(problem, knots), z


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
    return with_knots(problem, np.r_[knots[0] - below, knots, knots[-1] + above])
