# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tables with one row for each value (tag, time, value), as historians export them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from booster_ros.records.collecting import Clock, Collected
from booster_ros.records.guarded import check_count
from booster_ros.records.mapping import FileMapping
from booster_ros.records.missing import is_good, noted, numbers
from booster_ros.records.reading import Reading, reading
from booster_ros.records.record import Array, Defect, RecordError
from booster_ros.records.table import Table


def pivoted(table: Table, mapping: FileMapping, travel: float | None
            ) -> tuple[Collected, dict[str, Reading]]:
    """
    Return a long table with one column for each tag that the mapping names, and how each is read.

    A row of the result is a time at which any of them has a value; the others are missing there.
    """
    assert mapping.long is not None
    where = f'{mapping.source}, long'
    tag_place = table.place(mapping.long.tag, f'{where}.tag')
    value_place = table.place(mapping.long.value, f'{where}.value')
    quality = [(one, table.place(one.column, f'{mapping.source}, quality'))
               for one in mapping.quality]
    readings = {name: reading(name, one, str(one.source), '', travel,
                              f'{mapping.source}, columns.{name}')
                for name, one in mapping.columns.items()}
    tags = {name: str(one.source) for name, one in mapping.columns.items()}
    clock = Clock(table, mapping)
    if not clock.places:
        raise RecordError(f'{mapping.source}, time: a long table needs its columns')
    wanted = {tag_place, value_place, *clock.places, *(place for _, place in quality)}
    texts = {tag_place, *clock.texts, *(place for _, place in quality)}
    kept: list[Array] = []
    owners: list[Array] = []
    values: list[Array] = []
    defects: list[Defect] = []
    names, count = list(tags), 0
    seen: set[str] = set()
    for portion in table.portions(texts, wanted):
        tag = portion.frame[tag_place].astype('str').str.strip()
        seen |= set(tag.unique().tolist()) if len(seen) < 1000 else set()
        owner = np.full(len(tag), -1)
        for number, name in enumerate(names):
            owner[np.asarray(tag == tags[name], dtype=bool)] = number
        ours = owner >= 0
        count += int(ours.sum()) * (len(names) + 1)
        check_count(count, table.source)
        clock.add(type(portion)(portion.rows[ours], portion.frame[ours]))
        found, coded = numbers(portion.frame[value_place][ours], mapping.missing,
                               portion.rows[ours], f'{table.source}, column '
                               f'{table.names[value_place]!r}')
        bad = np.zeros(int(ours.sum()), dtype=bool)
        for one, place in quality:
            bad |= ~is_good(portion.frame[place][ours], one.good)
        found[bad] = np.nan
        defects += noted('bad_quality', '', bad, portion.rows[ours], 'of bad quality, not used')
        defects += noted('missing_mark', '', coded, portion.rows[ours],
                         'that mean none, as the mapping says: missing')
        kept.append(portion.rows[ours])
        owners.append(owner[ours])
        values.append(found)
    if not kept or not sum(map(len, kept)):
        listed = ', '.join(map(repr, sorted(seen)[:20]))
        raise RecordError(f'{mapping.source}, columns: {table.source} has none of the tags '
                          f'{", ".join(map(repr, tags.values()))}; it has {listed}')
    time, told = clock.seconds()
    assert time is not None
    flat = _Flat(np.concatenate(kept), time, np.concatenate(owners), np.concatenate(values))
    rows, stamps, columns = flat.wide(names)
    _check_all_there(columns, tags, table.source, mapping.source)
    return Collected(rows, stamps, 'UTC', columns, [*defects, *told, Defect(
        'pivoted', '', 0, 0, len(rows), f'one row for each value: {len(names)} tags on the '
        f'{len(rows)} times at which any of them has one')]), readings


class _Flat:
    """The values of all tags, one after the other: row, time, owner, value."""

    def __init__(self, rows: Array, time: Array, owner: Array, value: Array):
        order = np.argsort(time, kind='stable')
        self._rows, self._time = rows[order], time[order]
        self._owner, self._value = owner[order], value[order]

    def wide(self, names: list[str]) -> tuple[Array, Array, dict[str, Array]]:
        """Return for each time at which there is a value its first row, the time, the columns."""
        known = np.isfinite(self._time)
        stamps, first, place = np.unique(
            self._time[known], return_index=True, return_inverse=True)
        columns = {}
        for number, name in enumerate(names):
            own = self._owner[known] == number
            column = np.full(len(stamps), np.nan)
            column[place[own]] = self._value[known][own]  # of two at one time the last
            columns[name] = column
        rows = self._rows[known][first]
        # rows of a tag each follow one another: what identifies a row has to be unique
        return (rows if len(np.unique(rows)) == len(rows) else np.arange(1, len(rows) + 1),
                stamps, columns)


def _check_all_there(
    columns: Mapping[str, Array], tags: Mapping[str, str], source: str, mapping: str
) -> None:
    for name, values in columns.items():
        if not np.isfinite(values).any():
            raise RecordError(f'{mapping}, columns.{name}: {source} has no value of tag '
                              f'{tags[name]!r}')
