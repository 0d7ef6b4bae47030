# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Look at a file of others: what it holds, and the mapping that most likely reads it."""

from __future__ import annotations

from dataclasses import dataclass, replace
import os
import re

import numpy as np

from booster_ros.records.collecting import Clock
from booster_ros.records.column_summary import Summary, summaries
from booster_ros.records.guess_columns import (
    Guess, good_values, guessed_columns, has_bad, is_quality)
from booster_ros.records.guess_time import GuessedTime, guessed_time
from booster_ros.records.mapping import ASKED, FileMapping, Layout, LongTable, Quality
from booster_ros.records.missing import NO_VALUE
from booster_ros.records.open_table import open_table
from booster_ros.records.record import COLUMNS, Array, RecordError
from booster_ros.records.table import Table
from booster_ros.records.time_order import in_order

_MOSTLY_EMPTY = 0.4
_MOST_TAGS = 2000


@dataclass(frozen=True)
class Inspection:
    """What a file holds, what each column is taken for, and the mapping that follows."""

    table: Table
    columns: list[Summary]
    more: bool
    time: GuessedTime
    guesses: list[Guess]
    mapping: FileMapping
    seconds: Array | None
    notes: tuple[str, ...]
    asked: tuple[str, ...]


def inspect(path: str | os.PathLike[str], layout: Layout | None = None) -> Inspection:
    """Return what a file holds; RecordError where it is no table that can be read."""
    table = open_table(path, layout or Layout())
    columns, more = summaries(table)
    if not any(one.rows for one in columns):
        raise RecordError(f'{os.fspath(path)} has no rows of data')
    time = guessed_time(columns, table.preamble)
    long = _long(columns, time)
    if long is not None:
        columns = _of_tags(table, columns, long)
    quality = [] if long else [one for one in columns
                               if is_quality(one) and one.place not in time.places]
    taken = {*time.places, *(one.place for one in quality)}
    guesses = guessed_columns(columns, taken)
    mapping = FileMapping(
        source='the mapping', columns={one.column: one.mapping for one in guesses},
        time=time.mapping, missing=_missing(columns, guesses, long is not None),
        quality=_qualities(quality, guesses), long=long, layout=_told(table.layout),
        held=() if long else _held(columns, guesses))
    seconds, mapping, notes = _clock(table, mapping)
    asked = [] if not time.asked else [f'time: {time.asked}']
    asked += [f'columns.{one.column}.{what}' for one in guesses for what in one.asked]
    if mapping.time is not None and mapping.time.zone == ASKED:
        asked.append('time.zone: the clock was changed by an hour; in which zone did it hang?')
    return Inspection(table, columns, more, time, guesses, mapping, seconds, tuple(notes),
                      tuple(asked))


def _told(layout: Layout) -> Layout:
    """Return what of a layout is worth writing: what a plain CSV does not have."""
    plain = Layout('utf-8', ',', '.', None, 1, 2, None)
    return Layout(**{name: None if value in (getattr(plain, name), 'utf-8-sig') else value
                     for name, value in layout.__dict__.items()})


def _missing(columns: list[Summary], guesses: list[Guess], is_long: bool) -> tuple[object, ...]:
    """Return the words and numbers in the columns used that stand for no value."""
    used = {one.mapping.source for one in guesses}
    found: list[object] = []
    for one in columns:
        if one.reference in used or is_long:
            found += [word for word in one.words if word != '…' and word.lower() not in NO_VALUE]
            found += [int(value) if value.is_integer() and abs(value) < 1e12 else value
                      for value in one.sentinels]
    return tuple(dict.fromkeys(found))


def _qualities(quality: list[Summary], guesses: list[Guess]) -> tuple[Quality, ...]:
    """Return which column says of which others how good they are."""
    found = []
    for one in quality:
        good = good_values(one)
        stem = re.sub(r'(?i)[_\s.]*(quality|status|valid|q)$', '', one.name).lower()
        of = tuple(guess.column for guess in guesses
                   if stem and str(guess.mapping.source).lower() == stem)
        part = re.fullmatch(r'(?i)b(op|pv|sp|aut)ofl', one.name)
        if part:
            column = {'op': 'set_point', 'pv': 'process_value', 'sp': 'process_set_point'}.get(
                part[1].lower())
            of = tuple(guess.column for guess in guesses if guess.column == column)
            if not of:
                continue
        if has_bad(one, good) or of:
            found.append(Quality(one.reference, tuple(good), of))
    return tuple(found)


def _held(columns: list[Summary], guesses: list[Guess]) -> tuple[str, ...]:
    """Return the columns that are stored by exception: most rows have no value, and others do."""
    used = {one.mapping.source: one.column for one in guesses}
    sparse = [one for one in columns if one.reference in used
              and one.rows and 2 < one.count < (1.0 - _MOSTLY_EMPTY) * one.rows]
    return tuple(used[one.reference] for one in sparse)


def _long(columns: list[Summary], time: GuessedTime) -> LongTable | None:
    """Return which columns hold tag and value, where a table has a row for each value."""
    others = [one for one in columns if one.place not in time.places]
    tags = [one for one in others if one.is_text and 0 < len(one.words) <= 50
            and '…' not in one.words and re.search(
                r'(?i)tag|name|point|sensor|channel|signal|variable|item|object', one.name)]
    values = [one for one in others if one.is_number
              and re.search(r'(?i)^(value|val|wert|reading|measurement|data)\b', one.name)]
    if len(tags) != 1 or len(values) != 1 or not time.places:
        return None
    return LongTable(tags[0].reference, values[0].reference)


def _of_tags(table: Table, columns: list[Summary], long: LongTable) -> list[Summary]:
    """Return a summary of each tag of a long table, as of a column."""
    import pandas as pd

    tag, value = (table.place(one, 'long') for one in (long.tag, long.value))
    words = columns[value].words
    parts: dict[str, list[Array]] = {}
    for portion in table.portions({tag}, {tag, value}):
        names = portion.frame[tag].astype('str').str.strip()
        numbers = pd.to_numeric(portion.frame[value], errors='coerce')
        for name, own in numbers.groupby(names.to_numpy()):
            if name in parts or len(parts) < _MOST_TAGS:
                parts.setdefault(str(name), []).append(np.asarray(own, dtype=float))
    found = []
    for place, (name, own) in enumerate(parts.items(), len(columns)):
        one = Summary(place, name, '', '', name, numbers=np.concatenate(own))
        one.rows = len(one.numbers)
        one.sentinels = columns[value].sentinels
        found.append(one)
    if found:
        found[0].words = words
    return found


def _clock(table: Table, mapping: FileMapping) -> tuple[Array | None, FileMapping, list[str]]:
    """Return the times, s, as far as they can be read; the mapping with runs and zone; notes."""
    given = mapping.time
    if given is None or ASKED in (given.unit, given.format):
        return None, mapping, []
    try:
        clock = Clock(table, mapping)
        rows: list[Array] = []
        for portion in table.portions(clock.texts, clock.places or [0]):
            clock.add(portion)
            rows.append(portion.rows)
        time, told = clock.seconds()
    except RecordError as error:
        return None, mapping, [str(error)]
    if time is None:
        return None, mapping, []
    notes = [str(one) for one in told]
    if mapping.long:
        return time, mapping, notes
    every = np.concatenate(rows)
    try:
        ordered = in_order(time, every, None, 'time')
    except RecordError:  # the clock went back by an hour
        mapping = replace(mapping, time=replace(given, zone=ASKED))
        ordered = in_order(time, every, 'Europe/Berlin', 'time')
    else:
        if _goes_forward(ordered.time, ordered.runs):
            mapping = replace(mapping, time=replace(given, zone=ASKED))
    notes += [str(one) for one in ordered.defects]
    runs = [run for run in ordered.runs if run.size]
    if len(runs) > 1:
        longest = max(range(len(runs)), key=lambda k: len(runs[k]))
        mapping = replace(mapping, run=longest + 1)
        notes.append(f'{len(runs)} runs, each a record of its own: ' + ', '.join(
            f'{number} of {len(run)} rows from row {every[run].min()} on'
            for number, run in enumerate(runs[:12], 1)) + f'; the mapping takes {longest + 1}')
    chosen = mapping.run if isinstance(mapping.run, int) else 1
    return (ordered.time[runs[chosen - 1]] if runs else time), mapping, notes


def _goes_forward(time: Array, runs: list[Array]) -> bool:
    """Tell whether one step is an hour longer than usual to within half of what is usual."""
    for run in runs:
        steps = np.diff(time[run])
        usual = float(np.median(steps)) if steps.size else 0.0
        if 0.0 < usual < 900.0 and 0 < np.count_nonzero(
                np.abs(steps - 3600.0 - usual) < 0.5 * usual) <= 2:
            return True
    return False


def is_plain(found: Inspection) -> bool:
    """Tell whether a file needs no mapping: names, units and time are a record's own."""
    return (found.table.kind == 'text' and not found.asked and not found.mapping.missing
            and not found.mapping.quality and not found.mapping.held and found.mapping.run is None
            and found.mapping.long is None and found.table.layout.header == 1
            and found.table.layout.first == 2 and found.table.layout.thousands is None
            and str(found.table.layout.encoding).startswith('utf-8')
            and all(name == one.source and one.unit == COLUMNS[name].unit
                    for name, one in found.mapping.columns.items() if name in COLUMNS)
            and (found.mapping.time is None or (
                found.mapping.time.unit == 's' and found.mapping.time.columns == ('time',))))
