# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What is said of the columns of a record that stay as they are."""

from collections.abc import Mapping

import numpy as np

from booster_ros.records.record import COLUMNS, MEASURED, Array, Defect

_LARGEST_GRID = 2**16
_AT_REST = {'chamber_pressure': 5e3, 'control_current': 1e-6}

_BELOW_ATMOSPHERE = -5e3
"""Pa gauge: noise and drift of a vented chamber are above, what a vacuum makes is below."""


def resolution(column: str, values: Array) -> list[Defect]:
    """Find the resolution of a quantised signal."""
    if column not in MEASURED:
        return []
    levels = np.unique(values[np.isfinite(values)])
    if levels.size < 3 or levels.size > _LARGEST_GRID:
        return []
    step = np.diff(levels).min()
    span = levels[-1] - levels[0]
    multiples = (levels - levels[0]) / step
    if span / step > _LARGEST_GRID or np.abs(multiples - np.rint(multiples)).max() > 0.02:
        return []
    text = f'quantised in steps of {step:.3g} {COLUMNS[column].unit}, used as it is'
    return [Defect('quantised', column, 0, 0, int(np.isfinite(values).sum()), text)]


def start(columns: Mapping[str, Array], rows: Array) -> list[Defect]:
    """Say that a record does not start at rest: its first rows are the initial state."""
    if 'time' not in columns:
        return []
    for name, rest in _AT_REST.items():
        known = np.flatnonzero(np.isfinite(columns.get(name, np.array([]))))
        if known.size and columns[name][known[0]] > rest:
            row, value = int(rows[known[0]]), columns[name][known[0]]
            at = f'{value:.6g} {COLUMNS[name].unit}'
            text = f'starts in operation, at {at}; taken as the initial state'
            return [Defect('starts_in_operation', name, row, row, 1, text)]
    return []


def below_atmosphere(column: str, values: Array) -> list[Defect]:
    """Say that a pressure is below the atmosphere, which no positioner of the model makes."""
    known = values[np.isfinite(values)]
    if COLUMNS[column].unit != 'Pa' or column == 'pressure_drop' or not known.size:
        return []
    low = float(np.quantile(known, 0.01))
    if low > _BELOW_ATMOSPHERE:
        return []
    return [Defect('vacuum', column, 0, 0, int(np.count_nonzero(known < _BELOW_ATMOSPHERE)),
                   f'is below the atmosphere, down to {low:.4g} Pa: vacuum is outside the model')]
