# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Read a file of others as a mapping says: into one record for each run that is in it."""

from __future__ import annotations

from collections.abc import Mapping
import os

import numpy as np

from booster_ros.records.cleaning import clean
from booster_ros.records.collecting import Collected, collect
from booster_ros.records.conversion import quantity
from booster_ros.records.holding import last_known
from booster_ros.records.long_table import pivoted
from booster_ros.records.mapping import ASKED, FileMapping
from booster_ros.records.open_table import open_table
from booster_ros.records.reading import Reading, reading
from booster_ros.records.record import COLUMNS, Array, Beside, Defect, Record, RecordError
from booster_ros.records.table import Table
from booster_ros.records.time_order import in_order
from booster_ros.records.units import check_finite, check_units


class Runs:
    """The runs in a file, each a record that is cleaned when it is asked for."""

    def __init__(self, path: str | os.PathLike[str], mapping: FileMapping, travel: float | None):
        self._source = os.fspath(path)
        self._mapping = mapping
        table = open_table(path, mapping.layout)
        if mapping.travel is not None:
            travel = quantity(mapping.travel, 'm', f'{mapping.source}, travel')
        if mapping.long:
            self._collected, self._readings = pivoted(table, mapping, travel)
        else:
            self._readings = readings_of(table, mapping, travel)
            self._collected = collect(table, mapping)
        self._values, defects, self._stated = _in_si(
            self._collected, self._readings, mapping, self._source)
        self._defects = [*self._collected.defects, *defects]
        self._time = self._collected.time
        if self._time is None:
            self.runs = [np.arange(len(self._collected.rows))]
            return
        ordered = in_order(self._time, self._collected.rows, self._collected.zone,
                           f'{mapping.source}, time')
        self._time = ordered.time
        self._defects += ordered.defects
        self.runs = [run for run in ordered.runs if run.size]
        if not self.runs:
            raise RecordError(f'{self._source}: no row has a time')

    def __len__(self) -> int:
        """Return the number of runs."""
        return len(self.runs)

    def record(self, number: int) -> Record:
        """Return the record of a run; the first is 1."""
        defects = [*self._defects, *_run_note(number, self.runs, self._collected.rows)]
        return _record(self.runs[number - 1], self._time, self._values, self._collected,
                       self._readings, self._mapping, defects, self._stated, self._source)

    def listed(self) -> str:
        """Return what the runs are, for a sentence."""
        rows = self._collected.rows
        text = '; '.join(f'{number}: {len(run)} rows from row {rows[run].min()} on'
                         for number, run in enumerate(self.runs[:8], 1))
        return text + ' …' * (len(self.runs) > 8)


def read_runs(
    path: str | os.PathLike[str], mapping: FileMapping, travel: float | None = None
) -> list[Record]:
    """
    Return a record for each run in a file, mapped.

    `travel` is that of the stem, m, for what is in per cent of it; the mapping's own goes before.
    RecordError asks by name for what the mapping leaves open.
    """
    runs = Runs(path, mapping, travel)
    return [runs.record(number) for number in range(1, len(runs) + 1)]


def read_mapped(
    path: str | os.PathLike[str], mapping: FileMapping, travel: float | None = None
) -> Record:
    """Return the record in a file, mapped: its only run, or the one that the mapping names."""
    runs = Runs(path, mapping, travel)
    if mapping.run is None or mapping.run == ASKED:
        if len(runs) == 1:
            return runs.record(1)
        raise RecordError(f'{mapping.source}, run: {os.fspath(path)} has {len(runs)} runs, each a '
                          f'record of its own ({runs.listed()}); say which, as in run: 1')
    if not 1 <= int(mapping.run) <= len(runs):
        raise RecordError(f'{mapping.source}, run: there is no run {mapping.run}, '
                          f'{os.fspath(path)} has {len(runs)}')
    return runs.record(int(mapping.run))


def readings_of(table: Table, mapping: FileMapping, travel: float | None) -> dict[str, Reading]:
    """Return how each column is read; RecordError for the first that something is missing of."""
    found = {}
    for name, one in mapping.columns.items():
        where = f'{mapping.source}, columns.{name}'
        place = table.place(one.source, where)
        found[name] = reading(name, one, table.names[place], table.units[place], travel, where)
    return found


def _in_si(
    collected: Collected, readings: Mapping[str, Reading], mapping: FileMapping, source: str
) -> tuple[dict[str, Array], list[Defect], set[str]]:
    """Return the values in SI units, the notes on them, and the columns whose unit was stated."""
    values, defects = {}, []
    stated = set()
    for name, how in readings.items():
        found, notes = how.of(collected.values[name])
        defects += notes
        values[name] = found
        if mapping.columns[name].unit is not None:
            stated.add(name)
        if _is_column(name, how):
            check_finite(name, found, collected.rows, source)
            check_units(name, found, collected.rows, source)
    return values, defects, stated


def _record(
    run: Array, time: Array | None, values: Mapping[str, Array], collected: Collected,
    readings: Mapping[str, Reading], mapping: FileMapping, defects: list[Defect],
    stated: set[str], source: str,
) -> Record:
    """Return the cleaned record of one run."""
    rows = collected.rows[run].copy()
    held: dict[str, float] = {}
    columns: dict[str, Array] = {}
    beside: dict[str, Array] = {}
    for name, all_values in values.items():
        own = all_values[run].copy()
        if name in mapping.held:
            held[name] = least_change(own)
            own = _held(own)
            unit = readings[name].conversion.target
            defects = [*defects, _held_note(name, held[name], unit, len(own))]
        (columns if _is_column(name, readings[name]) else beside)[name] = own
    if time is not None:
        columns = {'time': time[run] + 0.0, **columns}
    if not set(columns) - {'time'}:
        lone = {'time': columns.pop('time')} if 'time' in columns else {}
        units = {name: readings[name].conversion.target for name in beside}
        return Record(lone, source, tuple(defects), rows,
                      {name: Beside(one, units[name]) for name, one in beside.items()}, held)
    record = clean(columns, rows, source, tuple(defects), stated)
    place = {int(row): index for index, row in enumerate(collected.rows[run])}
    kept = np.array([place[int(row)] for row in record.rows], dtype=int)
    return Record(record.columns, source, record.defects, record.rows,
                  {name: Beside(one[kept], readings[name].conversion.target)
                   for name, one in beside.items()}, held)


def _is_column(name: str, how: Reading) -> bool:
    """Tell whether values are a column of a record; a set point of a pressure is none."""
    return name in COLUMNS and how.conversion.target == COLUMNS[name].unit


def least_change(values: Array) -> float:
    """Return the least change from one stored value to the next: about the limit of storing."""
    known = values[np.isfinite(values)]
    steps = np.abs(np.diff(known))
    steps = steps[steps > 0.0]
    return float(steps.min()) if steps.size else 0.0


def _held(values: Array) -> Array:
    latest = last_known(values)
    return np.where(latest >= 0, values[latest], np.nan)


def _held_note(name: str, limit: float, unit: str, count: int) -> Defect:
    lost = (f'changes below {limit:.3g} {unit} are not there, and noise below that is gone'
            if limit else 'it never changed by as much as is stored')
    return Defect('held', name, 0, 0, count,
                  f'stored by exception: between two rows the value held; {lost}')


def _run_note(number: int, runs: list[Array], rows: Array) -> list[Defect]:
    if len(runs) == 1:
        return []
    run = runs[number - 1]
    return [Defect('run', 'time', int(rows[run].min()), int(rows[run].max()), len(run),
                   f'run {number} of {len(runs)} in this file: time begins again')]
