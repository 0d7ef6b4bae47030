# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Values for the rows of a series that have none: the last one before, or a straight line."""

import numpy as np

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
