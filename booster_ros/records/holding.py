# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a series had last, or runs through, where it has no value."""

import numpy as np

Array = np.ndarray


def last_known(values: Array) -> Array:
    """Return for each row, shape (n,), the last one up to it that has a value, -1 for none."""
    return np.maximum.accumulate(np.where(np.isfinite(values), np.arange(len(values)), -1))


def held(values: Array, since: Array) -> Array:
    """
    Return the values with the last one before in place of each that is missing.

    `since` says of each row from which row on values count for it; shape (n,).
    """
    latest = last_known(values)
    return np.where(latest >= since, values[latest], np.nan)


def bridged(time: Array, values: Array) -> Array:
    """Return the values with a straight line across what is missing; one of them is known."""
    known = np.isfinite(values)
    return np.interp(time, time[known], values[known])
