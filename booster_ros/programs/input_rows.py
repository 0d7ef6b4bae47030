# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The rows that `simulate` is driven with: read from a CSV in portions, or from a mapped file."""

from __future__ import annotations

from collections.abc import Container, Iterator
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np

from ..records import (
    FileMapping, Record, RecordError, csv_columns, csv_header_notes, first_row, iterate_csv,
    read_record)
from ..records.holding import last_known
from .mapping_options import pointing_to_inspect

PROCESS = 'pressure_drop'
"""Column that pushes the stem where the input has it."""

INITIAL = ('chamber_pressure', 'valve_position', PROCESS)
"""Columns of which the first row counts."""

_PORTION = 100_000


class Portion(NamedTuple):
    """Consecutive rows of the input: time (s), command (A or m) and what is pinned, by column."""

    time: np.ndarray
    command: np.ndarray
    pinned: dict[str, np.ndarray]


class InputRows(Protocol):
    """Times (s), commands (A or m), the first row, and what is to be said of the file."""

    source: Path
    command: str
    notes: tuple[str, ...]

    def first(self) -> tuple[float, float, dict[str, float]]:
        """Return time, command and state to start from."""

    def portions(self, pinned: tuple[str, ...]) -> Iterator[Portion]:
        """Yield the rows in portions; a missing value is the one before."""

    def count(self) -> int:
        """Return about how many rows there are."""


def input_rows(
    source: Path, command: str, mapping: FileMapping | None, travel: float
) -> InputRows:
    """
    Return the rows of a file, mapped where a mapping is given.

    `command` is the column that drives the model; `travel`, m, is what per cent of travel are of.
    RecordError where a column is missing.
    """
    if mapping is None:
        return CsvRows(source, command)
    with pointing_to_inspect(source):
        return RecordRows(source, command, read_record(source, mapping=mapping, travel=travel))


class CsvRows:
    """The rows of a CSV, read in portions: memory stays flat however long it is."""

    def __init__(self, source: Path, command: str):
        self.source = source
        self.command = command
        with pointing_to_inspect(source):
            known = csv_columns(source)
            _check_columns(command, known, f'{source}, row 1: there is no column')
            self.notes = csv_header_notes(source)
        self._given = tuple(name for name in INITIAL if name in known)

    def first(self) -> tuple[float, float, dict[str, float]]:
        """Return time, command and state to start from; RecordError where a value is missing."""
        names = ('time', self.command, *self._given)
        with pointing_to_inspect(self.source):
            first = first_row(self.source, names)
            values = dict(zip(names, first.values[0].tolist(), strict=True))
            _check_first(values, f'{self.source}, row {first.rows[0]}')
        return values['time'], values[self.command], {name: values[name] for name in self._given}

    def portions(self, pinned: tuple[str, ...]) -> Iterator[Portion]:
        """Yield the rows in portions; an empty cell keeps the value before."""
        names = (self.command, *pinned)
        standing = np.full(len(names), np.nan)
        with pointing_to_inspect(self.source):
            for chunk in iterate_csv(self.source, ('time', *names)):
                held = [_held(values, last)
                        for values, last in zip(chunk.values[:, 1:].T, standing, strict=True)]
                standing = np.array([values[-1] for values in held])
                yield Portion(chunk.values[:, 0], held[0], dict(zip(pinned, held[1:], strict=True)))

    def count(self) -> int:
        """Return the number of lines below the header."""
        lines = 0
        with open(self.source, 'rb', buffering=0) as file:
            while block := file.read(1 << 20):
                lines += block.count(b'\n')
        return lines - 1


class RecordRows:
    """The rows of a record that is in memory, as a mapped file is."""

    def __init__(self, source: Path, command: str, record: Record):
        self.source = source
        self.command = command
        self.notes = record.notes
        # a set point of a pressure lies beside the columns, and drives no stem
        _check_columns(command, record.columns, f'{source}: as it is mapped it has no')
        self._record = record
        self._given = tuple(name for name in INITIAL if name in record.columns)

    def first(self) -> tuple[float, float, dict[str, float]]:
        """Return time, command and state to start from; RecordError where a value is missing."""
        names = ('time', self.command, *self._given)
        values = {name: float(self._record[name][0]) for name in names}
        with pointing_to_inspect(self.source):
            _check_first(values, f'{self.source}, row {self._record.rows[0]}')
        return values['time'], values[self.command], {name: values[name] for name in self._given}

    def portions(self, pinned: tuple[str, ...]) -> Iterator[Portion]:
        """Yield the rows in portions; a missing value is the one before."""
        held = {name: _held(self._record[name], np.nan) for name in (self.command, *pinned)}
        for begin in range(0, len(self._record), _PORTION):
            part = slice(begin, begin + _PORTION)
            yield Portion(self._record['time'][part], held[self.command][part],
                          {name: held[name][part] for name in pinned})

    def count(self) -> int:
        """Return the number of rows."""
        return len(self._record)


def _check_columns(command: str, known: Container[str], sentence: str) -> None:
    """Raise RecordError where time or command is missing, before anything is compiled."""
    for name in ('time', command):
        if name not in known:
            raise RecordError(f'{sentence} {name}{_hint(command, known)}')


def _hint(command: str, known: Container[str]) -> str:
    """Return what to do where the table has the other kind of command."""
    if command == 'control_current' and 'set_point' in known:
        return '; a set_point needs position_controller.enabled: true in the parameters'
    if command == 'set_point' and 'control_current' in known:
        return '; a control_current needs position_controller.enabled: false in the parameters'
    return ''


def _check_first(values: dict[str, float], where: str) -> None:
    for name, value in values.items():
        if np.isnan(value):
            optional = ', or the column must go' if name in INITIAL else ''
            raise RecordError(f'{where}, column {name}: the first row needs one{optional}')


def _held(values: np.ndarray, standing: float) -> np.ndarray:
    """Return the values with the one before in place of NaN."""
    latest = last_known(values)
    return np.where(latest < 0, standing, values[latest])
