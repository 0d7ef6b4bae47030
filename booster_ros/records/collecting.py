# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Collect the mapped columns of a table, portion by portion, as the numbers that stand there."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from booster_ros.records.conversion import quantity
from booster_ros.records.guarded import check_count
from booster_ros.records.mapping import FileMapping, Quality, TimeMapping
from booster_ros.records.missing import is_good, noted, numbers
from booster_ros.records.record import Array, Defect, RecordError
from booster_ros.records.table import Portion, Table
from booster_ros.records.time_column import TimeColumn
from booster_ros.records.time_name import unit_in_time_name
from booster_ros.records.unit_in_name import normalised


@dataclass
class Collected:
    """
    The columns of a table as numbers of the file, before units: rows, times, values.

    `zone` is that of a clock whose changes are still in the times.
    """

    rows: Array
    time: Array | None
    zone: str | None
    values: dict[str, Array]
    defects: list[Defect]


def collect(table: Table, mapping: FileMapping) -> Collected:
    """Return the mapped columns of a table as they stand there."""
    places = {name: table.place(one.source, f'{mapping.source}, columns.{name}')
              for name, one in mapping.columns.items()}
    quality = [(one, table.place(one.column, f'{mapping.source}, quality'))
               for one in mapping.quality]
    clock = Clock(table, mapping)
    wanted = {*places.values(), *clock.places, *(place for _, place in quality)}
    texts = {*clock.texts, *(place for _, place in quality)}
    rows: list[Array] = []
    parts: dict[str, list[Array]] = {name: [] for name in places}
    marked: dict[str, list[Array]] = {name: [] for name in places}
    bad: dict[str, list[Array]] = {name: [] for name in places}
    count = 0
    for portion in table.portions(texts, wanted):
        count += len(portion.rows) * (len(places) + 1)
        check_count(count, table.source)
        rows.append(portion.rows)
        clock.add(portion)
        for name, place in places.items():
            values, coded = numbers(portion.frame[place], mapping.missing, portion.rows,
                                    f'{table.source}, column {table.names[place]!r}')
            marked[name].append(coded)
            bad[name].append(_bad(portion, quality, name))
            parts[name].append(values)
    if not rows:
        raise RecordError(f'{table.source} has no rows of data')
    every = np.concatenate(rows)
    defects: list[Defect] = []
    columns: dict[str, Array] = {}
    for name in places:
        columns[name] = np.concatenate(parts[name])
        wrong = np.concatenate(bad[name]) & np.isfinite(columns[name])
        columns[name][wrong] = np.nan
        defects += noted('missing_mark', name, np.concatenate(marked[name]), every,
                         'that mean none, as the mapping says: missing')
        defects += noted('bad_quality', name, wrong, every, 'of bad quality, not used')
    time, told = clock.seconds()
    return Collected(every, time, clock.zone, columns, [*defects, *told])


def _bad(portion: Portion, quality: list[tuple[Quality, int]], name: str) -> Array:
    bad = np.zeros(len(portion.rows), dtype=bool)
    for one, place in quality:
        if not one.of or name in one.of:
            bad |= ~is_good(portion.frame[place], one.good)
    return bad


class Clock:
    """Reads the time of a table: its columns, or a time from row to row."""

    def __init__(self, table: Table, mapping: FileMapping):
        given = mapping.time
        self._where = f'{mapping.source}, time'
        self._every: float | None = None
        self._column: TimeColumn | None = None
        self._count = 0
        self.places: list[int] = []
        self.texts: set[int] = set()
        self.zone: str | None = None
        if given is None or given.stamps is not None:
            return
        if given.every is not None:
            self._every = quantity(given.every, 's', f'{self._where}.every')
            return
        self.places = [table.place(name, f'{self._where}.columns') for name in given.columns]
        given, numeric = self._told(table, given)
        self.texts = set() if numeric else set(self.places)
        # times as text are put right by the calendar of their zone
        self.zone = given.zone if numeric or given.zone is None else 'UTC'
        self._column = TimeColumn(given, numeric, self._where)

    def _told(self, table: Table, given: TimeMapping) -> tuple[TimeMapping, bool]:
        """Return the mapping with the unit that the file says, and whether times are numbers."""
        if given.unit is not None or given.format is not None or len(self.places) > 1:
            return given, given.unit is not None
        place = self.places[0]
        first = next(iter(table.portions((), self.places)), None)
        if first is None or not _are_numbers(first.frame[place]):
            return given, False
        unit = time_unit(table.names[place], table.units[place])
        return replace(given, unit=unit), True

    def add(self, portion: Portion) -> None:
        """Take the times of a portion."""
        self._count += len(portion.rows)
        if self._column is None:
            return
        values = portion.frame[self.places[0]]
        if len(self.places) > 1:
            values = _as_text(values)
        for place in self.places[1:]:
            values = values + ' ' + _as_text(portion.frame[place])
        self._column.add(values, portion.rows)

    def seconds(self) -> tuple[Array | None, list[Defect]]:
        """Return the times, s, None without, and what was done."""
        if self._every is not None:
            return self._every * np.arange(self._count), []
        return self._column.seconds() if self._column else (None, [])


def _are_numbers(values: Any) -> bool:
    """Tell whether a column holds numbers, be they written as text."""
    import pandas as pd

    if values.dtype.kind not in 'OU' and values.dtype != 'str':
        return values.dtype.kind in 'iuf'
    known = values.dropna()
    return bool(len(known)) and bool(pd.to_numeric(known, errors='coerce').notna().all())


def _as_text(values: Any) -> Any:
    """Return a column of text as it is, one of dates as text."""
    return values.dt.strftime('%Y-%m-%d') if values.dtype.kind == 'M' else values.astype('str')


def time_unit(name: str, unit_row: str) -> str | None:
    """Return the unit of a time that its name or the row below says; seconds where it is `time`."""
    return unit_in_time_name(name, unit_row) or ('s' if normalised(name) == 'time' else None)
