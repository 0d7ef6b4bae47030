# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where in a record the set point stands, steps, runs up or down: what figures are taken from."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

Array = np.ndarray

FEWEST_ROWS = 5
"""Rows that a set point must stand for to be a level."""

REST_SHARE = 0.25
"""Share of a level, its last, in which the position must rest to have settled."""


class Course(NamedTuple):
    """Time (s), set point (m) and position (m) of a record, shape (n,) each, all finite."""

    time: Array
    set_point: Array
    position: Array


class Level(NamedTuple):
    """Rows `first` to `last` (included) in which the set point stands at `value` m."""

    first: int
    last: int
    value: float


class Ramp(NamedTuple):
    """Rows `first` to `last` in which the set point moves in one direction, `rate` m/s."""

    first: int
    last: int
    rate: float


def levels(course: Course) -> list[Level]:
    """Return where the set point stands for at least FEWEST_ROWS rows."""
    changes = np.flatnonzero(np.diff(course.set_point) != 0.0) + 1
    edges = np.concatenate(([0], changes, [len(course.set_point)]))
    return [Level(int(a), int(b) - 1, float(course.set_point[a]))
            for a, b in pairwise(edges) if b - a >= FEWEST_ROWS]


def steps(found: list[Level]) -> list[tuple[Level, Level]]:
    """Return the pairs of levels that follow each other at once."""
    return [(one, other) for one, other in pairwise(found) if other.first == one.last + 1]


def ramps(course: Course, found: list[Level]) -> list[Ramp]:
    """Return where the set point moves in one direction, between levels, over FEWEST_ROWS rows."""
    moves = np.sign(np.diff(course.set_point))
    for level in found:
        moves[max(level.first - 1, 0):level.last] = 0.0
    edges = np.flatnonzero(np.diff(moves) != 0.0) + 1
    bounds = np.concatenate(([0], edges, [len(moves)]))
    out = []
    for a, b in pairwise(bounds):
        if moves[a] != 0.0 and b - a >= FEWEST_ROWS:
            length = course.time[b] - course.time[a]
            out.append(Ramp(int(a), int(b), float(
                (course.set_point[b] - course.set_point[a]) / length)))
    return out


def noise_level(course: Course) -> float:
    """
    Return the standard deviation of the noise of the position, m.

    From the fifth of the second differences that are smallest, which are those of the rows at rest:
    of a normal distribution they are within 0.2533 standard deviations. A position that is read in
    coarse steps has at least the noise of its rounding.
    """
    bends = np.abs(np.diff(course.position, 2))
    white = float(np.quantile(bends, 0.2)) / 0.2533 / np.sqrt(6.0)
    sizes = np.abs(np.diff(course.position))
    apart = sizes[sizes > 0.0]
    rounding = float(apart.min()) / np.sqrt(12.0) if len(apart) else 0.0
    return max(white, min(rounding, 1e-5))


def rest_of(course: Course, level: Level) -> slice:
    """Return the last rows of a level, in which the position should rest."""
    size = level.last + 1 - level.first
    return slice(level.last + 1 - max(int(REST_SHARE * size), 3), level.last + 1)
