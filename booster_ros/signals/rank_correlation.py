# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Whether two signals rise together, however they bend."""

import numpy as np

Array = np.ndarray


def rank_correlation(x: Array, y: Array) -> float:
    """
    Return Spearman's coefficient of two signals of shape (n,), neither of which stands still.

    Values that are equal share the mean of their ranks. Source: C. Spearman, American Journal of
    Psychology 15 (1904) 72.
    """
    return float(np.corrcoef(_ranks(x), _ranks(y))[0, 1])


def _ranks(values: Array) -> Array:
    _, place, count = np.unique(values, return_inverse=True, return_counts=True)
    return (np.cumsum(count) - 0.5 * count)[place]
