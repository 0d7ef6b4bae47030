# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a column of others holds, seen over all rows that are looked at."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
import re
from typing import Any

import numpy as np

from booster_ros.records.mapping import Name
from booster_ros.records.missing import NO_VALUE, suspected_sentinels
from booster_ros.records.record import Array
from booster_ros.records.table import Table

MOST_ROWS = 1_000_000
"""Rows that are looked at: what a longer file holds further on is not seen."""

_SAMPLES = 400
_MOST_WORDS = 50
_RISES = 0.9


@dataclass
class Summary:
    """A column: where it stands, what it is called, its numbers, words and first texts."""

    place: int
    name: str
    unit_row: str
    label: str
    reference: Name
    rows: int = 0
    empty: int = 0
    is_date: bool = False
    numbers: Array = field(default_factory=lambda: np.empty(0))
    words: Counter[str] = field(default_factory=Counter)
    samples: list[str] = field(default_factory=list)
    sentinels: list[float] = field(default_factory=list)

    @property
    def values(self) -> Array:
        """The numbers that are values, NaN where a row has none."""
        return np.where(np.isin(self.numbers, self.sentinels), np.nan, self.numbers)

    @property
    def count(self) -> int:
        """How many rows have a value."""
        return int(np.isfinite(self.values).sum())

    @property
    def is_number(self) -> bool:
        """Whether most of what stands there are numbers."""
        return self.count > sum(self.words.values())

    @property
    def is_text(self) -> bool:
        """Whether most of what stands there is text."""
        return not self.is_date and self.count < sum(self.words.values())

    @property
    def low(self) -> float:
        """The least value, NaN without any."""
        return float(np.nanmin(self.values)) if self.count else float('nan')

    @property
    def high(self) -> float:
        """The largest value, NaN without any."""
        return float(np.nanmax(self.values)) if self.count else float('nan')

    @property
    def first(self) -> float:
        """The first value, NaN without any."""
        known = self.values[np.isfinite(self.values)]
        return float(known[0]) if known.size else float('nan')

    @property
    def step(self) -> float:
        """The usual difference from row to row."""
        known = self.values[np.isfinite(self.values)]
        return float(np.median(np.abs(np.diff(known)))) if known.size > 1 else float('nan')

    @property
    def rises(self) -> bool:
        """Whether the numbers go one way from most rows to the next."""
        steps = np.diff(self.values[np.isfinite(self.values)])
        return bool(steps.size) and max(np.mean(steps > 0.0), np.mean(steps < 0.0)) > _RISES

    @property
    def rises_like_a_clock(self) -> bool:
        """Whether the numbers rise evenly, as those of a clock or a counter."""
        steps = np.diff(self.values[np.isfinite(self.values)])
        if steps.size < 3 or np.mean(steps > 0.0) < _RISES:
            return False
        rising = steps[steps > 0.0]
        low, high = np.quantile(rising, [0.1, 0.9])
        return bool(high < 5.0 * low)


def summaries(table: Table) -> tuple[list[Summary], bool]:
    """Return what each column holds, and whether the file has more rows than were looked at."""
    once = Counter(table.names)
    found = []
    for place, name in enumerate(table.names):
        made_up = re.fullmatch(r'column \d+', name) is not None
        reference: Name = place + 1 if once[name] > 1 or made_up else name
        found.append(Summary(place, name, table.units[place], table.labels[place], reference))
    parts: list[list[Array]] = [[] for _ in found]
    seen, more = 0, False
    for portion in table.portions((), range(len(found))):
        if seen >= MOST_ROWS:
            more = True
            break
        seen += len(portion.rows)
        for one, part in zip(found, parts):
            part.append(_numbers(one, portion.frame[one.place]))
    for one, part in zip(found, parts):
        one.numbers = np.concatenate(part) if part else np.empty(0)
        one.sentinels = suspected_sentinels(one.numbers)
    return found, more


def _numbers(one: Summary, values: Any) -> Array:
    """Return the numbers of a portion, and count its words."""
    import pandas as pd

    one.rows += len(values)
    one.empty += int(values.isna().sum())
    if len(one.samples) < _SAMPLES and values.dtype.kind not in 'f':
        known = values.dropna().iloc[:_SAMPLES - len(one.samples)]
        one.samples += [str(text).strip() for text in known]
    if values.dtype.kind in 'iufb':
        return np.array(values, dtype=float)
    if values.dtype.kind == 'M':
        one.is_date = True
        return np.full(len(values), np.nan)
    text = values.astype('str').str.strip()
    blank = np.asarray(text.str.lower().isin(NO_VALUE) | values.isna(), dtype=bool)
    parsed = np.array(pd.to_numeric(text, errors='coerce'), dtype=float)
    parsed[blank] = np.nan
    words = text[np.isnan(parsed) & ~blank]
    for word, count in words.value_counts().iloc[:_MOST_WORDS].items():
        if len(one.words) < _MOST_WORDS or word in one.words:
            one.words[str(word)] += int(count)
    rest = len(words) - int(words.value_counts().iloc[:_MOST_WORDS].sum())
    if rest:
        one.words['…'] += rest
    return parsed
