# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A table of others, whatever its format: names, and rows in portions."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
import difflib
from typing import Any, NamedTuple

from booster_ros.records.mapping import Layout, Name
from booster_ros.records.record import Array, RecordError


class Portion(NamedTuple):
    """Some rows: their numbers in the file, and a pandas frame whose columns are places from 0."""

    rows: Array
    frame: Any


@dataclass(frozen=True)
class Table:
    """
    A table as it stands in a file.

    `units` and `labels` are what the file says of a column beside its name, '' where nothing.
    `portions(texts, wanted)` yields the wanted columns (places from 0), those of `texts` as text.
    """

    source: str
    kind: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    labels: tuple[str, ...]
    preamble: tuple[str, ...]
    layout: Layout
    portions: Callable[[Collection[int], Collection[int]], Iterator[Portion]]

    def place(self, name: Name, where: str) -> int:
        """Return the place, from 0, of a column; RecordError where it is not there, or twice."""
        if isinstance(name, int):
            if 0 < name <= len(self.names):
                return name - 1
            raise RecordError(f'{where}: {self.source} has no column {name}, it has '
                              f'{len(self.names)}')
        for alike in (name, name.strip(), name.strip().lower()):
            places = [place for place, other in enumerate(self.names)
                      if alike in (other, other.strip(), other.strip().lower())]
            if len(places) == 1:
                return places[0]
            if places:
                raise RecordError(f'{where}: {self.source} has {len(places)} columns {name!r}; '
                                  f'give the number of one, {places[0] + 1} for the first')
        near = difflib.get_close_matches(name[:60], self.names[:1000], n=1)
        hint = f' (is it {near[0]!r}?)' if near else ''
        listed = ', '.join(map(repr, self.names[:20]))
        raise RecordError(f'{where}: {self.source} has no column {name[:60]!r}{hint}; it has '
                          f'{listed}')
