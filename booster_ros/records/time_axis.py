# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where a series of time stamps has gaps."""

import numpy as np

GAP_PERIODS = 5.0
"""A step of time longer than so many median periods is a gap."""

RECURRING = 0.95
"""
Quantile of the steps that is the period, not the median, where it would be a gap: a step that
comes again and again is no gap, but the pause between rows that are written in bursts.
"""


def longest_usual(steps: np.ndarray) -> float:
    """Return the step of time, s, beyond which one of these `steps`, shape (n,), is a gap."""
    middle, recurring = np.quantile(steps, [0.5, RECURRING])
    return GAP_PERIODS * float(recurring if recurring > GAP_PERIODS * middle else middle)


def gap_rows(time: np.ndarray) -> np.ndarray:
    """Return the indices of the first stamps after gaps."""
    steps = np.diff(time)
    if steps.size < 2:
        return np.array([], dtype=int)
    return np.flatnonzero(steps > longest_usual(steps)) + 1
