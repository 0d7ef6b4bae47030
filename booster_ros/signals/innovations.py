# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What comes unforeseen in noise of which a share carries over from row to row."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_banded

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class Whitening:
    """
    The Kalman filter of noise with the covariance (1 - share) I + share exp(-|t - t'|/seconds).

    It hangs on the times of rows alone: of each row, what `carried` over to it, the `gain`, and the
    standard `deviation` of what comes unforeseen, each of shape (rows,), and the `bands` of the
    recursion, of shape (2, rows). (B. D. O. Anderson and J. B. Moore, Optimal Filtering, 1979.)
    """

    carried: Array
    gain: Array
    deviation: Array
    bands: Array

    @classmethod
    def of(cls, time: Array, share: float, seconds: float) -> 'Whitening':
        """Return the filter of rows at these times, s."""
        carried = np.exp(-np.diff(time, prepend=time[:1]) / seconds)
        gain, variance = np.empty((2, len(carried)))
        unsure = share
        for k, part in enumerate(carried):
            unsure = part**2 * unsure + (1.0 - part**2) * share
            variance[k] = unsure + 1.0 - share
            gain[k] = unsure / variance[k]
            unsure *= 1.0 - gain[k]
        bands = np.array([np.ones(len(gain)), np.append(-((1.0 - gain) * carried)[1:], 0.0)])
        return cls(carried, gain, np.sqrt(variance), bands)

    def innovations(self, noise: Array) -> Array:
        """Return noise as white noise of variance 1: what comes unforeseen, in its deviations."""
        # what is expected after each row, m_k = (1 - gain) carried m_(k-1) + gain r_k, all at once
        expected = solve_banded((1, 0), self.bands, self.gain * noise)
        foreseen = self.carried * np.append(0.0, expected[:-1])
        return np.asarray((noise - foreseen) / self.deviation)
