# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Read CSV records, whole or in chunks of rows, and write them row by row."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from io import BytesIO
import os
from pathlib import Path
from typing import BinaryIO, NamedTuple

import numpy as np

from booster_ros.records.clock import check_clock
from booster_ros.records.csv_digits import fixed_lines
from booster_ros.records.csv_header import Header, read_header
from booster_ros.records.csv_text import line_blocks, parse_block
from booster_ros.records.guarded import (
    LONGEST_LINE, check_count, check_regular, endless_line)
from booster_ros.records.record import COLUMNS, Array, Defect, RecordError
from booster_ros.records.target import replaced_by
from booster_ros.records.units import check_finite, check_units
from booster_ros.writing.replacement import Replacement

_DECIMALS = {'s': 6, 'A': 12, 'Pa': 3, 'm': 9, 'kg/s': 12}
"""Written decimals by unit, well below the resolution of any sensor."""


class Chunk(NamedTuple):
    """Some consecutive rows of a CSV: their numbers and their values (rows x columns)."""

    rows: Array
    values: Array


def csv_columns(path: str | os.PathLike[str]) -> tuple[str, ...]:
    """Return the known columns of a CSV in the order of the file, RecordError if there are none."""
    with _opened(path) as (header, _):
        return header.names


def csv_header_notes(path: str | os.PathLike[str]) -> tuple[str, ...]:
    """Return a sentence for each column of a CSV that is ignored or read under another name."""
    with _opened(path) as (header, _):
        return tuple(map(str, header.defects))


def read_csv(path: str | os.PathLike[str]) -> tuple[dict[str, Array], Array, tuple[Defect, ...]]:
    """Return the known columns of a CSV as they are, the row numbers, and notes on the header."""
    source = str(path)
    chunks, count = [], 0
    with _opened(path) as (header, file):
        for chunk in _chunks(header, file, source):
            count += chunk.values.size
            check_count(count, source)
            chunks.append(chunk)
    if not chunks:
        raise _without_rows(source)
    rows = np.concatenate([chunk.rows for chunk in chunks])
    columns = {
        name: np.concatenate([chunk.values[:, place] for chunk in chunks])
        for place, name in enumerate(header.names)
    }
    return columns, rows, header.defects


def iterate_csv(
    path: str | os.PathLike[str], columns: Sequence[str], rows_per_chunk: int = 100_000
) -> Iterator[Chunk]:
    """
    Yield the wanted columns, in the order asked for, at most `rows_per_chunk` rows at a time.

    Memory stays flat however long the file is. Cells that are empty are NaN. RecordError where a
    column is missing, a cell is no finite number, a unit is wrong, or time is missing, runs
    backwards or was set; a stamp may come twice.
    """
    source = str(path)
    with _opened(path) as (header, file):
        wanted = _wanted(header, columns, source)
        before = np.array([], dtype=int), np.array([])
        empty = True
        for chunk in _chunks(wanted, file, source):
            if 'time' in wanted.positions:
                before = _check_time(chunk, wanted, before, source)
            for first in range(0, len(chunk.rows), rows_per_chunk):
                empty = False
                part = slice(first, first + rows_per_chunk)
                yield Chunk(chunk.rows[part], chunk.values[part])
        if empty:
            raise _without_rows(source)


def first_row(path: str | os.PathLike[str], columns: Sequence[str]) -> Chunk:
    """
    Return the first row of the wanted columns, in the order asked for, whatever stands below it.

    A cell that is empty is NaN. RecordError where a column or the row is missing, a cell is no
    finite number or a unit is wrong.
    """
    source = str(path)
    with _opened(path) as (header, file):
        wanted = _wanted(header, columns, source)
        for chunk in _chunks(wanted, BytesIO(_to_first_row(file, source)), source):
            return chunk
        raise _without_rows(source)


def _wanted(header: Header, columns: Sequence[str], source: str) -> Header:
    """Return the header of the wanted columns alone; RecordError where one is missing."""
    missing = [name for name in columns if name not in header.positions]
    if missing:
        raise RecordError(f'{source}, row 1: there is no column {missing[0]}')
    return replace(
        header, positions={name: header.positions[name] for name in columns}, defects=())


def _to_first_row(file: BinaryIO, source: str) -> bytes:
    """Return the rest of a file as far as its first line that is not blank."""
    blank = b''
    for block in line_blocks(file, source):
        text = block.lstrip()
        if text:
            return blank + block[:block.index(b'\n', len(block) - len(text)) + 1]
        blank += block
    return blank


def _without_rows(source: str) -> RecordError:
    return RecordError(f'{source} has a header and no rows of data')


@contextmanager
def _opened(path: str | os.PathLike[str]) -> Iterator[tuple[Header, BinaryIO]]:
    check_regular(path)
    try:
        with open(path, 'rb') as file:
            first_line = file.readline(LONGEST_LINE + 1)
            if b'\r' in first_line.rstrip(b'\r\n'):
                first_line = first_line.split(b'\r', 1)[0] + b'\r'
                file.seek(len(first_line))
            if len(first_line) > LONGEST_LINE:
                raise endless_line(str(path))
            if not first_line.strip():
                raise RecordError(f'{path}: the first row is empty, it must name the columns')
            yield read_header(first_line, str(path)), file
    except OSError as error:
        raise RecordError(f'{path}: {error.strerror}') from None


def _chunks(header: Header, file: BinaryIO, source: str) -> Iterator[Chunk]:
    first_row = 2
    for block in line_blocks(file, source):
        rows, values = parse_block(block, first_row, header, source)
        first_row += block.count(b'\n')
        for place, name in enumerate(header.names):
            if name in header.conversions:
                values[:, place] = header.conversions[name].of(values[:, place])
        if rows.size:
            for place, name in enumerate(header.names):
                check_finite(name, values[:, place], rows, source)
                check_units(name, values[:, place], rows, source)
            yield Chunk(rows, values)


def _check_time(
    chunk: Chunk, header: Header, before: tuple[Array, Array], source: str
) -> tuple[Array, Array]:
    """Check the times of a chunk behind the row and time `before` it; return the chunk's last."""
    time = chunk.values[:, header.names.index('time')]
    missing = np.flatnonzero(np.isnan(time))
    if missing.size:
        row = chunk.rows[missing[0]]
        raise RecordError(f'{source}, row {row}, column time: the time is missing')
    rows_before, time_before = before
    check_clock(np.append(time_before, time), np.append(rows_before, chunk.rows), source)
    return chunk.rows[-1:].copy(), time[-1:].copy()  # not views of the chunk: memory stays flat


def _decimals(column: str) -> int | None:
    """Return the decimals of a known column; others are written with significant digits."""
    return _DECIMALS[COLUMNS[column].unit] if column in COLUMNS else None


class CsvWriter:
    """
    Writes a CSV record row by row.

    The file has a temporary name beside the wanted one until `close`; used in a `with`, an
    exception discards it. A link is followed. RecordError where the file cannot be written, or
    would take the place of what is no file.
    """

    def __init__(self, path: str | os.PathLike[str], columns: Sequence[str]):
        self.path = Path(path)
        """Where the file is once it is complete."""
        self._target = replaced_by(self.path)
        decimals = [_decimals(name) for name in columns]
        self._decimals = [places for places in decimals if places is not None]
        self._row = ','.join(
            '%.9g' if places is None else f'%.{places}f' for places in decimals) + '\n'
        try:
            self._file = Replacement(self._target)
        except OSError as error:
            raise self._failed(error) from None
        self._write((','.join(columns) + '\n').encode('ascii'))

    def write_rows(self, values: Array) -> None:
        """Append rows x columns of values, NaN where one is missing."""
        table = np.asarray(values, dtype=float)
        lines = None
        if len(self._decimals) == table.shape[1]:
            lines = fixed_lines(table, self._decimals)
        if lines is None:
            lines = (self._row * len(table) % tuple(table.ravel().tolist())).encode('ascii')
        self._write(lines)

    def spare(self) -> None:
        """Keep a file that has the wanted name: write to NAME.partial.csv instead, for good."""
        if self._target.exists():
            name = f'{self._target.stem}.partial{self._target.suffix}'
            self._target = self._file.target = replaced_by(self._target.with_name(name))
            self.path = self._target

    def close(self) -> None:
        """Complete the file and give it its name."""
        try:
            self._file.complete()
        except OSError as error:
            raise self._failed(error) from None

    def discard(self) -> None:
        """Remove what was written."""
        self._file.discard()

    def _write(self, data: bytes) -> None:
        try:
            self._file.write(data)
        except OSError as error:
            raise self._failed(error) from None

    def _failed(self, error: OSError) -> RecordError:
        return RecordError(f'{self.path} cannot be written: {error.strerror}')

    def __enter__(self) -> 'CsvWriter':
        """Return the writer."""
        return self

    def __exit__(self, kind: object, error: object, trace: object) -> None:
        """Complete the file, or discard it after an exception."""
        if kind is None:
            self.close()
        else:
            self.discard()
