# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Values for the rows of a series that have none: the last one before, or a straight line."""

import numpy as np

from .time_axis import longest_usual

Array = np.ndarray


def last_known(values: Array) -> Array:
    """Return for each row, shape (n,), the index of the last row up to it with a value, or -1."""
    return np.maximum.accumulate(np.where(np.isfinite(values), np.arange(len(values)), -1))


def held(values: Array, since: Array) -> Array:
    """
    Return the values, each missing one replaced by the last one before it.

    `since`, shape (n,), says for each row from which row on values count for it.
    """
    latest = last_known(values)
    return np.where(latest >= since, values[latest], np.nan)


def bridged(time: Array, values: Array) -> Array:
    """Return the values with a straight line across missing ones; at least one must be known."""
    known = np.isfinite(values)
    return np.interp(time, time[known], values[known])


def between_samples(time: Array | None, values: Array) -> Array:
    """Return values sampled more slowly than the rows, filled except in gaps of their own."""
    if time is None:
        return values
    known = time[np.isfinite(values)]
    if len(known) < 3:
        return values
    after = np.searchsorted(known, time).clip(1, len(known) - 1)
    near = known[after] - known[after - 1] <= longest_usual(np.diff(known))
    near &= (time >= known[0]) & (time <= known[-1])
    return np.where(near | np.isfinite(values), bridged(time, values), np.nan)
