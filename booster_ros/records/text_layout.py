# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Find out how a table in text is laid out, from its first lines.

Rows of data are those with as many cells as most lines have and numbers or times in them. Above
them the first line with as many cells names the columns; what stands between says units or more.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
import csv
from dataclasses import dataclass
import re

from booster_ros.records.conversion import parsed_unit
from booster_ros.records.guarded import MOST_COLUMNS
from booster_ros.records.mapping import Layout
from booster_ros.records.record import RecordError

SAMPLE_LINES = 400
DELIMITERS = ('\t', ';', ',', '|')
SPACES = 'spaces'
LONGEST_NAME = 200
"""Characters of a name of a column, beyond which the rest is left out."""

_NUMBER = re.compile(r'[-+]?(\d[\d.,\s]*|[.,]\d+)([eE][-+]?\d+)?')
_TIME = re.compile(r'\d{1,4}[-/.:]\d{1,2}|\d{1,2}[-/ .][A-Za-z]{3}[-/ .]\d{2,4}|\d{8}[T ]\d{4}')
_GROUPED = re.compile(r'[-+]?[1-9]\d{0,2},\d{3}')
_WHOLE = re.compile(r'[-+]?[1-9]\d{0,2}')
_NO_VALUE = frozenset({'', 'nan', 'na', 'n/a', 'null', 'none', '-', '--'})
_COMMENTS = ('#', '%', '//', ';')
_FEWEST_SHARE = 1 / 3


@dataclass(frozen=True)
class Found:
    """
    What the first lines of a table tell.

    `names` are those of the columns, made up where the table has none; `labels` is what stands
    below a name and is no unit; `units` what stands there and is one. `preamble` are the lines
    above. Lines count from 1; `header` is 0 where no line names the columns.
    """

    layout: Layout
    names: tuple[str, ...]
    units: tuple[str, ...]
    labels: tuple[str, ...]
    preamble: tuple[str, ...]


def found_in(lines: Sequence[str], given: Layout, source: str) -> Found:
    """Return what the first lines tell, as far as `given` does not; RecordError for no table."""
    delimiter = given.delimiter or best_delimiter(lines)
    rows = [cells_of(line, delimiter) for line in lines]
    if max(map(len, rows), default=0) > MOST_COLUMNS:
        raise RecordError(f'{source}: has more than {MOST_COLUMNS} columns, which no record has')
    width = _width(rows)
    first = given.first or _first_data(rows, width)
    if not first:
        raise RecordError(f'{source}: no line has numbers in columns, as the rows of a table have')
    header = _header(rows[:first - 1], width) if given.header is None else given.header
    named = rows[header - 1] if 0 < header <= len(rows) else []
    width = max(width, len(_filled(named)))
    below = [row for row in rows[header:first - 1] if len(row) >= min(2, width)] if header else []
    units = next((row for row in below if _are_units(row)), [])
    labels = next((row for row in below if row is not units and len(row) == len(named)), [])
    data = rows[first - 1:]
    decimal = given.decimal or _decimal(data, delimiter, source)
    thousands = given.thousands or _thousands(data, delimiter, decimal)
    return Found(
        Layout(given.encoding, delimiter, decimal, thousands, header, first, given.sheet),
        _names(named, width), _padded(units, width), _padded(labels, width),
        tuple(lines[:(header or first) - 1]))


def best_delimiter(lines: Sequence[str]) -> str:
    """Return what separates the cells: that by which most lines have the same number of them."""
    body = [line for line in lines[len(lines) // 2:] if line.strip()] or list(lines)
    best, score = ',', (0.0, 0)
    for delimiter in DELIMITERS:
        widths = Counter(len(cells_of(line, delimiter)) for line in body)
        width, count = widths.most_common(1)[0] if widths else (1, 0)
        share = count / max(len(body), 1)
        data = sum(map(is_data, (cells_of(line, delimiter) for line in body)))
        if width > 1 and (share * data, width) > score:
            best, score = delimiter, (share * data, width)
    if score[0] == 0.0:
        widths = Counter(len(line.split()) for line in body)
        width, count = widths.most_common(1)[0] if widths else (1, 0)
        if width > 1 and count > 0.8 * len(body):
            return SPACES
    return best


def cells_of(line: str, delimiter: str) -> list[str]:
    """Return the cells of a line, without the spaces around them."""
    if delimiter == SPACES:
        return line.split()
    if '"' in line:
        try:
            return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter), [])]
        except csv.Error:
            pass
    return [cell.strip() for cell in line.split(delimiter)]


def is_datum(cell: str) -> bool:
    """Tell whether a cell holds a number or a time."""
    return bool(_NUMBER.fullmatch(cell) or _TIME.match(cell))


def is_data(cells: Sequence[str]) -> bool:
    """Tell whether the cells of a line are those of a row of data."""
    given = [cell for cell in cells if cell.lower() not in _NO_VALUE]
    data = sum(map(is_datum, given))
    return data >= 1 and data >= _FEWEST_SHARE * len(given)


def _width(rows: Sequence[Sequence[str]]) -> int:
    body = [len(row) for row in rows[len(rows) // 2:] if any(row)]
    return Counter(body or [len(row) for row in rows]).most_common(1)[0][0] if rows else 0


def _first_data(rows: Sequence[Sequence[str]], width: int) -> int:
    """Return the number of the first line of data that is followed by more; 0 for none."""
    fit = [len(row) == width and is_data(row) for row in rows]
    for place, good in enumerate(fit):
        if good and all(fit[place:place + 3]):
            return place + 1
    return 0


def _header(rows: Sequence[Sequence[str]], width: int) -> int:
    """Return the number of the line that names the columns, 0 for none."""
    # a row of data may end in a delimiter that the header lacks; a title of one cell is no header,
    # nor one that a spreadsheet filled up with empty cells
    for long in (width, max(width - 1, 2)):
        for number, row in enumerate(rows, 1):
            cells = _filled(_uncommented(row))
            named = [cell for cell in cells if cell]
            if len(cells) == long and len(named) >= max(1, 0.5 * len(cells)) and not is_data(named):
                return number
    for number in range(len(rows), 0, -1):  # shorter than the rows, but nearest to them
        named = [cell for cell in rows[number - 1] if cell]
        if len(named) > 1 and len(named) >= 0.5 * width and not is_data(named):
            return number
    return 0


def _filled(row: Sequence[str]) -> list[str]:
    """Return the cells up to the last that is not empty."""
    return list(row[:max((place for place, cell in enumerate(row, 1) if cell), default=0)])


def _uncommented(row: Sequence[str]) -> list[str]:
    cells = list(row)
    for mark in _COMMENTS:
        if cells and cells[0].startswith(mark):
            cells[0] = cells[0][len(mark):].strip()
    return cells


def _are_units(row: Sequence[str]) -> bool:
    given = [cell.strip('[]() ') for cell in row if cell.strip('[]() ')]
    units = sum(parsed_unit(cell) is not None for cell in given)
    return bool(given) and units >= max(1, 0.5 * len(given))


def _names(row: Sequence[str], width: int) -> tuple[str, ...]:
    cells = [cell[:LONGEST_NAME] for cell in _uncommented(row)[:width]]
    cells += [''] * (width - len(cells))
    return tuple(cell or f'column {place}' for place, cell in enumerate(cells, 1))


def _padded(row: Sequence[str], width: int) -> tuple[str, ...]:
    return (*(cell[:LONGEST_NAME] for cell in row[:width]), *[''] * (width - len(row)))


def _decimal(rows: Sequence[Sequence[str]], delimiter: str, source: str) -> str:
    """
    Return the decimal sign; RecordError where numbers like 1,234 may be either.

    Where commas do not separate cells and no number has a point, they are decimal signs, unless
    whole numbers without one stand in the same column.
    """
    if delimiter == ',' and not any(',' in cell for row in rows for cell in row):
        return '.'
    comma = point = 0
    grouped: dict[int, str] = {}
    whole: set[int] = set()
    for row in rows:
        for place, cell in enumerate(row):
            if not _NUMBER.fullmatch(cell):
                continue
            last_comma, last_point = cell.rfind(','), cell.rfind('.')
            if _GROUPED.fullmatch(cell):
                grouped.setdefault(place, cell)
            elif last_comma > last_point and cell.count(',') == 1:
                comma += 1
            elif last_point > last_comma and cell.count('.') == 1:
                point += 1
            elif _WHOLE.fullmatch(cell):
                whole.add(place)
    if comma or point or not grouped or delimiter == ',':
        return ',' if comma > point else '.'
    if whole & set(grouped):
        cell = grouped[min(whole & set(grouped))]
        raise RecordError(f'{source}: {cell!r} has a comma for decimals or for thousands; say '
                          'which in the mapping, as in file: {decimal: ","} or file: {decimal: '
                          '".", thousands: ","}')
    return ','


def _thousands(rows: Sequence[Sequence[str]], delimiter: str, decimal: str) -> str | None:
    """Return the sign between thousands, where a cell has both it and others prove it."""
    other = '.' if decimal == ',' else ','
    if delimiter == other and not any(other in cell for row in rows for cell in row):
        return None
    for sign in (other, ' ', '\u00a0', "'"):
        grouped = re.compile(
            rf'[-+]?\d{{1,3}}({re.escape(sign)}\d{{3}})+(?P<rest>{re.escape(decimal)}\d*)?')
        for row in rows:
            for cell in row:
                match = grouped.fullmatch(cell)
                # '20.000' alone may be 20: more groups, or decimals behind, settle it
                if match and (match['rest'] is not None or cell.count(sign) > 1):
                    return sign
    return None
