# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Rows in which a sensor was not read: zeros amid a pressure, and numbers that stand for none."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from booster_ros.records.missing import suspected_sentinels
from booster_ros.records.record import Array

PRESSURES = ('back_pressure', 'supply_pressure', 'chamber_pressure')
SENSED = (*PRESSURES, 'valve_position', 'pressure_drop')

_FEWEST_ROWS = 100
_LARGEST_SHARE = 0.05
_MOST_RUNS = 8
_WELL_ABOVE = 0.2
"""Share of the largest value above which every other value lies where zeros are none."""

_ALIKE = 0.5
"""Largest difference of the values before and after, as a share of how far they are from zero."""

_AT_REST = 0.05
"""Share of the range of a position, or of a current, within which a vented valve has both."""


def sentinels(name: str, values: Array) -> Array:
    """Tell of each row, shape (n,), whether it holds a number that loggers write for none."""
    if name not in SENSED or len(values) < 3:
        return np.zeros(len(values), dtype=bool)
    return np.isin(values, suspected_sentinels(values))


def dropouts(name: str, columns: Mapping[str, Array]) -> Array:
    """
    Tell of each row, shape (n,), whether it holds a zero that the pressure cannot have gone to.

    All other values are far from zero, and the values before and after are alike. Where position or
    current are known, they must not be those of a valve that was vented. A supply that fails is no
    dropout unless the chamber shows that it was there.
    """
    values = columns[name]
    zero = values == 0.0
    none = np.zeros(len(values), dtype=bool)
    others = values[np.isfinite(values) & ~zero]
    if (name not in PRESSURES or 'time' not in columns or len(values) < _FEWEST_ROWS
            or not zero.any() or np.mean(zero) > _LARGEST_SHARE or not others.size
            or others.min() < _WELL_ABOVE * others.max()):
        return none
    edges = np.flatnonzero(np.diff(np.concatenate([[False], zero, [False]]).astype(np.int8)))
    runs = list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))
    if len(runs) > _MOST_RUNS:
        return none
    for first, last in runs:
        if _between_alike(values, first, last) and not _explained(name, columns, first, last):
            none[first:last] = True
    return none


def _between_alike(values: Array, first: int, last: int) -> bool:
    before, after = values[:first], values[last:]
    before, after = before[np.isfinite(before)][-1:], after[np.isfinite(after)][:1]
    if not before.size or not after.size:
        return False
    return bool(abs(after[0] - before[0]) < _ALIKE * min(before[0], after[0]))


def _explained(name: str, columns: Mapping[str, Array], first: int, last: int) -> bool:
    """Tell whether the other channels went where they go when the pressure is gone."""
    if name == 'supply_pressure':
        chamber = columns.get('chamber_pressure')
        if chamber is None:
            return True
        fell = np.nanmin(chamber[max(first - 1, 0):last + 1])
        return not bool(fell > 0.5 * np.nanmax(chamber[max(first - 1, 0):first + 1]))
    told = [_is_at_rest(columns[other], first, last)
            for other in ('valve_position', 'control_current') if other in columns]
    return bool(told) and all(told)


def _is_at_rest(values: Array, first: int, last: int) -> bool:
    """Tell whether a channel has its least values throughout some rows."""
    if not np.isfinite(values).any():
        return False
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    within = values[first:last]
    within = within[np.isfinite(within)]
    return bool(within.size) and bool(np.all(within <= low + _AT_REST * (high - low)))
