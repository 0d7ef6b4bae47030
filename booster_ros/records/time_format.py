# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How times are written as text: the formats that fit some of them, day and month kept apart."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache
import itertools
import re

ISO = 'ISO 8601'
"""Stands for a time as in 2024-10-27T01:59:30.5+02:00, with or without T, fraction and zone."""

_DATES = (
    '%Y-%m-%d', '%Y/%m/%d', '%Y.%m.%d', '%Y%m%d', '%d.%m.%Y', '%d.%m.%y',
    '%d/%m/%Y', '%m/%d/%Y', '%d-%m-%Y', '%m-%d-%Y', '%d/%m/%y', '%m/%d/%y', '%y/%m/%d',
    '%d-%m-%y', '%m-%d-%y', '%y-%m-%d',
    '%d-%b-%Y', '%d-%b-%y', '%d %b %Y', '%d %B %Y', '%b %d %Y', '%b %d, %Y', '%d/%b/%Y',
)
_CLOCKS = (
    '%H:%M:%S', '%H:%M:%S.%f', '%H:%M:%S,%f', '%I:%M:%S %p', '%I:%M:%S.%f %p', '%H:%M',
    '%I:%M %p', '%H%M%S', '%H.%M.%S',
)
_JOINTS = (' ', 'T', ', ', '_', '  ', ' - ')
_ISO = re.compile(
    r'\d{4}-\d\d-\d\d([T ]\d\d:\d\d(:\d\d([.,]\d+)?)?\s?(Z|[+-]\d\d:?\d\d)?)?')
_FIELD = {'d': r'\d{1,2}', 'm': r'\d{1,2}', 'Y': r'\d{4}', 'y': r'\d\d', 'H': r'\d{1,2}',
          'I': r'\d{1,2}', 'M': r'\d{1,2}', 'S': r'\d{1,2}', 'f': r'\d{1,9}', 'p': r'[AaPp][Mm]',
          'b': r'[A-Za-z]{3}', 'B': r'[A-Za-z]{4,9}'}
_TWO_DIGITS = {'%Y%m%d', '%H%M%S'}
_LIMITS = {'d': (1, 31), 'm': (1, 12), 'H': (0, 24), 'I': (1, 12), 'M': (0, 59), 'S': (0, 60)}


def formats_of(texts: Sequence[str]) -> list[str]:
    """
    Return the formats by which every one of the texts is a time, the plainest first.

    More than one is left where the order of day and month, or of day and year, is not told by how
    the first text is written. What later texts rule out is not left out: a record whose first days
    are ambiguous is asked for.
    """
    sample = [text for text in texts if text]
    if not sample:
        return []
    if all(_ISO.fullmatch(text) for text in sample):
        return [ISO]
    fit = [one for one in _candidates() if _fits(one, sample[:1])]
    if any(_fits(one, sample) for one in fit):
        return fit
    return []


def fit_all(formats: Sequence[str], texts: Sequence[str]) -> list[str]:
    """Return those of the formats that fit all of the texts."""
    return [one for one in formats if _fits(one, [text for text in texts if text])]


def has_date(form: str) -> bool:
    """Tell whether a format has a date, not only the time of a day."""
    return form == ISO or any(mark in form for mark in ('%d', '%j'))


def _candidates() -> Iterator[str]:
    for date, joint, clock in itertools.product(_DATES, _JOINTS, _CLOCKS):
        yield f'{date}{joint}{clock}'
    for clock, joint, date in itertools.product(_CLOCKS, _JOINTS[:1], _DATES):
        yield f'{clock}{joint}{date}'
    yield from (clock for clock in _CLOCKS if ':' in clock)
    yield from _DATES


def _fits(form: str, texts: Sequence[str]) -> bool:
    pattern = _pattern(form)
    for text in texts:
        match = pattern.fullmatch(text)
        if match is None:
            return False
        for field, (least, most) in _LIMITS.items():
            if field in match.groupdict() and not least <= int(match[field]) <= most:
                return False
    return True


@cache
def _pattern(form: str) -> re.Pattern[str]:
    parts = re.split(r'(%[A-Za-z])', form)
    compact = any(one in form for one in _TWO_DIGITS)
    text = ''
    for part in parts:
        if part.startswith('%') and len(part) == 2:
            field = _FIELD[part[1]]
            if compact and part[1] in 'dmHMS':
                field = r'\d\d'
            text += f'(?P<{part[1]}>{field})'
        else:
            text += re.escape(part)
    return re.compile(text)
