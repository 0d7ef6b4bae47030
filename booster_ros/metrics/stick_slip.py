# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Whether the stem moves in jumps, and whether the loop hunts.

Hunting: the position swings about a set point that stands, with a regular period: the mean time
between crossings of its middle is more than three times their scatter (N. F. Thornhill, T.
Hägglund, Control Eng. Practice 5 (1997) 1343). Index of stick-slip: of the way that the position
makes while the set point stands or moves slowly, 90 % falls into this share less of the time than
if it moved evenly, 0 for an even motion, towards 1 for jumps.
"""

from typing import NamedTuple

import numpy as np

from .segments import Course, Level
from .step_response import NOISE_BAND

Array = np.ndarray

FEWEST_CROSSINGS = 6
"""Crossings of the middle that tell a period."""

REGULAR = 3.0
"""Mean over scatter of the times between crossings from which a swing is regular."""

PART_OF_WAY = 0.9

FEWEST_WINDOWS, MOST_WINDOWS = 12, 1000
"""Into how many windows a stretch is divided, within each of which noise is averaged."""


class LimitCycle(NamedTuple):
    """
    A swing about a set point that stands, in rows `first` to `last`.

    `amplitude` is from peak to peak, m, `period` in s, `regularity` the mean time between crossings
    over its scatter, `jumpiness` the index of stick-slip, 0 to 1.
    """

    first: int
    last: int
    amplitude: float
    period: float
    regularity: float
    jumpiness: float


def way_of(position: Array, band: float) -> Array:
    """Return a position without what is within the band: that of a play of this half width."""
    followed = np.empty_like(position)
    place = position[0]
    for k, value in enumerate(position):
        place = min(max(place, value - band), value + band)
        followed[k] = place
    return followed


def stick_slip_index(time: Array, position: Array, noise: float) -> float | None:
    """
    Return the index of stick-slip of a stretch of a record, None where the position stands still.

    `noise` is the standard deviation of the noise of the position, m.
    """
    whole = float(np.abs(np.diff(way_of(position, NOISE_BAND * noise))).sum())
    windows = _windows(len(position), whole, noise)
    if whole <= 2.0 * NOISE_BAND * noise or windows < FEWEST_WINDOWS:
        return None
    edges = np.linspace(0, len(position), windows + 1).astype(int)[:-1]
    counts = np.diff(np.append(edges, len(position)))
    way = np.abs(np.diff(np.add.reduceat(position, edges) / counts))
    length = np.diff(np.add.reduceat(time, edges) / counts)
    order = np.argsort(-way / length)
    made = np.cumsum(way[order]) / way.sum()
    spent = np.cumsum(length[order]) / length.sum()
    needed = float(np.interp(PART_OF_WAY, np.append(0.0, made), np.append(0.0, spent)))
    return max(1.0 - needed / PART_OF_WAY, 0.0)


def _windows(rows: int, way: float, noise: float) -> int:
    """
    Return into how many windows a stretch may be divided.

    The mean positions of windows are still to be further apart, on average, than noise makes them.
    """
    for windows in range(min(rows, MOST_WINDOWS), FEWEST_WINDOWS - 1, -1):
        if way / windows >= NOISE_BAND * noise * np.sqrt(2.0 * windows / rows):
            return windows
    return 0


def limit_cycles(course: Course, found: list[Level], noise: float) -> list[LimitCycle]:
    """Return the regular swings about set points that stand, in their second halves."""
    cycles = []
    for level in found:
        first = (level.first + level.last + 1) // 2
        rows = slice(first, level.last + 1)
        position, time = course.position[rows], course.time[rows]
        if len(position) < 2 * FEWEST_CROSSINGS:
            continue
        band = NOISE_BAND * noise
        amplitude = float(np.ptp(way_of(position, band)))
        crossings = _crossings(time, position, max(band, 0.25 * amplitude))
        if amplitude <= 2.0 * band or len(crossings) < FEWEST_CROSSINGS:
            continue
        between = np.diff(crossings)
        regularity = float(np.mean(between) / max(np.std(between), 1e-3 * np.mean(between)))
        jumpiness = stick_slip_index(time, position, noise)
        if regularity > REGULAR and jumpiness is not None:
            cycles.append(LimitCycle(first, level.last, float(np.ptp(position)),
                                     2.0 * float(np.mean(between)), regularity, jumpiness))
    return cycles


def _crossings(time: Array, position: Array, band: float) -> Array:
    """Return when the position has gone from one side of its middle, by the band, to the other."""
    away = position - 0.5 * (np.max(position) + np.min(position))
    outside = np.flatnonzero(np.abs(away) > 0.5 * band)
    side = np.sign(away[outside])
    return time[outside[1:][np.diff(side) != 0.0]]
