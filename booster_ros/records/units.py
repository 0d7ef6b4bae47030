# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Refuse values that cannot be in the unit of their column, such as mA for A or mm for m."""

import numpy as np

from booster_ros.records.record import COLUMNS, Array, RecordError

LARGEST_KILOPASCALS = 2000.0
"""A pressure signal that stays below this number is in kPa, bar, MPa or psi, not in Pa."""

VACUUM = -105e3
"""No gauge pressure is below this: the atmosphere is at most 1.05 bar at the sea."""

_NOISE_SHARE = 0.05
_PRACTICALLY_ZERO = 0.01
_LIKE_SIZE = 5.0


def check_finite(column: str, values: Array, rows: Array, source: str) -> None:
    """Raise RecordError where a value is infinite."""
    infinite = np.flatnonzero(np.isinf(values))
    if infinite.size:
        row = rows[infinite[0]]
        raise RecordError(f'{source}, row {row}, column {column}: the value is infinite')


def check_units(column: str, values: Array, rows: Array, source: str) -> None:
    """Raise RecordError when the values of a column are too large to be in its unit."""
    largest = COLUMNS[column].largest
    too_large = np.flatnonzero(np.abs(values) > largest)
    if too_large.size:
        first = too_large[0]
        raise RecordError(
            f'{source}, row {rows[first]}, column {column}: {values[first]:g} is not plausible in '
            f'{COLUMNS[column].unit} (at most {largest:g}); it looks like '
            f'{COLUMNS[column].mistaken_for}: convert the column to {COLUMNS[column].unit}'
        )


def check_pressure_scale(column: str, values: Array, rows: Array, source: str) -> None:
    """
    Raise RecordError when a whole pressure column is too small to be in pascals.

    A vented chamber is exempt: it reads zero, or noise around zero with values of both signs and of
    like size.
    """
    if COLUMNS[column].unit != 'Pa':
        return
    known = values[np.isfinite(values)]
    if not known.size or np.abs(known).max() >= LARGEST_KILOPASCALS:
        return
    around_zero = known.max() < _LIKE_SIZE * -known.min() and np.mean(known < 0.0) > _NOISE_SHARE
    is_vented = np.abs(known).max() < _PRACTICALLY_ZERO or around_zero
    if is_vented:
        return
    highest = int(np.nanargmax(np.abs(values)))
    raise RecordError(
        f'{source}, row {rows[highest]}, column {column}: the largest value is '
        f'{values[highest]:g}, which looks like kPa, bar, MPa or psi: '
        'convert the column to Pa, gauge'
    )


def check_above_vacuum(column: str, values: Array, rows: Array, source: str) -> None:
    """Raise RecordError where a pressure is below vacuum."""
    below = np.flatnonzero(values < VACUUM)
    if COLUMNS[column].unit == 'Pa' and below.size:
        raise RecordError(
            f'{source}, row {rows[below[0]]}, column {column}: {values[below[0]]:g} Pa gauge is '
            'below vacuum'
        )
