# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The paper's printed tables, as data/*.csv hold them."""

from __future__ import annotations

from collections.abc import Iterator
import csv
from importlib import resources
from typing import NamedTuple

import numpy as np

FLOW_UNIT = 1e-4
"""
Unit of Table I's flow, kg/s. The paper prints kg/s, which the booster could not pass; with this
unit the flow at the plateau is what its own largest area passes.
"""


class PrintedIndex(NamedTuple):
    """One row of Table III: what the paper measured, and what its own model gave."""

    unit: str
    measured: float
    simulated: float


class FlowSeries(NamedTuple):
    """Rows of Table I at one supply pressure: gauge Pa, and the flow as printed."""

    supply_pressure: float
    back_pressure: np.ndarray
    mass_flow: np.ndarray


def table_1() -> list[FlowSeries]:
    """Return Table I by supply pressure, the outlet open to the atmosphere."""
    rows = np.array([
        (row['supply_pressure_kPa'], row['back_pressure_kPa'], row['mass_flow_as_printed'])
        for row in _rows('table_1_booster_flow.csv')
    ], dtype=float)
    series = [rows[rows[:, 0] == supply] for supply in np.unique(rows[:, 0])]
    return [FlowSeries(float(s[0, 0]) * 1e3, s[:, 1] * 1e3, s[:, 2]) for s in series]


def table_3() -> dict[str, PrintedIndex]:
    """Return the rows of Table III by the names of `indices.StepIndices`."""
    return {
        row['indicator']: PrintedIndex(row['unit'], float(row['measured']), float(row['simulated']))
        for row in _rows('table_3_indices.csv')
    }


def _rows(name: str) -> Iterator[dict[str, str]]:
    text = (resources.files('booster_ros.paper') / 'data' / name).read_text()
    yield from csv.DictReader(text.splitlines())
