# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
What says how a file of others is to be read: a mapping, as `inspect` writes it and people mend it.

A question mark stands where the file does not say something and somebody has to.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
import difflib
import os
from pathlib import Path
import stat
from typing import Any, TypeVar

import yaml

from booster_ros.records.record import COLUMNS, FURTHER, RecordError

ASKED = '?'
"""What stands in a mapping for an answer that the file does not give."""

TRAVEL = 'travel'
_LARGEST_FILE = 1 << 20

Name = str | int
"""A column of a file: by its name, or by its place, the first being 1."""


@dataclass(frozen=True)
class Layout:
    """How a text file, or a sheet, is laid out; None where that is to be found out."""

    encoding: str | None = None
    delimiter: str | None = None
    decimal: str | None = None
    thousands: str | None = None
    header: int | None = None
    first: int | None = None
    sheet: str | None = None


@dataclass(frozen=True)
class TimeMapping:
    """
    Where the time of a row stands and how it is written.

    Either `columns`, with a unit (numbers) or a format (text), or `every`, the time from row to
    row. `zone` is that of the clock on the wall; `stamps` is for bags.
    """

    columns: tuple[Name, ...] = ()
    unit: str | None = None
    format: str | None = None
    zone: str | None = None
    every: str | None = None
    stamps: str | None = None


@dataclass(frozen=True)
class ColumnMapping:
    """Which column of the file one of a record is, and what its numbers mean."""

    source: Name
    unit: str | None = None
    of: object = None
    gauge: bool | str | None = None


@dataclass(frozen=True)
class Quality:
    """A column of the file that says which rows are good, and for which columns of the record."""

    column: Name
    good: tuple[object, ...]
    of: tuple[str, ...] = ()


@dataclass(frozen=True)
class LongTable:
    """The columns of a table that has one row for each value: its name and its value."""

    tag: Name
    value: Name


@dataclass(frozen=True)
class FileMapping:
    """
    A mapping from a file to a record.

    `columns` goes from names of a record to columns of the file. `held` are stored by exception: a
    value holds until the next one. `run` says which of several runs in one file is meant.
    """

    source: str
    columns: Mapping[str, ColumnMapping]
    time: TimeMapping | None = None
    missing: tuple[object, ...] = ()
    quality: tuple[Quality, ...] = ()
    held: tuple[str, ...] = ()
    long: LongTable | None = None
    run: int | str | None = None
    travel: str | None = None
    layout: Layout = field(default_factory=Layout)


def read_mapping(path: str | os.PathLike[str]) -> FileMapping:
    """Return the mapping in a YAML file; RecordError in one sentence where it is none."""
    source = os.fspath(path)
    try:
        if not stat.S_ISREG(os.stat(path).st_mode):
            raise RecordError(f'{source}: is no file')
        if os.stat(path).st_size > _LARGEST_FILE:
            raise RecordError(f'{source}: is larger than 1 MB, which no mapping is')
        text = Path(path).read_text(encoding='utf-8')
        events = list(yaml.parse(text, Loader=yaml.SafeLoader))
        if any(isinstance(event, yaml.AliasEvent) for event in events):
            raise RecordError(f'{source}: a mapping has no aliases')
        content = yaml.safe_load(text)
    except OSError as error:
        raise RecordError(f'{source}: {error.strerror}') from None
    except (yaml.YAMLError, UnicodeDecodeError, RecursionError, ValueError) as error:
        if isinstance(error, RecordError):
            raise
        raise RecordError(f'{source} is not YAML: {" ".join(str(error).split())[:200]}') from None
    return mapping_of(content, source)


def mapping_of(content: object, source: str) -> FileMapping:
    """Return the mapping that loaded YAML holds; RecordError where it holds something else."""
    given = _table(content, source, {
        'file', 'time', 'columns', 'missing', 'quality', 'held', 'long', 'run', 'travel'})
    columns = {}
    for name, one in _table(given.get('columns') or {}, f'{source}, columns').items():
        _check_known(name, source)
        columns[name] = _column(one, f'{source}, columns.{name}')
    if not columns:
        raise RecordError(f'{source}: columns names no column of a record; there are '
                          f'{", ".join((*COLUMNS, *FURTHER))}')
    time = given.get('time')
    if 'time' in columns and time is None:
        time = {'columns': columns['time'].source, 'unit': columns['time'].unit}
    columns.pop('time', None)
    held = _texts(given.get('held'), f'{source}, held')
    run = given.get('run')
    if not (run is None or run == ASKED or (isinstance(run, int) and run > 0)):
        raise RecordError(f'{source}, run: {run!r} is not the number of a run')
    return FileMapping(
        source=source, columns=columns,
        time=None if time is None else _time(time, f'{source}, time'),
        missing=tuple(_list(given.get('missing'))),
        quality=tuple(_quality(one, f'{source}, quality') for one in _list(given.get('quality'))),
        held=held, run=run, travel=None if given.get('travel') is None else str(given['travel']),
        long=_long(given.get('long'), f'{source}, long'),
        layout=_layout(given.get('file') or {}, f'{source}, file'))


def _check_known(name: object, source: str) -> None:
    known = (*COLUMNS, *FURTHER)
    if name in known:
        return
    near = difflib.get_close_matches(str(name)[:60], known, n=1)
    hint = f' (is it {near[0]}?)' if near else ''
    raise RecordError(f'{source}, columns: {str(name)[:60]} is not a column of a record{hint}; '
                      f'there are {", ".join(known)}')


def _column(given: object, where: str) -> ColumnMapping:
    if isinstance(given, (str, int)) and not isinstance(given, bool):
        return ColumnMapping(given)
    table = _table(given, where, {'from', 'unit', 'of', 'gauge'})
    gauge = table.get('gauge')
    if not (gauge is None or isinstance(gauge, bool) or gauge == ASKED):
        raise RecordError(f'{where}.gauge: {gauge!r} is neither true nor false')
    return ColumnMapping(_name(table.get('from'), f'{where}.from'), _text(table, 'unit'),
                         table.get('of'), gauge)


def _time(given: object, where: str) -> TimeMapping:
    if isinstance(given, (str, int)):
        return TimeMapping((given,))
    table = _table(given, where, {'columns', 'unit', 'format', 'zone', 'every', 'stamps'})
    names = tuple(_name(one, f'{where}.columns') for one in _list(table.get('columns')))
    every, stamps = _text(table, 'every'), _text(table, 'stamps')
    if not names and every is None and stamps is None:
        raise RecordError(f'{where}: give the columns that hold the time, or every, the time from '
                          "row to row as in '10 ms'")
    if stamps not in (None, 'bag', 'header'):
        raise RecordError(f'{where}.stamps: must be bag or header, not {stamps!r}')
    return TimeMapping(names, _text(table, 'unit'), _text(table, 'format'), _text(table, 'zone'),
                       every, stamps)


def _quality(given: object, where: str) -> Quality:
    table = _table(given, where, {'column', 'good', 'of'})
    good = tuple(_list(table.get('good')))
    if not good:
        raise RecordError(f'{where}.good: say which values mean that a row is good')
    return Quality(_name(table.get('column'), f'{where}.column'), good,
                   _texts(table.get('of'), f'{where}.of'))


def _long(given: object, where: str) -> LongTable | None:
    if given is None:
        return None
    table = _table(given, where, {'tag', 'value'})
    return LongTable(_name(table.get('tag'), f'{where}.tag'),
                     _name(table.get('value'), f'{where}.value'))


def _layout(given: object, where: str) -> Layout:
    table = _table(given, where, set(Layout.__dataclass_fields__))
    for name in ('header', 'first'):
        value = table.get(name)
        if not (value is None or (isinstance(value, int) and 0 <= value < 100_000)):
            raise RecordError(f'{where}.{name}: {value!r} is not the number of a line')
    return Layout(
        encoding=_text(table, 'encoding'), delimiter=_text(table, 'delimiter'),
        decimal=_text(table, 'decimal'), thousands=_text(table, 'thousands'),
        header=table.get('header'), first=table.get('first'), sheet=_text(table, 'sheet'))


def _table(
    given: object, where: str, known: set[str] | None = None
) -> dict[str, Any]:
    if not isinstance(given, dict):
        raise RecordError(f'{where}: is not a table of names and values')
    for name in given:
        if known is not None and name not in known:
            raise RecordError(f'{where}: {str(name)[:60]!r} has no meaning there; there are '
                              f'{", ".join(sorted(known))}')
    return given


Item = TypeVar('Item')


def _list(given: Item | Sequence[Item] | None) -> list[Item]:
    if given is None:
        return []
    return list(given) if isinstance(given, (list, tuple)) else [given]  # type: ignore[list-item]


def _texts(given: object, where: str) -> tuple[str, ...]:
    names = tuple(map(str, _list(given)))
    for name in names:
        if name not in COLUMNS and name not in FURTHER:
            raise RecordError(f'{where}: {name[:60]!r} is not a column of a record')
    return names


def _name(given: object, where: str) -> Name:
    if isinstance(given, (str, int)) and not isinstance(given, bool):
        return given
    raise RecordError(f'{where}: give the name of a column of the file, or its number')


def _text(table: Mapping[str, Any], name: str) -> str | None:
    value = table.get(name)
    return None if value is None else str(value)
