# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Mappings that need no file: of tables with a record's own names, and from the command line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
import os

from booster_ros.records.inspection import inspect
from booster_ros.records.mapping import ColumnMapping, FileMapping
from booster_ros.records.open_table import open_table
from booster_ros.records.record import COLUMNS, RecordError
from booster_ros.records.unit_in_name import named, normalised


def mapping_of_own_names(path: str | os.PathLike[str]) -> FileMapping:
    """
    Return the mapping of a table whose columns have the names of a record's.

    RecordError where none has, or where something is to be asked.
    """
    found = inspect(path)
    own = {guess.column: guess.mapping for guess in found.guesses
           if normalised(named(str(guess.mapping.source)).name) == guess.column}
    if not set(own) & set(COLUMNS):
        raise RecordError(f'{os.fspath(path)}: no column has the name of a column of a record; it '
                          f'has {", ".join(map(repr, found.table.names[:20]))}')
    return replace(found.mapping, source=os.fspath(path), columns=own)


def with_columns(
    path: str | os.PathLike[str], mapping: FileMapping | None, columns: Mapping[str, str]
) -> FileMapping:
    """
    Return a mapping with columns that were named in short, as {'valve_position': 'Travel [%]'}.

    Without one, what the file says of itself counts: time, marks for no value, quality, and the
    columns that have the names of a record's.
    """
    if mapping is None:
        found = inspect(path)
        names = found.table.names
        own = {guess.column: guess.mapping for guess in found.guesses
               if normalised(named(str(guess.mapping.source)).name) == guess.column}
        mapping = replace(found.mapping, source='--column', columns=own,
                          quality=tuple(one for one in found.mapping.quality if not one.of
                                        or set(one.of) <= {*own, *columns}))
    else:
        names = open_table(path, mapping.layout).names
    given = {name: _in_short(text, names) for name, text in columns.items()}
    return replace(mapping, columns={**mapping.columns, **given})


def _in_short(text: str, names: Sequence[str]) -> ColumnMapping:
    """Return the mapping of a column named with or without a unit that its name does not have."""
    bare = named(text)
    if text.strip() in names or not bare.unit:
        return _by_name(text.strip(), None, names)
    return _by_name(bare.name, bare.unit, names)


def _by_name(text: str, unit: str | None, names: Sequence[str]) -> ColumnMapping:
    return ColumnMapping(int(text) if text.isdecimal() and text not in names else text, unit)
