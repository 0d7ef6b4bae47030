# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tables in text (CSV and what is like it, JSON lines), read by pandas in portions."""

from __future__ import annotations

from collections.abc import Collection, Iterator
import io
import itertools
import os
import re
from typing import Any

from booster_ros.records.guarded import opened_bytes
from booster_ros.records.mapping import Layout
from booster_ros.records.record import RecordError
from booster_ros.records.table import Portion, Table
from booster_ros.records.text_layout import SAMPLE_LINES, SPACES, Found, found_in

PORTION = 200_000
MOST_CELLS = 10_000_000
_MOST_TEXT = 1 << 25
"""Most rows, cells and characters that are read at once."""

_SAMPLE = 1 << 18


def open_text(path: str | os.PathLike[str], layout: Layout) -> Table:
    """Return the table in a text file, compressed or not; RecordError where there is none."""
    source = os.fspath(path)
    with opened_bytes(path) as file:
        start = file.read(_SAMPLE)
    if not start.strip(b'\0'):
        raise RecordError(f'{source}: is empty' if not start else f'{source}: is not text')
    encoding = layout.encoding or _encoding(start, source)
    text = _decoded(start, encoding, source)
    if '\0' in text:
        raise RecordError(f'{source}: is binary, and of no known format')
    if text.lstrip('\ufeff \r\n\t').startswith('{'):
        return _json_lines(path, encoding)
    lines = re.split(r'\r\n|\r\r\n|\n|\r', text)
    if len(lines) > 1:
        del lines[-1]  # which may be cut, or is empty
    found = found_in(lines[:SAMPLE_LINES], layout, source)
    return _text_table(path, found, encoding)


def _text_table(path: str | os.PathLike[str], found: Found, encoding: str) -> Table:
    layout = Layout(**{**found.layout.__dict__, 'encoding': encoding})

    def portions(text_columns: Collection[int], wanted: Collection[int]) -> Iterator[Portion]:
        return _read(path, layout, len(found.names), set(text_columns), sorted(wanted))

    kind = 'text' if layout.delimiter != '\t' else 'text, columns separated by tabs'
    return Table(os.fspath(path), kind, found.names, found.units, found.labels, found.preamble,
                 layout, portions)


def _encoding(start: bytes, source: str) -> str:
    for mark, name in ((b'\xef\xbb\xbf', 'utf-8-sig'), (b'\xff\xfe', 'utf-16'),
                       (b'\xfe\xff', 'utf-16')):
        if start.startswith(mark):
            return name
    try:
        start[:start.rfind(b'\n') + 1 or None].decode()
    except UnicodeDecodeError:
        if b'\0' in start:
            raise RecordError(f'{source}: is binary, and of no known format') from None
        return 'cp1252'
    return 'utf-8'


def _decoded(start: bytes, encoding: str, source: str) -> str:
    try:
        return start.decode(encoding, errors='replace')
    except LookupError:
        raise RecordError(f'{source}: there is no encoding {encoding[:40]!r}') from None


def _read(
    path: str | os.PathLike[str], layout: Layout, width: int, texts: set[int], wanted: list[int]
) -> Iterator[Portion]:
    import pandas as pd

    source = os.fspath(path)
    first = layout.first or 1
    options: dict[str, Any] = {
        'sep': r'\s+' if layout.delimiter == SPACES else layout.delimiter,
        'header': None, 'names': list(range(width + 1)), 'index_col': False,
        # pandas takes 01.02.2024 for a number where points separate thousands
        'dtype': str if layout.thousands else dict.fromkeys(texts, str), 'engine': 'c',
        'decimal': layout.decimal or '.', 'skip_blank_lines': False,
        'chunksize': min(PORTION, MOST_CELLS // (width + 1)), 'skipinitialspace': True,
        'low_memory': False,
    }
    if tuple(map(int, pd.__version__.split('.')[:2])) < (3, 1):
        options['float_precision'] = 'round_trip'  # as it is from 3.1 on
    with opened_bytes(path) as file:
        text = io.TextIOWrapper(file, layout.encoding or 'utf-8', newline=None)
        try:
            for line in range(first - 1):
                if not text.readline():
                    raise RecordError(f'{source}: has no line {line + 1}')
            row = first
            for frame in pd.read_csv(_Lines(text), **options):
                frame.index = range(row, row + len(frame))
                row += len(frame)
                # pandas would leave out cells behind the last column, and say nothing
                beyond = frame.pop(width).notna().to_numpy()
                if beyond.any():
                    raise RecordError(f'{source}: row {frame.index[beyond][0]} has more cells than '
                                      f'the {width} of the others')
                frame = frame[wanted].copy()
                for place in set(wanted) - texts:
                    frame[place] = _plain(frame[place], layout)
                filled = frame.notna().any(axis=1).to_numpy()
                yield Portion(frame.index.to_numpy()[filled], frame[filled])
        except UnicodeDecodeError as error:
            raise _not_throughout(source, error) from None
        except pd.errors.EmptyDataError:
            return
        except pd.errors.ParserError as error:
            raise RecordError(f'{source}: {_told(str(error), first, width)}') from None


def _plain(values: Any, layout: Layout) -> Any:
    """Return a column with the numbers in it written with a point and no thousands."""
    decimal, thousands = layout.decimal or '.', layout.thousands
    if values.dtype.kind in 'iufb' or (decimal == '.' and thousands is None):
        return values
    groups = rf'\d{{1,3}}(?:{re.escape(thousands)}\d{{3}})+|' if thousands else ''
    number = rf'\s*[-+]?(?:{groups}\d+|(?={re.escape(decimal)}))(?:{re.escape(decimal)}\d*)?' \
        r'(?:[eE][-+]?\d+)?\s*'
    text = values.astype('str')
    is_number = text.str.fullmatch(number).fillna(False).astype(bool)
    written = text[is_number]
    if thousands:
        written = written.str.replace(thousands, '', regex=False)
    plain = values.astype(object)
    plain[is_number] = written.str.replace(decimal, '.', regex=False).astype(object)
    return plain


def _told(message: str, first: int, width: int) -> str:
    """Return what pandas says of a line, the line counted as an editor does."""
    fields = re.search(r'Expected \d+ fields in line (\d+), saw (\d+)', message)
    if fields:
        return (f'row {int(fields[1]) + first - 1} has {fields[2]} cells where the others have '
                f'{width}')  # pandas expects one more, behind the last
    return f'is not a table, {" ".join(message.split())[:120]}'


class _Lines:
    """What pandas reads from: text in portions, however long its lines are."""

    def __init__(self, text: io.TextIOWrapper):
        self._text = text

    def read(self, size: int = -1) -> str:
        return self._text.read(size if size > 0 else _SAMPLE)

    def __iter__(self) -> Iterator[str]:
        return iter(self._text)


def _json_lines(path: str | os.PathLike[str], encoding: str) -> Table:
    source = os.fspath(path)
    with opened_bytes(path) as file:
        text = io.TextIOWrapper(file, encoding)
        sample = next(_json_frames(text, source, 200), None)
    if sample is None:
        raise RecordError(f'{source}: has no row')
    names = tuple(map(str, sample.columns))
    blank = ('',) * len(names)

    def portions(text_columns: Collection[int], wanted: Collection[int]) -> Iterator[Portion]:
        row = 1
        with opened_bytes(path) as file:
            for frame in _json_frames(io.TextIOWrapper(file, encoding), source, PORTION):
                frame = frame.reindex(columns=list(names))
                frame.columns = range(len(names))
                frame = frame[sorted(wanted)]
                for place in set(text_columns) & set(wanted):
                    frame[place] = frame[place].astype('str').where(frame[place].notna())
                numbers = range(row, row + len(frame))
                frame.index = numbers
                row += len(frame)
                yield Portion(frame.index.to_numpy(), frame)

    return Table(source, 'JSON lines', names, blank, blank, (), Layout(), portions)


def _some_lines(text: io.TextIOWrapper, size: int) -> list[str]:
    """Return the next lines, fewer than `size` where they are long."""
    lines, length = [], 0
    for line in itertools.islice(text, size):
        lines.append(line)
        length += len(line)
        if length > _MOST_TEXT:
            break
    return lines


def _json_frames(text: io.TextIOWrapper, source: str, size: int) -> Iterator[Any]:
    import pandas as pd

    row = 1
    while True:
        try:
            lines = _some_lines(text, size)
            if not ''.join(lines).strip():
                return
            yield pd.read_json(io.StringIO(''.join(lines)), lines=True, dtype=False,
                               precise_float=True)
        except UnicodeDecodeError as error:
            raise _not_throughout(source, error) from None
        except ValueError as error:
            raise RecordError(f'{source}, row {row} or below: is not one JSON object a line '
                              f'({" ".join(str(error).split())[:80]})') from None
        row += len(lines)


def _not_throughout(source: str, error: UnicodeDecodeError) -> RecordError:
    return RecordError(f'{source}: is not {error.encoding} throughout; say what it is in the '
                       'mapping, as in file: {encoding: cp1252}')
