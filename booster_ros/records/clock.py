# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Refuse times that a clock does not show unless it was set during the recording."""

import numpy as np

from booster_ros.records.record import Array, RecordError

CLOCK_SET = 1e6
"""Longest step of time, s: beyond it a clock was set, and no valve is simulated across that."""


def check_clock(time: Array, rows: Array, source: str) -> None:
    """Raise RecordError where time, s, runs backwards, or days pass from one row to the next."""
    steps = np.diff(time)
    backwards = np.flatnonzero(steps < 0.0)
    if backwards.size:
        first = backwards[0] + 1
        raise RecordError(
            f'{source}, row {rows[first]}, column time: runs backwards, from '
            f'{time[first - 1]:.9g} to {time[first]:.9g} s')
    far = np.flatnonzero(steps > CLOCK_SET)
    if far.size:
        first = far[0] + 1
        raise RecordError(
            f'{source}, row {rows[first]}, column time: {steps[far[0]]:.4g} s after the row '
            'before, as where a clock was set; leave out the rows before or behind it')
