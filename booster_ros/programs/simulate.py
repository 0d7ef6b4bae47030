# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Run the model over a table of currents."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
import sys

import numpy as np

from ..model.parameters import ParameterError, from_values
from ..model.start import start_of_readings
from ..model.stream import Stream
from ..model.system import PositionerParameters
from ..model.undefined import UNDEFINED
from ..parameters.file import read_parameter_file
from ..records import (
    CsvWriter, RecordError, check_inputs_stay, csv_columns, csv_header_notes, first_row,
    iterate_csv)
from ..records.holding import last_known
from ..run_error import RunError
from ..surroundings import INTERRUPTED
from .compiling import announce_compilation
from .interruption import ignore_interruptions, kept_interruption
from .path_argument import given_path
from .progress_bar import ProgressBar
from .telling import complain

INPUT = ('time', 'control_current')
INITIAL = ('chamber_pressure', 'valve_position')
OUTPUT = {
    'time': 'time',
    'control_current': 'control_current',
    'back_pressure': 'back_pressure',
    'supply_pressure': 'supply_pressure',
    'mass_flow': 'mass_flow',
    'chamber_pressure': 'measured_chamber_pressure',
    'valve_position': 'measured_valve_position',
}
"""Columns written, and the output of the model that each holds: as a sensor would read it."""


def main(args: Sequence[str] | None = None) -> int:
    """Simulate a file into another; return the exit status."""
    options = _parser().parse_args(args)
    with kept_interruption() as check:
        try:
            _simulate(options, check)
        except (ParameterError, RecordError, RunError) as error:
            complain('simulate', error)
            return 2
        except KeyboardInterrupt:
            complain('simulate', 'interrupted, nothing was written')
            return INTERRUPTED
    return 0


def _simulate(options: argparse.Namespace, check: Callable[[], None]) -> None:
    check_inputs_stay([options.input, options.params], [options.out], '--out')
    parameters = from_values(read_parameter_file(options.params).physical)
    _check_columns(options.input)
    for note in csv_header_notes(options.input):
        complain(str(options.input), note)
    announce_compilation()
    run(parameters, options.input, options.out, check)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='simulate',
        description='Run the model over time and control current. Units are SI, pressures gauge.',
        epilog='IN needs the columns time (s) and control_current (A); a current stands from its '
        'row to the next. Where the first row also has chamber_pressure (Pa) and valve_position '
        '(m), the run starts where the sensors read these, else vented. OUT has '
        f'{", ".join(OUTPUT)}.',
    )
    add = parser.add_argument
    add('--params', type=given_path, required=True, metavar='P.yaml',
        help='a ROS 2 parameter file')
    add('--input', type=given_path, required=True, metavar='IN.csv',
        help='time and control_current')
    add('--out', type=given_path, required=True, metavar='OUT.csv', help='file to write')
    return parser


def run(
    parameters: PositionerParameters, source: Path, target: Path, check: Callable[[], None]
) -> None:
    """
    Simulate `source` into `target` in portions, so that memory stays flat however long it is.

    RecordError where either cannot be read or written, RunError where the model has no solution.
    `target` is then left as it was, as it is where `check` raises, which is called between
    portions. Call this in `kept_interruption`.
    """
    with (
        # entered first, left last: what is half written is removed before a portion is waited for
        ThreadPoolExecutor(1) as worker,
        _progress(source) as bar,
        CsvWriter(target, tuple(OUTPUT)) as writer,
    ):
        begin, current, initial = _first_row(source)
        try:
            state, departure = start_of_readings(parameters, 0.0, current, initial)
            # what depends on time (drift, ripple) begins where the record begins
            stream = Stream(parameters, 0.0, current, state, departure=departure)
        except UNDEFINED:
            raise RunError('with these parameters the model has no state to start from') from None
        ahead: tuple[np.ndarray, Future[dict[str, np.ndarray]]] | None = None
        for time, currents in _portions(source):
            # machine code needs no interpreter: meanwhile the portion before is written
            following = worker.submit(stream.advance, time - begin, currents)
            check()
            if ahead is not None:
                _write(*ahead, writer, bar)
            ahead = time, following
        if ahead is not None:
            _write(*ahead, writer, bar)
        check()
        ignore_interruptions()  # the file is complete and gets its name


def _write(
    time: np.ndarray, simulated: Future[dict[str, np.ndarray]], writer: CsvWriter, bar: ProgressBar
) -> None:
    """Write a portion once it is simulated, its times as they were read."""
    seen = simulated.result() | {'time': time}
    lost = ~np.isfinite(seen['chamber_pressure'])
    if lost.any():
        raise RunError('with these parameters the model has no solution from '
                       f'{time[np.argmax(lost)]:.10g} s on')
    writer.write_rows(np.column_stack([seen[name] for name in OUTPUT.values()]))
    bar.update(len(time))


def _check_columns(source: Path) -> None:
    """Raise RecordError where a column is missing, before anything is compiled."""
    known = csv_columns(source)
    for name in INPUT:
        if name not in known:
            raise RecordError(f'{source}, row 1: there is no column {name}')


def _portions(source: Path) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield time and current; an empty cell keeps the current before."""
    standing = np.nan
    for chunk in iterate_csv(source, INPUT):
        current = _held(chunk.values[:, 1], standing)
        standing = float(current[-1])
        yield chunk.values[:, 0], current


def _first_row(source: Path) -> tuple[float, float, dict[str, float]]:
    """Return time, current and state to start from; RecordError where a value is missing."""
    given = tuple(name for name in INITIAL if name in csv_columns(source))
    names = INPUT + given
    first = first_row(source, names)
    values = dict(zip(names, first.values[0].tolist(), strict=True))
    for name, value in values.items():
        if np.isnan(value):
            optional = ', or the column must go' if name in INITIAL else ''
            raise RecordError(
                f'{source}, row {first.rows[0]}, column {name}: the first row needs one{optional}')
    return values['time'], values['control_current'], {name: values[name] for name in given}


def _held(current: np.ndarray, standing: float) -> np.ndarray:
    """Return the currents with the one before in place of NaN."""
    latest = last_known(current)
    return np.where(latest < 0, standing, current[latest])


def _progress(source: Path) -> ProgressBar:
    """Return a bar over the rows, silent where nobody looks at a terminal."""
    if not sys.stderr.isatty():
        return ProgressBar(disable=True)
    return ProgressBar(total=_count_lines(source) - 1, unit=' rows', unit_scale=True)


def _count_lines(source: Path) -> int:
    lines = 0
    with open(source, 'rb', buffering=0) as file:
        while block := file.read(1 << 20):
            lines += block.count(b'\n')
    return lines


if __name__ == '__main__':
    sys.exit(main())
