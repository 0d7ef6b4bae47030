# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How much more than white noise residuals are: their over-dispersion and autocorrelation."""

from collections.abc import Sequence

import numpy as np

Array = np.ndarray

FEWEST = 12
"""Number of values of which an autocorrelation is told: of fewer, pairs of lags are chance."""


def dispersion(series: Sequence[Array]) -> float:
    """
    Return c of what is left: its mean square times its autocorrelation time, 1 at the least.

    `series` are residuals in standard deviations of the noise. The autocorrelation time is
    1 + 2 sum rho_k up to where pairs of neighbouring rho_k are no longer positive (C. Geyer,
    Statistical Science 7 (1992) 473).
    """
    squares = [float(each @ each) * autocorrelation_time(each) for each in series]
    return max(1.0, sum(squares) / max(sum(map(len, series)), 1))


def autocorrelation_time(values: Array) -> float:
    """Return the autocorrelation time of a series in its rows, 1 for white noise."""
    if len(values) < FEWEST or not np.any(values):
        return 1.0
    size = 1 << (2 * len(values) - 1).bit_length()
    spectrum = np.abs(np.fft.rfft(values, size))**2
    rho = np.fft.irfft(spectrum, size)[:len(values) // 2]
    rho /= rho[0]
    pairs = rho[1:len(rho) - 1:2] + rho[2::2][:len(rho[1:len(rho) - 1:2])]
    positive = int(np.argmin(pairs > 0.0)) if np.any(pairs <= 0.0) else len(pairs)
    return float(max(1.0, 1.0 + 2.0 * np.sum(pairs[:positive])))
