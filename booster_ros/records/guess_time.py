# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which columns of a table hold the time, and in what: by their names, then by what is in them."""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np

from booster_ros.records.column_summary import Summary
from booster_ros.records.conversion import parsed_unit
from booster_ros.records.csv_header import names_the_time
from booster_ros.records.mapping import ASKED, Name, TimeMapping
from booster_ros.records.time_format import ISO, fit_all, formats_of, has_date
from booster_ros.records.time_name import unit_in_time_name
from booster_ros.records.unit_in_name import normalised

_SINCE_1970 = {'s': 1.0, 'ms': 1e-3, 'us': 1e-6, 'ns': 1e-9}
_YEARS = (1e9, 4e9)
"""Seconds since 1970 in 2001 and 2096: a number between them is a date."""

_INTERVAL = re.compile(
    r'(?i)(?:sampl\w*\s*)?(?:interval|period|delta[ _]?[tx]|time[ _]?step|dt)\b'
    r'\W{0,6}([\d.,]+(?:e-?\d+)?)\s*([a-zµ]+)?')
_RATE = re.compile(
    r'(?i)(?:sampl\w*\s*(?:rate|frequency)|scan\s*rate|rate)\b\W{0,6}([\d.,]+)\s*(k?hz)\b')


class GuessedTime(NamedTuple):
    """The time of a table, the places of its columns, and why it is thought so."""

    mapping: TimeMapping | None
    places: tuple[int, ...]
    why: str
    asked: str = ''


def guessed_time(columns: list[Summary], preamble: tuple[str, ...]) -> GuessedTime:
    """Return the guess at the time of a table."""
    texts = [one for one in columns if one.is_text and formats_of(one.samples)]
    if texts:
        return _of_texts(texts)
    dates = [one for one in columns if one.is_date]
    if dates:
        return GuessedTime(TimeMapping((dates[0].reference,)), (dates[0].place,),
                           'the cells are dates')
    called = [one for one in columns if one.is_number and _is_called(one)]
    for one in called:
        if one.rises:
            return _of_numbers(one, 'by its name')
    rising = [one for one in columns if one.is_number and one.rises_like_a_clock]
    unnamed = all(re.fullmatch(r'column \d+', one.name) for one in columns)
    if rising and unnamed:
        return _of_numbers(rising[0], 'rises from row to row')
    if called:
        return _of_numbers(called[0], 'by its name')
    return _of_preamble(preamble)


def _is_called(one: Summary) -> bool:
    return names_the_time(one.name) or normalised(one.name).startswith('time')


def _of_texts(texts: list[Summary]) -> GuessedTime:
    first = texts[0]
    formats = formats_of(first.samples)
    if not has_date(formats[0]):
        dates = [one for one in texts[1:]
                 if has_date(formats_of(one.samples)[0]) and formats_of(one.samples) != [ISO]]
        pair = dates[0] if dates else None
        order = (pair, first) if pair else None
    else:
        clocks = [one for one in texts[1:] if not has_date(formats_of(one.samples)[0])]
        # a time behind a date belongs to it, where the date has none of its own
        alone = (len(first.samples[0]) == 10 if formats[0] == ISO
                 else '%H' not in formats[0] and '%I' not in formats[0])
        order = (first, clocks[0]) if clocks and alone else None
    if order:
        day, clock = order
        joined = [f'{a} {b}' for a, b in zip(day.samples, clock.samples)]
        return _of_format((day.reference, clock.reference), (day.place, clock.place), joined,
                          'date and time stand in two columns')
    return _of_format((first.reference,), (first.place,), first.samples, 'the cells are times')


def _of_format(
    names: tuple[Name, ...], places: tuple[int, ...], samples: list[str], why: str
) -> GuessedTime:
    formats = formats_of(samples)
    if len(formats) == 1:
        form = None if formats == [ISO] else formats[0]
        return GuessedTime(TimeMapping(names, None, form), places, why)
    if not formats:
        return GuessedTime(TimeMapping(names, None, ASKED), places, why,
                           f'{samples[0]!r} is in no format that is known')
    fit = fit_all(formats, samples)
    choice = ' or '.join(f'"{one}"' for one in formats[:3])
    hint = f'; only "{fit[0]}" fits the rows below' if len(fit) == 1 else ''
    return GuessedTime(TimeMapping(names, None, ASKED), places, why, f'{choice}?{hint}')


def _of_numbers(one: Summary, why: str) -> GuessedTime:
    unit = unit_in_time_name(one.name, one.unit_row)
    asked = ''
    if unit is None:
        for name, seconds in _SINCE_1970.items():
            if _YEARS[0] < abs(one.low) * seconds < _YEARS[1]:
                unit, why = name, f'{why}; {one.low:.10g} {name} since 1970 is a date of today'
                break
    if unit is None and normalised(one.name) == 'time':
        unit, why = 's', f'{why}; a column called time is in seconds'
    if unit is None:
        step = one.step
        asked = f'the unit of the time is not said; the usual step is {step:.4g}'
    return GuessedTime(TimeMapping((one.reference,), unit or ASKED), (one.place,), why, asked)


def _of_preamble(preamble: tuple[str, ...]) -> GuessedTime:
    for line in preamble:
        interval, rate = _INTERVAL.search(line), _RATE.search(line)
        try:
            if interval:
                number = float(interval[1].replace(',', '.'))
                unit = interval[2] if interval[2] and parsed_unit(interval[2]) else 's'
                if number > 0.0:
                    return GuessedTime(TimeMapping(every=f'{number:g} {unit}'), (),
                                       f'the preamble says {line.strip()[:60]!r}')
            if rate:
                number = float(rate[1].replace(',', '.'))
                number *= 1e3 if rate[2].lower() == 'khz' else 1.0
                if number > 0.0:
                    return GuessedTime(TimeMapping(every=f'{np.round(1.0 / number, 12):g} s'), (),
                                       f'the preamble says {line.strip()[:60]!r}')
        except ValueError:
            continue
    return GuessedTime(None, (), 'no column of time: rows in their order')
