# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tables in Excel workbooks (.xlsx), read by openpyxl row by row."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
import datetime
import importlib
import itertools
from typing import Any
import warnings
import zipfile

from booster_ros.records.mapping import Layout
from booster_ros.records.open_table import needs
from booster_ros.records.record import RecordError
from booster_ros.records.table import Portion, Table
from booster_ros.records.text_layout import SAMPLE_LINES, found_in

PORTION = 50_000
_LARGEST = 1 << 31
"""Bytes of the largest workbook, unpacked."""

_SEPARATOR = '\x01'  # no white space, which '\x1f' is


def open_sheet(source: str, layout: Layout) -> Table:
    """Return the table in a sheet, the first or the one named; RecordError where there is none."""
    _check_size(source)
    sample = list(itertools.islice(_rows(source, layout.sheet), SAMPLE_LINES))
    # what separates cells in this text is in no cell
    lines = [_SEPARATOR.join(row) for row in _alike(sample)]
    found = found_in(lines, Layout(None, _SEPARATOR, '.', None, layout.header, layout.first,
                                   layout.sheet), source)
    shown = Layout(header=found.layout.header, first=found.layout.first, sheet=layout.sheet)

    def portions(texts: Collection[int], wanted: Collection[int]) -> Iterator[Portion]:
        return _portions(source, found.layout, set(texts), sorted(wanted))

    return Table(source, 'Excel workbook', found.names, found.units, found.labels,
                 tuple(line.replace(_SEPARATOR, ' ').strip() for line in found.preamble), shown,
                 portions)


def _check_size(source: str) -> None:
    with zipfile.ZipFile(source) as archive:
        if sum(one.file_size for one in archive.infolist()) > _LARGEST:
            raise RecordError(f'{source}: is larger than 2 GB when it is unpacked; export it as '
                              'CSV')


def _rows(source: str, sheet: str | None) -> Iterator[Sequence[Any]]:
    try:
        load_workbook = importlib.import_module('openpyxl').load_workbook
    except ModuleNotFoundError:
        raise needs('openpyxl', source, 'reading an Excel workbook') from None
    try:
        yield from _cells(load_workbook, source, sheet)
    except RecordError:
        raise
    except Exception as error:  # openpyxl raises whatever the XML in a damaged file meets
        raise RecordError(f'{source}: is no readable workbook '
                          f'({" ".join(str(error).split())[:80]})') from None


def _cells(load_workbook: Any, source: str, sheet: str | None) -> Iterator[Sequence[Any]]:
    with warnings.catch_warnings():
        warnings.simplefilter('ignore')  # of styles and extensions
        book = load_workbook(source, read_only=True, data_only=True)
    try:
        names = book.sheetnames
        if sheet is not None and sheet not in names:
            raise RecordError(f'{source}: has no sheet {sheet[:60]!r}; it has '
                              f'{", ".join(names[:20])}')
        chosen = book[sheet or names[0]]
        chosen.reset_dimensions()
        yield from chosen.iter_rows(values_only=True)
    finally:
        book.close()


def _alike(sample: Sequence[Sequence[Any]]) -> list[list[str]]:
    """Return rows as texts, all as wide as the widest: what is filled."""
    texts = [[_text(cell) for cell in row] for row in sample]
    width = max((place for row in texts for place, cell in enumerate(row, 1) if cell), default=0)
    return [row[:width] + [''] * (width - len(row)) for row in texts]


def _portions(source: str, layout: Layout, texts: set[int], wanted: list[int]
              ) -> Iterator[Portion]:
    import pandas as pd

    first = layout.first or 1
    rows = itertools.islice(_rows(source, layout.sheet), first - 1, None)
    number = first
    while block := list(itertools.islice(rows, PORTION)):
        columns = {}
        for place in wanted:
            cells = [row[place] if place < len(row) else None for row in block]
            series = pd.Series(cells, dtype=object).infer_objects()
            if place in texts and series.dtype.kind != 'M':
                series = pd.Series([None if cell is None else _text(cell) for cell in cells],
                                   dtype='str')
            columns[place] = series
        frame = pd.DataFrame(columns)
        frame.index = range(number, number + len(block))
        number += len(block)
        filled = frame.notna().any(axis=1).to_numpy()
        yield Portion(frame.index.to_numpy()[filled], frame[filled])


def _text(cell: Any) -> str:
    if cell is None:
        return ''
    if isinstance(cell, datetime.datetime):
        return cell.isoformat(' ')
    return str(cell).replace('\n', ' ')
