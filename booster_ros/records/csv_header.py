# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The header of a CSV record: its columns, how cells are separated and decimals are written."""

from collections.abc import Mapping
import csv
from dataclasses import dataclass, field
import difflib
import re

from booster_ros.records.conversion import (
    Conversion, conversion, gauge_offset, parsed_unit)
from booster_ros.records.guarded import MOST_COLUMNS
from booster_ros.records.record import (
    COLUMNS, UNKNOWN_COLUMN, Defect, RecordError)

_LONGEST_NAME = 100
"""Characters of a name that may mean a column."""

_BYTE_ORDER_MARK = b'\xef\xbb\xbf'
_OTHER_ENCODINGS = {
    b'\xff\xfe': 'UTF-16',
    b'\xfe\xff': 'UTF-16',
    b'PK': 'a zip archive or spreadsheet',
    b'\x1f\x8b': 'gzip',
    b'SQLite': 'an SQLite data base; give the folder of the bag',
    b'\x89MCAP': 'an MCAP bag; its name must end in .mcap',
}
_TIME_IN_ANY_PLACE = re.compile('time.*|zeit.*|.*(time|zeit|stamp|stempel|clock)|elapsed|epoch')
_TIME_IN_FIRST_PLACE = {
    't', 'ts', 'date', 'datum', 'utc', 'unix', 'posix', 'hour', 'hours', 'minute', 'minutes',
    'second', 'seconds', 'sec', 'secs', 'millisecond', 'milliseconds', 'millis', 'msec', 'msecs',
    'ms', 'microsecond', 'microseconds', 'micros', 'usec', 'usecs', 'us', 'nanosecond',
    'nanoseconds', 'nanos', 'nsec', 'nsecs', 'ns', 'sekunde', 'sekunden', 'sek', 'temps', 'heure',
    'tiempo', 'hora', 'tempo', 'ora', 'tijd', 'tid',
}
"""Words that mean the time: anywhere in the name of a column, and only where they begin it."""


_LONGEST_NAME = 200
"""Characters of a name that are looked at."""


@dataclass(frozen=True)
class Header:
    """
    The layout of a CSV.

    `positions` maps the known columns to their place; `width` counts all columns. With a separator
    other than a comma, a comma in a number is a decimal comma. `conversions` has the columns that
    are in another unit than a record's.
    """

    positions: dict[str, int]
    width: int
    delimiter: str
    defects: tuple[Defect, ...]
    conversions: Mapping[str, Conversion] = field(default_factory=dict)

    @property
    def names(self) -> tuple[str, ...]:
        """The known columns in the order of the file."""
        return tuple(self.positions)


def read_header(line: bytes, source: str) -> Header:
    """Return the layout that the first line declares; RecordError where it declares none."""
    text = _decode(line, source).rstrip('\r\n')
    delimiter = max(',;\t', key=text.count)
    try:
        cells = next(csv.reader([text], delimiter=delimiter), [])
    except csv.Error as error:
        raise RecordError(f'{source}, row 1: the header is not CSV ({error})') from None
    if len(cells) > MOST_COLUMNS:
        raise RecordError(f'{source}, row 1: has {len(cells)} columns, more than any record')
    cells = [cell[:_LONGEST_NAME] for cell in cells]
    positions: dict[str, int] = {}
    conversions: dict[str, Conversion] = {}
    defects = []
    for place, cell in enumerate(cells):
        name, unit = _without_unit(cell)
        if name not in COLUMNS:
            defects.append(_ignored(cell, place))
            continue
        if name in positions:
            raise RecordError(f'{source}, row 1: column {name} appears twice')
        positions[name] = place
        if unit:
            conversions[name], note = _converted(name, unit, cell.strip(), source)
            defects.append(Defect('converted', name, 1, 1, 1, note))
        elif name != cell.strip():
            defects.append(Defect('renamed_column', cell.strip(), 1, 1, 1, f'read as {name}'))
    if not set(positions) - {'time'}:
        asked = ', '.join(f'{cell.strip()}{question}' for cell in cells
                          if (question := _question(cell)) and _normalised(cell) not in COLUMNS)
        raise RecordError(
            f'{source}, row 1: no known column beside time{asked and ": "}{asked}; a record has '
            f'some of {", ".join(COLUMNS)}'
        )
    if 'time' not in positions:
        _refuse_disguised_time(cells, source)
    for cell in cells:
        if 'quality' in _normalised(cell).split('_'):
            raise RecordError(f'{source}, row 1: column {cell.strip()!r} says which values are '
                              'good; a mapping has to say what good is')
    return Header(positions, len(cells), delimiter, tuple(defects), conversions)


def _decode(line: bytes, source: str) -> str:
    for start, meaning in _OTHER_ENCODINGS.items():
        if line.startswith(start):
            raise RecordError(f'{source} is not a CSV in UTF-8 but {meaning}')
    try:
        text = line.removeprefix(_BYTE_ORDER_MARK).decode()
    except UnicodeDecodeError:
        raise RecordError(f'{source}, row 1: not UTF-8; save the file as UTF-8') from None
    if '\0' in text:
        raise RecordError(f'{source}, row 1: the file is binary, not CSV')
    return text


def _quoted(cell: str) -> str:
    return repr(cell.strip()[:_LONGEST_NAME])


def _normalised(cell: str) -> str:
    return cell.strip().lower().replace(' ', '_').replace('-', '_')


def _without_unit(cell: str) -> tuple[str, str]:
    """Return the name of a column, and the unit behind it where it is not that in `COLUMNS`."""
    name = _normalised(cell)
    if len(name) > _LONGEST_NAME:
        return name, ''
    parts = re.fullmatch(r'(\w+?)_*[\[(](.*)[\])]', name)
    if parts is None or parts[1] not in COLUMNS:
        return name, ''
    unit = parts[2].strip('_')
    if unit == COLUMNS[parts[1]].unit.lower():
        return parts[1], ''
    return parts[1], re.sub(r'.*?[\[(](.*)[\])]\s*', r'\1', cell.strip()).strip()


def _converted(name: str, written: str, cell: str, source: str) -> tuple[Conversion, str]:
    """Return the conversion of a unit in the header, and the note; RecordError where it is none."""
    unit = parsed_unit(written)
    where = f'{source}, row 1, column {_quoted(cell)}'
    wanted = COLUMNS[name].unit
    if unit is None:
        raise RecordError(f'{where}: {written[:40]!r} is no unit that is known; {name} is in '
                          f'{wanted}')
    if unit.pint.check('[]'):
        raise RecordError(f'{where}: is a share, of what a mapping has to say')
    found = conversion(unit, name, where)
    note = f'converted from {unit.written} to {wanted}'
    if unit.gauge is False:
        found = found._replace(offset=found.offset + gauge_offset(False))
        note += ', absolute pressure: 101325 Pa taken off'
    return found, note


def _ignored(cell: str, place: int) -> Defect:
    label = cell.strip()[:_LONGEST_NAME] or f'number {place + 1}'
    treatment = f'not a column of a record, ignored{_question(cell)}'
    return Defect(UNKNOWN_COLUMN, label, 1, 1, 1, treatment)


def _question(cell: str) -> str:
    """Return the question whether a known column of a similar name is meant, '' without one."""
    if len(cell) > _LONGEST_NAME:
        return ''
    near = difflib.get_close_matches(_normalised(cell), COLUMNS, n=1, cutoff=0.75)
    return f' (is it {near[0]}?)' if near else ''


def _refuse_disguised_time(cells: list[str], source: str) -> None:
    """
    Refuse a time column under another name.

    Ignoring it would turn a record in time into a quasi-static sweep. The name alone is judged:
    other columns of a bench, as the number of the row or a set point, may rise as evenly.
    """
    for cell in cells:
        if names_the_time(cell):
            raise RecordError(
                f'{source}, row 1: column {_quoted(cell)} looks like the time; call it time, '
                'in seconds, or leave it out'
            )


def names_the_time(name: str) -> bool:
    """Tell whether a column has a name that means the time."""
    words = re.findall('[a-z]+', _normalised(name[:_LONGEST_NAME]))
    return bool(_TIME_IN_FIRST_PLACE & set(words[:1])) or any(
        map(_TIME_IN_ANY_PLACE.fullmatch, words))
