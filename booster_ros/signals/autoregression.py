# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
How much of a first-order autoregression carries over from row to row, told by short pieces.

The model: in each piece of a signal,

    y = curve + x + rounding,   x[i] = a x[i-1] + e[i],   var x = level²,

where the curve is any combination of some given curves (a cubic, say), and rounding is white and of
known variance. What the curves take away of slow noise is allowed for: the likelihood is that of
what they leave (restricted maximum likelihood; Patterson & Thompson, 1971, Biometrika 58). It is
formed from the innovations of a Kalman filter, for many coefficients at once.

Short pieces of slow noise tell little of how slow it is, as all that is slower than a piece looks
alike: the likelihood runs flat towards 1, where the level would be several times what it is. So the
coefficient is the median of its posterior for a flat prior, not the place of the maximum.
"""

import numpy as np
from scipy.linalg import toeplitz

Array = np.ndarray

POINTS = 61
"""Number of coefficients for which the likelihood is formed at once."""

WITHIN = 1e-6
"""Share of the posterior that is left out at either end where it is looked at more closely."""


def coefficient_and_level(
    pieces: Array, curves: Array, rounded: float, among: tuple[float, float]
) -> tuple[float, float]:
    """
    Return the coefficient and the level of the noise in pieces, shape (pieces, rows).

    `curves`, shape (rows, curves), are what else there may have been in each piece, orthonormal;
    the pieces are what they leave (`without`). `rounded` is the variance of rounding, `among` the
    ends between which the coefficient is looked for. The level is the standard deviation without
    rounding, in the unit of the pieces.
    """
    low, high = among
    for _ in range(2):  # all of the posterior, then where it is
        tried = np.linspace(low, high, POINTS)
        likelihood, level = _restricted(pieces, curves, rounded, tried)
        density = np.exp(likelihood - np.max(likelihood))
        share = np.append(0.0, np.cumsum(density[1:] + density[:-1]))
        share /= share[-1]
        first, last = np.searchsorted(share, [WITHIN, 1.0 - WITHIN])
        low, high = tried[max(first - 1, 0)], tried[min(last, POINTS - 1)]
    coefficient = float(np.interp(0.5, share, tried))
    return coefficient, float(np.interp(coefficient, tried, level))


def left_by(coefficient: float, curves: Array, lags: int) -> Array:
    """
    Return the covariances by lag, shape (lags,), that curves leave of noise of variance 1.

    They are means over the rows of a piece, the fewer of larger lags divided by all rows as well;
    `curves` as in `coefficient_and_level`.
    """
    rows = len(curves)
    removed = without(np.eye(rows), curves)
    covariance = removed @ toeplitz(coefficient ** np.arange(rows)) @ removed
    return np.array([np.trace(covariance, lag) for lag in range(lags)]) / rows


def without(pieces: Array, curves: Array) -> Array:
    """Return what is left of pieces, shape (pieces, rows), when the best curves are taken off."""
    return pieces - (pieces @ curves) @ curves.T


def _restricted(pieces: Array, curves: Array, rounded: float, tried: Array
                ) -> tuple[Array, Array]:
    """Return log likelihood and level for each coefficient tried, shape (coefficients,) each."""
    rows, parts = curves.shape
    removed = without(np.eye(rows), curves)
    by_lag = np.array([np.trace(removed, lag) for lag in range(rows)]) / rows
    variance = max(np.mean(pieces**2) - rounded * by_lag[0], 1e-30) / (
        2.0 * np.polynomial.polynomial.polyval(tried, by_lag) - by_lag[0])
    squares, logarithm = _innovations(pieces, curves, tried, rounded / variance)
    degrees = len(pieces) * (rows - parts)
    return (-0.5 * (degrees * np.log(squares) + len(pieces) * logarithm),
            np.sqrt(squares / degrees))


def _innovations(pieces: Array, curves: Array, tried: Array, white: Array
                 ) -> tuple[Array, Array]:
    """
    Return what the best curves leave of the whitened pieces, squared, and a piece's logarithm.

    Summed over all pieces, for each coefficient tried; the logarithm is that of the determinant of
    the covariance of what curves leave. `white` is the variance of rounding, where x has 1.
    """
    columns = np.vstack([curves.T, pieces])
    parts = curves.shape[1]
    expected = np.zeros((len(tried), len(columns)))
    variance, logarithm = np.ones(len(tried)), np.zeros(len(tried))
    squares = np.zeros(len(tried))
    with_curves = np.zeros((len(tried), parts, len(columns)))
    for row in columns.T:
        seen = variance + white
        new = (row - expected) / np.sqrt(seen)[:, None]
        squares += np.sum(new[:, parts:]**2, axis=1)
        with_curves += new[:, :parts, None] * new[:, None]
        logarithm += np.log(seen)
        gain = variance / seen
        expected = tried[:, None] * (expected + (gain * np.sqrt(seen))[:, None] * new)
        variance = tried**2 * variance * (1.0 - gain) + 1.0 - tried**2
    of_curves, of_pieces = with_curves[:, :, :parts], with_curves[:, :, parts:]
    taken = np.sum(of_pieces * np.linalg.solve(of_curves, of_pieces), axis=(1, 2))
    return squares - taken, logarithm + np.linalg.slogdet(of_curves)[1]
