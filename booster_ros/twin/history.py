# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The last minutes of what came of the valve, in bounded memory, and the record made of them."""

from collections import deque
from collections.abc import Mapping
import math
from pathlib import Path

import numpy as np

from ..records.csv_file import CsvWriter
from .aligning import CHANNELS, DRIVES, LONGEST_GAP, READINGS

Array = np.ndarray

GAPS_OF_A_SILENCE = 2.0
"""Longest gaps without any row after which a record begins anew: what drives the valve is not known
there, and nothing can be compared until its chamber has forgotten it."""

MOST_ROWS = 200_000
"""Rows that are kept at the most, whatever comes how often."""

FEWEST_ROWS = 100
"""Rows below which there is nothing to diagnose."""


class History:
    """Keeps the rows of the last `span` s; after a silence or a jump of the clock begins anew."""

    def __init__(self, span: float) -> None:
        self.span = span
        self.gap = LONGEST_GAP
        """Longest time, s, between readings of a channel across which it is filled."""
        self._pieces: deque[dict[str, Array]] = deque()
        self._rows = 0

    @property
    def begin(self) -> float:
        """Time, s, of the first row that is kept; NaN for none."""
        return float(self._pieces[0]['time'][0]) if self._pieces else math.nan

    @property
    def end(self) -> float:
        """Time, s, of the last row; NaN for none."""
        return float(self._pieces[-1]['time'][-1]) if self._pieces else math.nan

    def clear(self) -> None:
        """Forget all: what comes next does not go on from it."""
        self._pieces.clear()
        self._rows = 0

    def add(self, rows: Mapping[str, Array]) -> None:
        """Take rows as `Aligner.rows` gives them, later than those before."""
        time = rows['time']
        if not len(time):
            return
        silence = GAPS_OF_A_SILENCE * self.gap
        if self._pieces and not 0.0 < time[0] - self.end <= silence:
            self.clear()
        silences = np.flatnonzero(np.diff(time) > silence)
        if len(silences):
            self.clear()
            rows = {name: values[silences[-1] + 1:] for name, values in rows.items()}
        self._pieces.append(dict(rows))
        self._rows += len(rows['time'])
        while len(self._pieces) > 1 and (
                self.end - self._pieces[0]['time'][-1] > self.span or self._rows > MOST_ROWS):
            self._rows -= len(self._pieces.popleft()['time'])

    def record(self, since: float = -math.inf) -> dict[str, Array]:
        """
        Return the columns of a record of the last `span` s, or from `since` s on if that is later.

        Rows are those of the reading that came most often, shape (n,). Other readings are
        interpolated between neighbours no more than `gap` apart, and NaN beyond; of a
        drive, the last sample stands. Channels that never came are left out, and rows before the
        first sample of a drive. No column at all where there are no rows.
        """
        if not self._pieces:
            return {}
        rows = {name: np.concatenate([piece[name] for piece in self._pieces])
                for name in ('time', *CHANNELS)}
        late = rows['time'] >= max(since, self.end - self.span)
        rows = {name: values[late] for name, values in rows.items()}
        came = {name: int(np.count_nonzero(np.isfinite(rows[name]))) for name in CHANNELS}
        most = max(READINGS, key=lambda name: came[name])
        used = np.isfinite(rows[most])
        for name in DRIVES:
            if came[name]:
                used &= np.isfinite(rows[name])
        if not used.any():
            return {}
        time = rows['time']
        columns = {'time': time[used]}
        for name in CHANNELS:
            if came[name]:
                columns[name] = rows[name][used] if name in DRIVES else _between(
                    time, rows[name], time[used], self.gap)
        return columns


def _between(time: Array, values: Array, wanted: Array, longest: float) -> Array:
    """Return a reading at the wanted times, NaN where none is near before or after."""
    known = np.isfinite(values)
    at = time[known]
    after = np.searchsorted(at, wanted)
    before = np.maximum(np.searchsorted(at, wanted, 'right') - 1, 0)
    inside = (wanted >= at[0]) & (wanted <= at[-1])
    gap = at[np.minimum(after, len(at) - 1)] - at[before]
    return np.where(inside & (gap <= longest), np.interp(wanted, at, values[known]), math.nan)


def write_record(path: Path, columns: Mapping[str, Array]) -> None:
    """Write columns as a record that `close_loop` reads, whole or not at all; RecordError."""
    writer = CsvWriter(path, list(columns))
    try:
        writer.write_rows(np.column_stack(list(columns.values())))
    except BaseException:
        writer.discard()
        raise
    writer.close()
