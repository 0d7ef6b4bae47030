# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where a series of time stamps has gaps."""

import numpy as np

GAP_PERIODS = 5.0
"""A step of time longer than so many median periods is a gap."""


def gap_rows(time: np.ndarray) -> np.ndarray:
    """Return the indices of the first stamps after gaps."""
    steps = np.diff(time)
    if steps.size < 2:
        return np.array([], dtype=int)
    return np.flatnonzero(steps > GAP_PERIODS * np.median(steps)) + 1
