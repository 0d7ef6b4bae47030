# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What of long series is drawn: peaks and gaps stay."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from booster_ros.records.time_axis import gap_rows

Array = np.ndarray

MOST = 3000
"""Points of a line in a figure that stands still: more than a screen resolves."""


def envelope(x: Array, y: Array, most: int = MOST) -> tuple[Array, Array]:
    """
    Return a line of n > `most` points thinned to the lowest and highest of `most` / 4 pieces.

    So it looks the same. Longer ones only: a line that is thinned by less than two gains nothing.
    """
    size = len(y)
    if size <= most:
        return x, y
    edges = np.linspace(0, size, most // 4 + 1).astype(int)
    first = edges[:-1, None]
    at = first + np.arange(np.max(np.diff(edges)))
    part = y[np.minimum(at, size - 1)]
    within = (at < edges[1:, None]) & np.isfinite(part)
    ends = [np.argmin(np.where(within, part, np.inf), axis=1),
            np.argmax(np.where(within, part, -np.inf), axis=1)]
    rows = np.unique(first + np.transpose(ends))
    return x[rows], y[rows]


def over_time(time: Array, y: Array, most: int = MOST) -> tuple[Array, Array]:
    """Return a line over time thinned like `envelope`, and broken where the record has a gap."""
    x, y = envelope(time, y, most)
    resumed = time[gap_rows(time)]
    places = np.searchsorted(x, resumed)
    return np.insert(x, places, resumed), np.insert(y, places, np.nan)


def thin(*series: Array, most: int = 1600) -> list[Array]:
    """Return every n-th element of equally long series, so that at most `most` are left."""
    step = max(1, -(-len(series[0]) // most))
    return [values[::step] for values in series]


def branches(others: Sequence[Array], size: int) -> list[slice]:
    """Return the slices of a sweep during which nothing but its driver moves, of all drives."""
    jumps = np.zeros(max(size - 1, 0), dtype=bool)
    for values in others:
        jumps |= np.abs(np.diff(values)) > 0.02 * np.ptp(values)
    edges = [0, *(np.flatnonzero(jumps) + 1).tolist(), size]
    return [slice(first, last) for first, last in pairwise(edges)]
