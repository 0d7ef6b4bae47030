# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The level of the measurement noise, from the record alone and never from fit residuals.

Differences of third order remove whatever moves slowly compared with the sampling; what remains is
noise. For white noise of variance s² a third difference has variance 20 s².
"""

import numpy as np

Array = np.ndarray

_THIRD_DIFFERENCE_GAIN = 20.0
_MAD_TO_SIGMA = 1.4826


def white_noise(signal: Array) -> float:
    """
    Return the standard deviation of the white noise on an evenly sampled signal (its unit).

    Where most rows are empty, as of a channel slower than the others, of the rows it has.
    """
    third = np.diff(signal, 3)
    third = third[np.isfinite(third)]
    if len(third) < 0.5 * len(signal):
        third = np.diff(signal[np.isfinite(signal)], 3)
    if len(third) < 8:
        return float('nan')
    middle = np.median(third)
    mad = _MAD_TO_SIGMA * float(np.median(np.abs(third - middle)))
    # coarse steps make the median of differences a multiple of the step, even zero
    if mad == 0.0 or len(np.unique(third)) < 30:
        low, high = np.quantile(third, [0.02, 0.98])
        kept = third[(third >= low) & (third <= high)]
        mad = float(np.std(kept))
    return mad / np.sqrt(_THIRD_DIFFERENCE_GAIN)


def resolution(signal: Array) -> float:
    """Return the usual step between the values of a signal, 0 if hardly any repeats."""
    known = signal[np.isfinite(signal)]
    values = np.unique(known)
    if len(values) < 2 or len(values) > 0.5 * len(known):
        return 0.0
    return float(np.median(np.diff(values)))


def noise_level(signal: Array) -> float:
    """
    Return the noise of a channel, at least what its resolution explains (step / sqrt(12)).

    0 for one that stands still or has too few rows to tell.
    """
    floor = resolution(signal) / np.sqrt(12.0)
    level = white_noise(signal)
    return max(level, floor) if np.isfinite(level) else floor
