# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The paper's printed tables, as data/*.csv hold them."""

from __future__ import annotations

import csv
from importlib import resources
from typing import NamedTuple


class PrintedIndex(NamedTuple):
    """One row of Table III: what the paper measured, and what its own model gave."""

    unit: str
    measured: float
    simulated: float


def table_3() -> dict[str, PrintedIndex]:
    """Return the rows of Table III by the names of `indices.StepIndices`."""
    text = (resources.files('booster_ros.paper') / 'data' / 'table_3_indices.csv').read_text()
    return {
        row['indicator']: PrintedIndex(row['unit'], float(row['measured']), float(row['simulated']))
        for row in csv.DictReader(text.splitlines())
    }
