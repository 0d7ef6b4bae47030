# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A first look at a file: what is drawn of a table, of a bag and of a record."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..records.bag_inspection import BagInspection
from ..records.inspection import Inspection
from ..records.record import COLUMNS, Record
from ..report.first_look import Series, first_look
from .mapping_options import legible


def look_at_table(found: Inspection) -> str:
    """Return the page with all columns of a table."""
    series = [Series(one.name, one.values) for one in found.columns
              if one.count and one.place not in found.time.places]
    time = found.seconds
    if time is None or found.mapping.long or any(len(time) != len(one.values) for one in series):
        time = None
    return first_look(legible(Path(found.table.source).name), time, series, found.notes)


def look_at_bag(bag: BagInspection) -> str:
    """Return the page with all topics of a bag, each sample at its own time."""
    parts = bag.series()
    time = np.unique(np.concatenate([one for _, one, _ in parts])) if parts else np.empty(0)
    series = []
    for name, own, values in parts:
        column = np.full(len(time), np.nan)
        column[np.searchsorted(time, own)] = values
        series.append(Series(name, column if len(parts) > 1 else values))
    return first_look(legible(Path(bag.source).name), time, series, bag.notes)


def look_at_record(file: Path, record: Record) -> str:
    """Return the page with all columns of a record."""
    names = [name for name in (*record.columns, *record.beside) if name != 'time']
    series = [Series(f'{name}, {_unit(record, name)}', record[name]) for name in names]
    return first_look(legible(file.name), record.columns.get('time'), series, record.notes)


def _unit(record: Record, name: str) -> str:
    return record.beside[name].unit if name in record.beside else COLUMNS[name].unit
