# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Pieces of a record in which what is faster than a cubic is noise, as nothing drives the valve so.

1. Where every drive has stood still for a few seconds the valve has settled: pieces of such rests,
   about a second each.
2. Where there are few rests, pieces of half a second in which every drive moves along a cubic, and
   has done so for a while. The valve moves in them, but smoothly.
"""

from collections.abc import Callable, Sequence

import numpy as np
from scipy.ndimage import median_filter, uniform_filter1d

from booster_ros.signals.autoregression import without
from booster_ros.signals.noise_level import white_noise

Array = np.ndarray

FEWEST_PIECES = 12
"""Number of pieces below which they say nothing of how noise carries over."""

SETTLING = 3.0
"""Time that a drive has stood still before a rest begins, s: a chamber fills in seconds."""

PIECE = 1.0
FEWEST_ROWS, MOST_ROWS = 32, 500
"""Length of a piece of a rest, s, and the smallest and largest number of its rows: what is
reckoned with the covariance of a piece takes the cube of this number."""

CATCHING_UP = 0.25
"""Time that a drive has moved smoothly before a piece begins in which the valve moves, s: what is
faster than a chamber, such as an E/P converter, has caught up with it by then."""

MOVING_PIECE, FEWEST_MOVING_ROWS = 0.5, 20
"""Length of such a piece, s, and the smallest number of its rows: a valve moves along a cubic for
that long, and hardly for longer."""

SHARPER = 5
"""A noisy drive is averaged over one in so many rows of a smooth piece: over all of them a jump
would become a ramp, which a cubic follows."""

STILL = 6.0
STILL_SHARE = 1e-3
"""Largest range of a drive at rest, or off a cubic. It is STILL standard deviations of the white
part of its noise, for the means it is judged by (those of coloured noise vary as much), but at
least the share STILL_SHARE of the drive's range over the record."""

FLICKER = 5
"""Number of rows whose median a drive that holds its values is compared with, for its flicker."""


def calm_pieces(time: Array, drives: Sequence[Array]) -> list[slice]:
    """
    Return equally long pieces of a record, of rests or, where these are few, of smooth motion.

    Time in s, shape (n,), like each drive. Pieces do not overlap and have no gap within. None where
    there are fewer than FEWEST_PIECES.
    """
    for pieces in (rests_of, smooth_pieces):
        found = pieces(time, drives)
        if len(found) >= FEWEST_PIECES:
            return found
    return []


def rests_of(time: Array, drives: Sequence[Array]) -> list[slice]:
    """Return pieces in which every drive has stood still and settled, as in `calm_pieces`."""
    usual = _usual_step(time)
    rows = min(max(round(PIECE / usual), FEWEST_ROWS), MOST_ROWS)
    return _pieces(time, drives, rows, round(SETTLING / usual), np.ptp, smoothed=rows)


def smooth_pieces(time: Array, drives: Sequence[Array]) -> list[slice]:
    """
    Return pieces in which every drive moves along a cubic, as in `calm_pieces`.

    None where a piece would have fewer than FEWEST_MOVING_ROWS.
    """
    usual = _usual_step(time)
    rows, lead = min(round(MOVING_PIECE / usual), MOST_ROWS), round(CATCHING_UP / usual)
    if rows < FEWEST_MOVING_ROWS:
        return []
    curves = cubics(lead + rows)
    return _pieces(time, drives, rows, lead, lambda drive: np.ptp(without(drive, curves)),
                   smoothed=rows // SHARPER)


def cubics(rows: int) -> Array:
    """Return orthonormal columns, shape (rows, 4), that make up any cubic over as many rows."""
    return np.asarray(np.linalg.qr(np.vander(np.linspace(-1.0, 1.0, rows), 4))[0])


def _pieces(time: Array, drives: Sequence[Array], rows: int, lead: int,
            range_of: Callable[[Array], float], smoothed: int) -> list[slice]:
    """
    Return pieces in which, and for `lead` rows before, the range of no drive is too large.

    A noisy drive is judged by its means over `smoothed` rows.
    """
    steps = np.diff(time)
    usual = _usual_step(time)
    moving = [_judged_by(drive, smoothed) for drive in drives if np.ptp(drive) > 0.0]
    pieces = []
    first = lead
    while first + rows <= len(time):
        whole = slice(first - lead, first + rows)
        even = np.max(steps[whole.start:whole.stop - 1]) < 1.5 * usual
        if even and all(range_of(drive[whole]) <= most for drive, most in moving):
            pieces.append(slice(first, first + rows))
            first += rows
        else:
            first += max(rows // 4, 1)
    return pieces


def _usual_step(time: Array) -> float:
    return float(np.median(np.diff(time)))


def _judged_by(drive: Array, rows: int) -> tuple[Array, float]:
    """Return what tells whether a drive stands still, less its noise, and its most range then."""
    noise, least = _noise_of_drive(drive), STILL_SHARE * float(np.ptp(drive))
    if STILL * noise <= least:
        return drive, least
    return uniform_filter1d(drive, rows, mode='nearest'), STILL * noise


def _noise_of_drive(drive: Array) -> float:
    """Return the white part of the noise of a drive, whose jumps are none."""
    if np.count_nonzero(np.diff(drive)) < 0.5 * len(drive):
        # it holds most values: what comes back within a row or two is flicker, what stays is a jump
        return float(np.std(drive - median_filter(drive, FLICKER, mode='nearest')))
    # not `noise_level`, which counts resolution: levels of a stair are no resolution
    return float(np.nan_to_num(white_noise(drive)))
