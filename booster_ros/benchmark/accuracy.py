# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
How far the solver is from the reference, and how fast, over its tolerance.

    python -m booster_ros.benchmark.accuracy

prints the numbers of docs/accuracy.md.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
import sys
import time
from typing import NamedTuple

import numpy as np

from ..model.actuator import stem_force
from ..model.simulation import simulate
from ..model.system import PositionerParameters
from ..programs.compiling import announce_compilation
from .cases import (
    ROW, STRIBECK_VELOCITY, Case, noisy_ramps, paper_test, stick_slip, yielding_ramps,
    yielding_step)
from .reference import reference

TOLERANCES = (10.0, 1.0, 0.1, 0.01)

YIELDING_TOLERANCES = (1.0, 0.1, 0.01, 1e-3)
STRICTEST = 1e-4
"""Tolerance of the runs that others are compared with where slips are chance."""

STICTION = 200.0
"""Stiction, N, of the packings that yield, beside those that have none."""

RUNS = 5
"""A speed is the best of so many runs: what disturbs can only slow down."""


class Errors(NamedTuple):
    """By how much a run differs from another one, Pa and m."""

    pressure_rms: float
    pressure_max: float
    position_rms: float
    position_max: float


class Accuracy(NamedTuple):
    """Errors of one run against the reference, and simulated seconds per second."""

    tolerance: float
    errors: Errors
    speed: float


class Slipping(NamedTuple):
    """What a run of a packing that yields comes to: its slips, and its mean friction in N."""

    slips: int
    friction: float


def main(args: Sequence[str] | None = None) -> int:
    """Measure and print; return the exit status."""
    parser = argparse.ArgumentParser(
        prog='accuracy',
        description="Measure the error of the solver against scipy's Radau over the paper's "
        'step test and over a record with stick-slip, and what packings that yield come to. Takes '
        'some minutes, most of them for the reference.',
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
        announce_reference(case)
        for row in measure(case, reference(case, rtol), TOLERANCES):
            print(table_row(case, row), flush=True)
    print(f'\n{yielding_head()}')
    for case in (yielding_ramps(STICTION), noisy_ramps(STICTION), yielding_step(STICTION),
                 yielding_ramps(0.0), yielding_step(0.0)):
        announce_reference(case)
        for line in yielding_rows(case, rtol):
            print(line, flush=True)
    return 0


def announce_reference(case: Case) -> None:
    """Say what is waited for."""
    print(f'{case.name}: computing the reference ...', file=sys.stderr, flush=True)


def table_head() -> str:
    """Return the head of the table (Markdown)."""
    return (
        '| run | tolerance | pressure RMS, Pa | max, Pa | position RMS, µm | max, µm | speed |\n'
        '|---|---|---|---|---|---|---|'
    )


def table_row(case: Case, row: Accuracy) -> str:
    """Return a row of the table (Markdown)."""
    return (
        f'| {case.name} | {row.tolerance:g} | {error_cells(row.errors)} | {row.speed:.0f} × |'
    )


def error_cells(errors: Errors) -> str:
    """Return the cells of a table that errors take, Pa and µm (Markdown)."""
    return (
        f'{errors.pressure_rms:.2f} | {errors.pressure_max:.1f} | '
        f'{1e6 * errors.position_rms:.3f} | {1e6 * errors.position_max:.2f}'
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
    return Accuracy(tolerance, differences(run.columns, exact), float(np.ptp(case.time) / best))


def differences(run: Mapping[str, np.ndarray], other: Mapping[str, np.ndarray]) -> Errors:
    """Return by how much the pressures and positions of two runs over the same rows differ."""
    pressure = run['chamber_pressure'] - other['chamber_pressure']
    position = run['valve_position'] - other['valve_position']
    return Errors(_rms(pressure), float(np.abs(pressure).max()), _rms(position),
                  float(np.abs(position).max()))


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def yielding_head() -> str:
    """Return the head of the table of packings that yield (Markdown)."""
    return (
        '| run | stiction, N | tolerance | pressure RMS, Pa | max, Pa | position RMS, µm | max, µm '
        '| slips | friction, N |\n|---|---|---|---|---|---|---|---|---|'
    )


def yielding_rows(case: Case, rtol: float) -> list[str]:
    """Return rows of that table, by tolerance, and one for the reference at `rtol`."""
    strictest, *runs = (
        simulate(case.parameters, case.time, case.control_current, case.initial,
                 tolerance=tolerance).columns
        for tolerance in (STRICTEST, *YIELDING_TOLERANCES))
    named = [(f'{tolerance:g}', run) for tolerance, run in zip(YIELDING_TOLERANCES, runs)]
    named += [(f'{STRICTEST:g}', strictest), ('Radau', reference(case, rtol))]
    rows = []
    for name, run in named:
        found = slipping(case.parameters, run)
        errors = error_cells(differences(run, strictest))
        rows.append(f'| {case.name} | {case.parameters.actuator.stiction:g} | {name} | {errors} | '
                    f'{found.slips} | {found.friction:.1f} |')
    return rows


def slipping(p: PositionerParameters, run: Mapping[str, np.ndarray]) -> Slipping:
    """
    Return how often the stem slips, and the mean force that friction balances.

    A slip begins where the stem is faster, on the way from a row to the next, than the velocity at
    which stiction fades.
    """
    fast = np.abs(np.diff(run['valve_position'])) > STRIBECK_VELOCITY * ROW
    balanced = [
        abs(stem_force(p.actuator, pressure, position, velocity, 0.0))
        for pressure, position, velocity in zip(
            run['chamber_pressure'], run['valve_position'], run['stem_velocity'])]
    return Slipping(int(np.sum(fast[1:] & ~fast[:-1])), float(np.mean(balanced)))


if __name__ == '__main__':
    sys.exit(main())
