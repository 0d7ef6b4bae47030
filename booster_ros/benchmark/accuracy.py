# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
How far the solver is from the reference, and how fast, over its tolerance.

    python -m booster_ros.benchmark.accuracy

prints the table of docs/accuracy.md.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
import sys
import time
from typing import NamedTuple

import numpy as np

from ..model.simulation import simulate
from ..programs.compiling import announce_compilation
from .cases import Case, paper_test, stick_slip
from .reference import reference

TOLERANCES = (10.0, 1.0, 0.1, 0.01)

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


def main(args: Sequence[str] | None = None) -> int:
    """Measure and print; return the exit status."""
    parser = argparse.ArgumentParser(
        prog='accuracy',
        description="Measure the error of the solver against scipy's Radau over the paper's "
        'step test and over a record with stick-slip. Takes some minutes, most of them for the '
        'reference.',
    )
    parser.add_argument(
        '--rtol', type=float, default=1e-10,
        help='relative tolerance of the reference (default: %(default)g)')
    rtol: float = parser.parse_args(args).rtol
    if not 1e-13 < rtol < 1e-2:
        print(f'accuracy: --rtol must be between 1e-13 and 1e-2, got {rtol:g}', file=sys.stderr)
        return 2
    announce_compilation()
    print(table_head())
    for case in (paper_test(), stick_slip()):
        print(f'{case.name}: computing the reference ...', file=sys.stderr, flush=True)
        for row in measure(case, reference(case, rtol), TOLERANCES):
            print(table_row(case, row), flush=True)
    return 0


def table_head() -> str:
    """Return the head of the table (Markdown)."""
    return (
        '| run | tolerance | pressure RMS, Pa | max, Pa | position RMS, µm | max, µm | speed |\n'
        '|---|---|---|---|---|---|---|'
    )


def table_row(case: Case, row: Accuracy) -> str:
    """Return a row of the table (Markdown)."""
    return (
        f'| {case.name} | {row.tolerance:g} | {row.pressure_rms:.2f} | {row.pressure_max:.1f} | '
        f'{1e6 * row.position_rms:.3f} | {1e6 * row.position_max:.2f} | {row.speed:.0f} × |'
    )


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


if __name__ == '__main__':
    sys.exit(main())
