# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Turn the lines of a CSV into numbers.

A block of clean lines is parsed at once. A block that has anything odd in it is read line by line,
which is slower and knows the row and the column of what it cannot read.
"""

from collections.abc import Iterator
import csv
import io
from typing import BinaryIO

import numpy as np

from booster_ros.records.csv_header import Header
from booster_ros.records.guarded import LONGEST_LINE, endless_line
from booster_ros.records.record import Array, RecordError

_BLOCK_BYTES = 4 << 20
_ODD_SPACES = (b'\xa0', b'\x85')
"""Bytes that numpy takes for spaces and that are none in UTF-8: what is refused elsewhere is so."""

_MISSING = frozenset({'', 'nan', 'na', 'n/a', 'null', 'none'})


def line_blocks(file: BinaryIO, source: str) -> Iterator[bytes]:
    """
    Yield the rest of a file in blocks of whole lines that end in a line feed.

    RecordError where a line is longer than `LONGEST_LINE` bytes: it would be kept whole in memory.
    """
    left = b''
    while data := file.read(_BLOCK_BYTES):
        rest = file.readline(LONGEST_LINE + 1)
        block, left = left + data + rest, b''
        if len(rest) > LONGEST_LINE:  # no line feed: lines may end in carriage returns alone
            end = block.rfind(b'\r', 0, -1) + 1
            if end < len(block) - LONGEST_LINE:
                raise endless_line(source)
            block, left = block[:end], block[end:]
        yield _with_line_feeds(block)
    if left:
        yield _with_line_feeds(left)


def _with_line_feeds(block: bytes) -> bytes:
    if b'\r' in block:
        block = block.replace(b'\r\n', b'\n').replace(b'\r', b'\n')
    return block if block.endswith(b'\n') else block + b'\n'


def parse_block(block: bytes, first_row: int, header: Header, source: str) -> tuple[Array, Array]:
    """
    Return the row numbers and the values (rows x known columns) of a block of lines.

    Cells that are empty or say nan are NaN, blank lines are skipped. RecordError names row and
    column of a cell that is not a number, and the row that has too many or too few cells.
    """
    values = _parse_at_once(block, header)
    if values is None:
        return _parse_line_by_line(block, first_row, header, source)
    return np.arange(first_row, first_row + len(values)), values


def _parse_at_once(block: bytes, header: Header) -> Array | None:
    if not _is_rectangular(block, header):
        return None
    text = block
    if header.delimiter != ',':
        text = text.replace(b',', b'.').replace(header.delimiter.encode(), b',')
    if b',,' in text or b',\n' in text or b'\n,' in text or text.startswith(b','):
        text = _fill_empty_cells(text)
    try:
        values = np.loadtxt(
            io.BytesIO(text), delimiter=',', comments=None, ndmin=2, encoding='latin-1',
            usecols=tuple(header.positions.values()),
        )
    except ValueError:
        return None
    return values if len(values) == block.count(b'\n') else None


def _is_rectangular(block: bytes, header: Header) -> bool:
    """Tell whether every line has as many cells as the header; quotes take the slower way."""
    if b'"' in block or not block.strip() or any(space in block for space in _ODD_SPACES):
        return False
    characters = np.frombuffer(block, dtype=np.uint8)
    ends = np.flatnonzero(characters == ord('\n'))
    starts = np.concatenate([[0], ends[:-1] + 1])
    if (ends == starts).any():
        return False
    separators = np.flatnonzero(characters == ord(header.delimiter))
    per_line = header.width - 1
    if separators.size != ends.size * per_line:
        return False
    if not per_line:
        return True
    by_line = separators.reshape(ends.size, per_line)
    return bool((by_line[:, 0] >= starts).all() and (by_line[:, -1] < ends).all())


def _fill_empty_cells(text: bytes) -> bytes:
    if text.startswith(b','):
        text = b'nan' + text
    text = text.replace(b'\n,', b'\nnan,').replace(b',\n', b',nan\n')
    return text.replace(b',,', b',nan,').replace(b',,', b',nan,')


def _parse_line_by_line(
    block: bytes, first_row: int, header: Header, source: str
) -> tuple[Array, Array]:
    rows = []
    values = []
    for row, line in enumerate(block.split(b'\n')[:-1], first_row):
        text = line.decode('utf-8', errors='replace')
        if not text.strip():
            continue
        rows.append(row)
        values.append(_parse_line(text, row, header, source))
    return np.array(rows, dtype=int), np.array(values).reshape(len(rows), len(header.positions))


def _parse_line(text: str, row: int, header: Header, source: str) -> list[float]:
    cells = _split(text, row, header, source)
    if len(cells) != header.width:
        hint = ''
        if header.delimiter == ',' and len(cells) > header.width:
            hint = '; with decimal commas, separate the columns by semicolons'
        raise RecordError(
            f'{source}, row {row}: {len(cells)} cells where the header has {header.width}{hint}'
        )
    units = row == 2 and not any(map(str.isdigit, text))
    hint = ' (remove the row of units below the header)' if units else ''
    return [
        _number(cells[place], row, name, header, source, hint)
        for name, place in header.positions.items()
    ]


def _split(text: str, row: int, header: Header, source: str) -> list[str]:
    if '"' not in text:
        return text.split(header.delimiter)
    try:
        return next(csv.reader([text], delimiter=header.delimiter, strict=True))
    except csv.Error as error:
        raise RecordError(f'{source}, row {row}: the quotes do not match ({error})') from None


def _number(
    cell: str, row: int, name: str, header: Header, source: str, hint: str
) -> float:
    text = cell.strip()
    if text.lower() in _MISSING:
        return float('nan')
    if header.delimiter != ',':
        text = text.replace(',', '.')
    try:
        # Python also reads 1_000 and digits of other scripts, which no data logger means.
        if '_' in text or not text.isascii():
            raise ValueError
        return float(text)
    except ValueError:
        raise RecordError(
            f'{source}, row {row}, column {name}: {cell.strip()[:40]!r} is not a number{hint}'
        ) from None
