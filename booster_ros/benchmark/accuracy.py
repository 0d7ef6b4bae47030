# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How far the solver is from the reference, and how fast, over its tolerance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
import time
from typing import NamedTuple

import numpy as np

from ..model.simulation import simulate
from .cases import Case

RUNS = 5
"""A speed is the best of so many runs: what disturbs can only slow down."""


class Accuracy(NamedTuple):
    """Errors of one run against the reference (Pa, m), and simulated seconds per second."""

    tolerance: float
    pressure_rms: float
    pressure_max: float
    position_rms: float
    position_max: float
    speed: float


def measure(
    case: Case, exact: Mapping[str, np.ndarray], tolerances: Sequence[float]
) -> list[Accuracy]:
    """Return the errors over the rows of a case for each tolerance (1 is the default)."""
    return [_measure(case, exact, tolerance) for tolerance in tolerances]


def _measure(case: Case, exact: Mapping[str, np.ndarray], tolerance: float) -> Accuracy:
    best = np.inf
    for _ in range(RUNS):
        start = time.perf_counter()
        run = simulate(
            case.parameters, case.time, case.control_current, case.initial, tolerance=tolerance)
        best = min(best, time.perf_counter() - start)
    pressure = run['chamber_pressure'] - exact['chamber_pressure']
    position = run['valve_position'] - exact['valve_position']
    return Accuracy(
        tolerance, _rms(pressure), float(np.abs(pressure).max()), _rms(position),
        float(np.abs(position).max()), float(np.ptp(case.time) / best))


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))
