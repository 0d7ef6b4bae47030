# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The colour of the measurement noise: how much of it carries over from one row to the next.

The colour is taken from calm pieces of the record (`calm_pieces`), with a cubic removed from each,
never from residuals of a fit: what moves slower than a piece is the valve, what is faster is noise.
The noise is a first-order autoregression (`autoregression`). Noise is white, of the level that
high-frequency differences give, in each of these cases: there are few such pieces; its coefficient
is small or no more than chance; the further lags do not fade as it says (a ripple); what is new in
each row is heavy-tailed (a valve that hunts goes in slips); most pieces hold far more than the
quietest (the valve hunts in them). In the last three its colour is not known (`Noise.clouded`).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import solve_banded

from booster_ros.signals.autoregression import (
    coefficient_and_level, left_by, without)
from booster_ros.signals.stationary_segments import FEWEST_PIECES, cubics
from booster_ros.signals.noise_level import noise_level, off_its_ends, resolution

Array = np.ndarray

DISTURBED = 2.0
"""Variance of a piece, and of what is new in each of its rows, relative to the median piece, above
which the valve has moved in it."""

USUAL, ROUNDS = 0.995, 4
"""Quantile of the variance of pieces of noise of the colour found, which counts instead of
DISTURBED if it is more: slow noise varies from piece to piece, what is new in its rows does not.
And most rounds in which the colour is found, as it hangs on which pieces count."""

CHANCE = 3.0
SMALL = 0.1
"""Number of standard errors, and value, both of which the coefficient must exceed to count."""

LAGS = 10
FADING = 0.1
"""Number of lags, in rows, over which noise must fade as a first-order autoregression does, and
how nearly."""

HEAVY_TAILED = 1.0
"""Excess kurtosis from which what is new in each row is no noise: a Gaussian has 0."""

QUIETEST = 0.1
UNEQUAL = 0.6
DRAWN = 400
"""Share of the pieces that are the quietest; ratio of their variance to the median piece's, as a
multiple of the same ratio in drawn pieces, below which the valve moves in most pieces; and number
of drawn pieces."""

_RANGE = (-0.95, 0.99)


@dataclass(frozen=True)
class Noise:
    """
    Noise of a channel: standard deviation and resolution in its unit, AR(1) coefficient by row.

    The level includes what rounding to the resolution adds; a resolution of 0 is no rounding.
    `clouded` noise is taken as white, as more than noise is in the pieces that would tell.
    """

    level: float
    correlation: float = 0.0
    resolution: float = 0.0
    clouded: bool = False

    def added_to(self, signal: Array, rng: np.random.Generator) -> Array:
        """Return the signal, shape (n,), with a draw of this noise, rounded as it was recorded."""
        level = np.sqrt(max(self.level**2 - self.resolution**2 / 12.0, 0.0))
        white = rng.standard_normal(len(signal))
        white[1:] *= np.sqrt(1.0 - self.correlation**2)
        noisy = signal + level * _carried_over(white, self.correlation)
        if self.resolution > 0.0:
            noisy = self.resolution * np.round(noisy / self.resolution)
        return np.asarray(noisy)


def noise_of(signal: Array, calm: Sequence[slice]) -> Noise:
    """
    Return level, colour and resolution of the noise on a signal, the colour from its calm pieces.

    These are equally long; rows without a value (NaN) do not count, nor pieces that have any.
    """
    white = Noise(float(noise_level(signal)), 0.0, resolution(signal))
    inside = off_its_ends(signal)
    pieces = [inside[piece] for piece in calm if np.isfinite(inside[piece]).all()]
    if len(pieces) < FEWEST_PIECES:
        return white
    rows = len(pieces[0])
    curves = cubics(rows)
    every = without(np.array(pieces), curves)
    variance, rounded = np.mean(every**2, axis=1), white.resolution**2 / 12.0
    counts = variance <= DISTURBED * np.median(variance)
    for _ in range(ROUNDS):
        left = every[counts]
        seen = float(np.mean(left**2)) - rounded * (1.0 - curves.shape[1] / rows)
        if seen <= 0.0:
            return white
        coefficient, level = coefficient_and_level(left, curves, rounded, _RANGE)
        # pieces of slow noise differ by much more than those of white noise
        drawn = _drawn(coefficient, curves)
        by_chance = np.mean(drawn**2, axis=1)
        most = max(DISTURBED, float(np.quantile(by_chance, USUAL) / np.median(by_chance)))
        new = every[:, 1:] - coefficient * every[:, :-1]
        of_new = np.mean(new**2, axis=1)
        before, counts = counts, (variance <= most * np.median(variance)) & (
            of_new <= DISTURBED * np.median(of_new))
        if np.array_equal(before, counts):
            break
    slips = _excess_kurtosis(new[before]) > HEAVY_TAILED
    small = abs(coefficient) < max(SMALL, CHANCE / np.sqrt(left.size))
    carried = _carried(left, seen)
    expected = left_by(coefficient, curves, LAGS)
    fades = _fades(carried, expected[1:] / expected[0], drawn, len(left))
    if small:
        return white
    if slips or not fades or _hunts(variance, by_chance):
        return replace(white, clouded=True)
    return Noise(float(np.hypot(level, np.sqrt(rounded))), coefficient, white.resolution)


def _fades(carried: Array, expected: Array, drawn: Array, pieces: int) -> bool:
    """Tell whether noise fades over further rows as is expected, as nearly as drawn pieces do."""
    sets = [drawn[first:first + pieces] for first in range(0, len(drawn) - pieces + 1, pieces)]
    by_chance = [np.max(np.abs(_carried(each, float(np.mean(each**2))) - expected))
                 for each in sets]
    return bool(np.max(np.abs(carried - expected)) < max([FADING, *by_chance]))


def _carried(left: Array, variance: float) -> Array:
    """Return the shares of the variance that carry over to further rows, shape (LAGS - 1,)."""
    rows = left.shape[1]
    return np.array([np.sum(left[:, lag:] * left[:, :rows - lag])
                     for lag in range(1, LAGS)]) / (variance * left.size)


def _hunts(variance: Array, by_chance: Array) -> bool:
    """Tell whether the variances of pieces differ more than those that are drawn."""
    quiet, usual = (np.quantile(each, QUIETEST) / np.median(each) for each in (variance, by_chance))
    return bool(quiet < UNEQUAL * usual)


def _excess_kurtosis(values: Array) -> float:
    """Return the fourth central moment in squares of the second, less the 3 of a Gaussian."""
    off = values - np.mean(values)
    return float(np.mean(off**4) / np.mean(off**2)**2) - 3.0


def _drawn(coefficient: float, curves: Array) -> Array:
    """Return drawn pieces of noise of variance 1 and this colour, less their curves."""
    rows = len(curves)
    drawn = _carried_over(np.sqrt(1.0 - coefficient**2) * np.random.default_rng(1).standard_normal(
        (DRAWN, 2 * rows)), coefficient)
    return without(drawn[:, rows:], curves)


def _carried_over(new: Array, coefficient: float) -> Array:
    """Return what is new in each row with that share of the row before, shape (..., rows)."""
    # scipy.signal's filter takes a second to import
    banded = np.ones((2, new.shape[-1]))
    banded[1] = -coefficient
    return np.asarray(solve_banded((1, 0), banded, new.T).T)
