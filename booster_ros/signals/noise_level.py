# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The level of the measurement noise, from the record alone and never from fit residuals.

Differences of third order remove whatever moves slowly compared with the sampling; what remains is
noise. For white noise of variance s² a third difference has variance 20 s². What moves faster than
that, such as a stem that slips, is in them too; then the quietest pieces of the record tell the
level.
"""

import numpy as np

Array = np.ndarray

_THIRD_DIFFERENCE_GAIN = 20.0
_MAD_TO_SIGMA = 1.4826

FEWEST_DIFFERENCES = 8

PIECE = 100
FEWEST_PIECES = 20
QUIET = 0.1
"""Rows in a piece of a record, smallest number of pieces, and the share of them that are the
quietest."""

LOUD = 0.85
"""Level that the quietest pieces tell, as a share of the level that all differences tell, below
which pieces are not alike."""

REPEATS = 0.2
"""Share of the rows of a piece that read as the row before, or as the end itself, from which the
piece lies at an end of its sensor: where steps are finer than `FINE`, less than half as many rows
repeat the one before."""

FINE = 0.3
"""Step of a rounded signal, as a share of the noise, up to which it moves the median of
differences by less than 5 %."""

FROZEN = 8
"""Number of successive rows that read the same value from which a channel is frozen."""

FLICKERS = 0.16
"""Variance of noise and rounding, in squares of a step, below which noise is read from its
flicker: there both ways of reading it come nearest to each other."""


def white_noise(signal: Array) -> float:
    """
    Return the standard deviation of the white noise on an evenly sampled signal (its unit).

    Where most rows are empty, as in a channel slower than the others, only those with a value
    count. NaN where there are too few.
    """
    signal = off_its_ends(_alive(signal))
    third = _third_differences(signal)
    if len(third) < FEWEST_DIFFERENCES:
        return float('nan')
    mad = _spread(third)
    # coarse steps make the median of differences a multiple of the step, even zero
    if mad == 0.0 or len(np.unique(third)) < 30:
        low, high = np.quantile(third, [0.02, 0.98])
        kept = third[(third >= low) & (third <= high)]
        mad = float(np.std(kept))
    level = float(mad / np.sqrt(_THIRD_DIFFERENCE_GAIN))
    quiet = _noise_of_quiet_pieces(signal)
    return quiet if quiet < LOUD * level else level


def _alive(signal: Array) -> Array:
    """
    Return the signal without values (NaN) where it reads the same again and again, shape (n,).

    A sensor that freezes, or is cut off, shows no noise there, and the noise that it shows
    elsewhere is that of the channel. The signal is returned as it is where values repeat elsewhere
    as well, as then its steps are coarse.
    """
    known = np.flatnonzero(np.isfinite(signal))
    begins = np.append(True, np.diff(signal[known]) != 0.0)
    runs = np.flatnonzero(begins)
    lengths = np.diff(np.append(runs, len(known)))
    frozen = np.repeat(lengths >= FROZEN, lengths)
    moving = np.count_nonzero(~frozen)
    repeats = np.count_nonzero(~begins & ~frozen)
    if moving == len(known) or moving < PIECE or repeats > 0.5 * REPEATS * moving:
        return signal
    alive = signal.copy()
    alive[known[frozen]] = np.nan
    return alive


def off_its_ends(signal: Array) -> Array:
    """
    Return the signal without values (NaN) in pieces in which its sensor is at an end, shape (n,).

    The sensor cuts off noise there: such a piece reads the lowest or highest value again and
    again. The signal is returned as it is where too few pieces would be left.
    """
    if not np.isfinite(signal).any():
        return signal
    at_end = (signal == np.nanmin(signal)) | (signal == np.nanmax(signal))
    whole = len(signal) // PIECE * PIECE
    ends = np.mean(at_end[:whole].reshape(-1, PIECE), axis=1) >= REPEATS
    rows = np.append(np.repeat(ends, PIECE), np.full(len(signal) - whole, ends[-1:].any()))
    inside = np.where(rows, np.nan, signal)
    return inside if np.isfinite(inside).sum() >= FEWEST_PIECES * PIECE else signal


def _noise_of_quiet_pieces(signal: Array) -> float:
    """
    Return the level of white noise whose quietest pieces are as quiet as those of the signal.

    Pieces that lie at an end of the sensor do not count, as noise is cut off there. Infinite where
    there are too few pieces.
    """
    known = signal[np.isfinite(signal)]
    pieces = known[:len(known) // PIECE * PIECE].reshape(-1, PIECE)
    pieces = pieces[np.mean(np.diff(pieces) == 0.0, axis=1) < REPEATS]
    if len(pieces) < FEWEST_PIECES:
        return float('inf')
    white = np.random.default_rng(1).standard_normal(pieces.shape)
    quiet, by_chance = (np.quantile([_spread(np.diff(piece, 3)) for piece in some], QUIET)
                        for some in (pieces, white))
    return float(quiet / by_chance)


def _third_differences(signal: Array) -> Array:
    third = np.diff(signal, 3)
    third = third[np.isfinite(third)]
    if len(third) < 0.5 * len(signal):
        third = np.diff(signal[np.isfinite(signal)], 3)
    return third


def _spread(values: Array) -> float:
    """Return the standard deviation of normal values, from their median absolute deviation."""
    return _MAD_TO_SIGMA * float(np.median(np.abs(values - np.median(values))))


def resolution(signal: Array) -> float:
    """Return the usual step between the values of a signal, 0 if hardly any repeats."""
    known = signal[np.isfinite(signal)]
    values = np.unique(known)
    if len(values) < 2 or len(values) > 0.5 * len(known):
        return 0.0
    return float(np.median(np.diff(values)))


def noise_level(signal: Array) -> float:
    """
    Return the noise of a channel, with what its resolution adds (step / sqrt(12) at the least).

    0 for one that stands still; where too few rows tell the noise, only what its resolution adds.
    """
    step, level = resolution(signal), white_noise(signal)
    if step > FINE * level or not np.isfinite(level):
        return _rounded_noise(off_its_ends(signal), step)
    return level


def _rounded_noise(signal: Array, step: float) -> float:
    """
    Return the noise of a signal that is rounded to multiples of `step`.

    Differences of such a signal are multiples of the step as well, and so is their median. A dither
    of one step, whose variance is known, takes that away (Wannamaker et al., 2000). Where the noise
    is well below a step, most rows are rounded alike, and the noise shows as flicker where the
    signal passes from one value to the next: on a signal anywhere between two values, noise s
    leaves the variance step * s / sqrt(pi).
    """
    least = step**2 / 12.0
    third = _third_differences(signal)
    if len(third) < FEWEST_DIFFERENCES:
        return float(np.sqrt(least))
    dither = step * (np.random.default_rng(1).random(len(signal)) - 0.5)
    dithered = _spread(_third_differences(signal + dither))**2 / _THIRD_DIFFERENCE_GAIN - least
    if dithered > FLICKERS * step**2:
        return float(np.sqrt(dithered))
    # one flicker has differences of up to three steps; what moves faster is no noise
    flicker = np.mean(np.clip(third, -4.0 * step, 4.0 * step)**2) / _THIRD_DIFFERENCE_GAIN
    noise = min(flicker * np.sqrt(np.pi) / step, np.sqrt(FLICKERS * step**2 - least))
    return float(np.hypot(noise, np.sqrt(least)))
