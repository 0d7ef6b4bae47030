# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The rows that `simulate` is driven with: read from a CSV in portions, or from a mapped file."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Protocol

import numpy as np

from ..records import (
    FileMapping, Record, RecordError, csv_columns, csv_header_notes, first_row, iterate_csv,
    read_record)
from ..records.holding import last_known
from .mapping_options import pointing_to_inspect

INPUT = ('time', 'control_current')
INITIAL = ('chamber_pressure', 'valve_position')
_PORTION = 100_000


class InputRows(Protocol):
    """Times (s), currents (A), the first row, and what is to be said of the file."""

    source: Path
    notes: tuple[str, ...]

    def first(self) -> tuple[float, float, dict[str, float]]:
        """Return time, current and state to start from."""

    def portions(self) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Yield time and current; a missing current is the one before."""

    def count(self) -> int:
        """Return about how many rows there are."""


def input_rows(source: Path, mapping: FileMapping | None, travel: float) -> InputRows:
    """
    Return the rows of a file, mapped where a mapping is given.

    `travel`, m, is what per cent of travel are of. RecordError where a column is missing.
    """
    if mapping is None:
        return CsvRows(source)
    with pointing_to_inspect(source):
        return RecordRows(source, read_record(source, mapping=mapping, travel=travel))


class CsvRows:
    """The rows of a CSV, read in portions: memory stays flat however long it is."""

    def __init__(self, source: Path):
        self.source = source
        with pointing_to_inspect(source):
            known = csv_columns(source)
            for name in INPUT:
                if name not in known:
                    raise RecordError(f'{source}, row 1: there is no column {name}')
            self.notes = csv_header_notes(source)
        self._given = tuple(name for name in INITIAL if name in known)

    def first(self) -> tuple[float, float, dict[str, float]]:
        """Return time, current and state to start from; RecordError where a value is missing."""
        names = INPUT + self._given
        with pointing_to_inspect(self.source):
            first = first_row(self.source, names)
            values = dict(zip(names, first.values[0].tolist(), strict=True))
            _check_first(values, f'{self.source}, row {first.rows[0]}')
        return values['time'], values['control_current'], {
            name: values[name] for name in self._given}

    def portions(self) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Yield time and current; an empty cell keeps the current before."""
        standing = np.nan
        with pointing_to_inspect(self.source):
            for chunk in iterate_csv(self.source, INPUT):
                current = _held(chunk.values[:, 1], standing)
                standing = float(current[-1])
                yield chunk.values[:, 0], current

    def count(self) -> int:
        """Return the number of lines below the header."""
        lines = 0
        with open(self.source, 'rb', buffering=0) as file:
            while block := file.read(1 << 20):
                lines += block.count(b'\n')
        return lines - 1


class RecordRows:
    """The rows of a record that is in memory, as a mapped file is."""

    def __init__(self, source: Path, record: Record):
        self.source = source
        self.notes = record.notes
        for name in INPUT:
            if name not in record.columns:
                raise RecordError(f'{source}: as it is mapped it has no {name}')
        self._record = record
        self._given = tuple(name for name in INITIAL if name in record.columns)

    def first(self) -> tuple[float, float, dict[str, float]]:
        """Return time, current and state to start from; RecordError where a value is missing."""
        values = {name: float(self._record[name][0]) for name in INPUT + self._given}
        with pointing_to_inspect(self.source):
            _check_first(values, f'{self.source}, row {self._record.rows[0]}')
        return values['time'], values['control_current'], {
            name: values[name] for name in self._given}

    def portions(self) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Yield time and current."""
        current = _held(self._record['control_current'], np.nan)
        for begin in range(0, len(self._record), _PORTION):
            part = slice(begin, begin + _PORTION)
            yield self._record['time'][part], current[part]

    def count(self) -> int:
        """Return the number of rows."""
        return len(self._record)


def _check_first(values: dict[str, float], where: str) -> None:
    for name, value in values.items():
        if np.isnan(value):
            optional = ', or the column must go' if name in INITIAL else ''
            raise RecordError(f'{where}, column {name}: the first row needs one{optional}')


def _held(current: np.ndarray, standing: float) -> np.ndarray:
    """Return the currents with the one before in place of NaN."""
    latest = last_known(current)
    return np.where(latest < 0, standing, current[latest])
