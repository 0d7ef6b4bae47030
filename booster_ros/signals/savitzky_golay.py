# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
A smooth signal and its rate of change, by a parabola through the rows around each.

A. Savitzky and M. J. E. Golay, Analytical Chemistry 36 (1964) 1627. What `scipy.signal` has of it
takes a second to import, as statistics come along.
"""

import numpy as np

Array = np.ndarray


def smoothed(values: Array, rows: int, interval: float) -> tuple[Array, Array]:
    """
    Return smooth values and their rate of change, both of shape (n,), of evenly sampled `values`.

    Each is that of the parabola that fits `rows` rows (an odd number, n at the most) best; within
    half of them of an end, of the parabola through the first or the last `rows`. `interval` is the
    time from row to row, s.
    """
    half = rows // 2
    within = np.arange(-half, half + 1.0)
    fits = np.linalg.pinv(np.vander(within, 3, increasing=True))
    around = np.lib.stride_tricks.sliding_window_view(values, rows) @ fits.T
    value, rate = (np.empty(len(values)) for _ in range(2))
    value[half:-half], rate[half:-half] = around[:, 0], around[:, 1]
    for place, (c, b, a), at in ((slice(0, half), around[0], within[:half]),
                                 (slice(-half, None), around[-1], within[-half:])):
        value[place], rate[place] = c + at * (b + at * a), b + 2.0 * a * at
    return value, rate / interval
