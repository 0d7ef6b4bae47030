# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What stands in a column of others for no value: words, numbers that mean none, bad quality."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from booster_ros.records.record import Array, Defect, RecordError

NO_VALUE = frozenset({'', 'nan', 'na', 'n/a', '<na>', 'null', 'none', '-', '--', '#n/a', 'nil'})
"""Words, in small letters, that say that there is no value, in whatever column."""

SENTINELS = (-9999.0, -999.0, -99.0, -999.25, -9999.25, -99999.0, 9999.0, 99999.0, 999999.0,
             -32768.0, 32767.0, 65535.0, -2147483648.0, 2147483647.0, 1e30, -1e30, 9.96921e36)
"""Numbers that loggers write where they have none."""

_ZERO = 0.02
"""Share of the range of a signal within which it is zero."""


def numbers(values: Any, missing: Sequence[object], rows: Array, where: str
            ) -> tuple[Array, Array]:
    """
    Return a column as numbers, NaN where there is none, and which rows had a `missing` value.

    RecordError names row and text of a cell that is no number and is not listed.
    """
    import pandas as pd

    if values.dtype.kind in 'iufb':
        found = np.array(values, dtype=float)
        words = np.zeros(len(found), dtype=bool)
    else:
        text = values.astype('str').str.strip()
        small = text.str.lower()
        listed = {str(one).strip().lower() for one in missing}
        words = np.asarray(small.isin(listed) & values.notna(), dtype=bool)
        blank = np.asarray(small.isin(NO_VALUE) | values.isna(), dtype=bool) | words
        parsed = pd.to_numeric(text.where(~blank), errors='coerce')
        odd = np.flatnonzero(np.asarray(parsed.isna(), dtype=bool) & ~blank)
        if odd.size:
            cell = str(text.iloc[int(odd[0])])[:40]
            raise RecordError(
                f'{where}, row {rows[odd[0]]}: {cell!r} is not a number; where it stands for no '
                f'value, list it: missing: [{cell!r}]')
        found = np.array(parsed, dtype=float)
    coded = [float(one) for one in missing
             if isinstance(one, (int, float)) and not isinstance(one, bool)]
    marked = np.isin(found, coded) | words
    found[marked] = np.nan
    return found, marked


def is_good(values: Any, good: Sequence[object]) -> Array:
    """Tell of each row, shape (n,), whether its quality is among the good ones."""
    text = values.astype('str').str.strip().str.lower()
    text = text.str.replace(r'\.0+$', '', regex=True)
    return np.asarray(text.isin({_small(one) for one in good}) & values.notna(), dtype=bool)


def _small(value: object) -> str:
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    return str(value).strip().lower()


def noted(kind: str, column: str, flagged: Array, rows: Array, text: str) -> list[Defect]:
    """Return the note on rows of a column that were flagged, none where none was."""
    at = np.flatnonzero(flagged)
    if not at.size:
        return []
    numbers_of_rows = rows[at]
    return [Defect(kind, column, int(numbers_of_rows.min()), int(numbers_of_rows.max()),
                   int(at.size), f'{at.size} value{"s" if at.size > 1 else ""} {text}')]


def suspected_sentinels(values: Array) -> list[float]:
    """
    Return the numbers in a column that most likely stand for no value.

    They are among `SENTINELS` and outside the range of all other values: by more than its width, or
    below it where no other value is below zero.
    """
    known = values[np.isfinite(values)]
    coded = np.isin(known, SENTINELS)
    others = known[~coded]
    if not coded.any() or others.size < 2:
        return []
    low, high = float(others.min()), float(others.max())
    span = max(high - low, 1e-12 * max(abs(low), abs(high)))
    least = low - (0.0 if low >= -_ZERO * span else span)
    return [one for one in np.unique(known[coded]).tolist()
            if (one < least and one < 0.0) or one > high + span]
