# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Measure the solver against a reference solution, and print the table of docs/accuracy.md."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
import sys

from ..benchmark.accuracy import Accuracy, measure
from ..benchmark.cases import Case, paper_test, stick_slip
from ..benchmark.reference import reference
from .compiling import announce_compilation

TOLERANCES = (10.0, 1.0, 0.1, 0.01)


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


if __name__ == '__main__':
    sys.exit(main())
