# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How strong a signal is at each frequency."""

import numpy as np

Array = np.ndarray


def periodogram(values: Array, interval: float, padding: int) -> tuple[Array, Array]:
    """
    Return frequencies, Hz, and the power of evenly sampled `values`, shape (n,), at each.

    A straight line is taken off, and a Hann window weighs the rest. Zeros behind it, `padding`
    times its length with it, give frequencies in between. Power is up to a constant. `interval` is
    the time from row to row, s. Source: P. D. Welch, IEEE Transactions on Audio and
    Electroacoustics 15 (1967) 70, of one segment.
    """
    rows = np.arange(len(values))
    left = values - np.polyval(np.polyfit(rows, values, 1), rows)
    # numpy's window ends as it begins; of one that is repeated that row is the next one's first
    spectrum = np.fft.rfft(np.hanning(len(values) + 1)[:-1] * left, padding * len(values))
    return np.fft.rfftfreq(padding * len(values), interval), np.abs(spectrum)**2
