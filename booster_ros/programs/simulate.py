# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Run the model over a table of currents or set points."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
import sys
from typing import NamedTuple

import numpy as np

from ..model.parameters import ParameterError, from_values
from ..model.loop_start import start_of_run
from ..model.stream import Stream, command_name
from ..model.system import PositionerParameters
from ..parameters.file import read_parameter_file
from ..records import (
    CsvWriter, RecordError, check_inputs_stay, csv_columns, csv_header_notes, first_row,
    iterate_csv)
from ..records.holding import last_known
from ..run_error import RunError
from .compiling import announce_compilation
from .interruption import ignore_interruptions, kept_interruption
from .path_argument import given_path
from .progress_bar import ProgressBar

INITIAL = ('chamber_pressure', 'valve_position')
PROCESS = 'pressure_drop'
"""Column that pushes the stem where the input has it."""

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


class Portion(NamedTuple):
    """Consecutive rows of the input: time (s), command (A or m) and what is pinned, by column."""

    time: np.ndarray
    command: np.ndarray
    pinned: dict[str, np.ndarray]


def main(args: Sequence[str] | None = None) -> int:
    """Simulate a file into another; return the exit status."""
    options = _parser().parse_args(args)
    try:
        with kept_interruption() as check:
            _simulate(options, check)
    except (ParameterError, RecordError, RunError) as error:
        print(f'simulate: {error}', file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print('simulate: interrupted, nothing was written', file=sys.stderr)
        return 130
    return 0


def _simulate(options: argparse.Namespace, check: Callable[[], None]) -> None:
    check_inputs_stay([options.input, options.params], [options.out], '--out')
    parameters = from_values(read_parameter_file(options.params).physical)
    _check_columns(options.input, command_name(parameters))
    for note in csv_header_notes(options.input):
        print(f'{options.input}: {note}', file=sys.stderr, flush=True)
    announce_compilation()
    run(parameters, options.input, options.out, check)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='simulate',
        description='Run the model over time and control current. Units are SI, pressures gauge.',
        epilog='IN needs the columns time (s) and control_current (A), or set_point (m) where P '
        'enables the position controller; a command stands from its row to the next. Where the '
        'first row also has chamber_pressure (Pa) and valve_position (m), the run starts where the '
        'sensors read these, else vented. A column pressure_drop (Pa) pushes the stem. OUT has '
        f'{", ".join(OUTPUT)}, and the set_point that was followed.',
    )
    add = parser.add_argument
    add('--params', type=given_path, required=True, metavar='P.yaml',
        help='a ROS 2 parameter file')
    add('--input', type=given_path, required=True, metavar='IN.csv',
        help='time and control_current or set_point')
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
    columns = _written(parameters)
    with (
        # entered first, left last: what is half written is removed before a portion is waited for
        ThreadPoolExecutor(1) as worker,
        _progress(source) as bar,
        CsvWriter(target, tuple(columns)) as writer,
    ):
        command = command_name(parameters)
        begin, first, initial = _first_row(source, command)
        state, departure = start_of_run(parameters, 0.0, first, initial)
        pushes = PROCESS in initial and parameters.actuator.plug_area != 0.0
        pinned = (PROCESS,) if pushes else ()
        # what depends on time (drift, ripple) begins where the record begins
        stream = Stream(parameters, 0.0, first, state, pinned, departure=departure)
        ahead: tuple[dict[str, np.ndarray], Future[dict[str, np.ndarray]]] | None = None
        for time, commands, held in _portions(source, command, pinned):
            # machine code needs no interpreter: meanwhile the portion before is written
            following = worker.submit(stream.advance, time - begin, commands, held)
            check()
            if ahead is not None:
                _write(*ahead, writer, columns, bar)
            # times are written as they were read
            ahead = {command: commands, 'time': time}, following
        if ahead is not None:
            _write(*ahead, writer, columns, bar)
        check()
        ignore_interruptions()  # the file is complete and gets its name


def _written(parameters: PositionerParameters) -> dict[str, str]:
    """Return `OUTPUT`, with the command where that is none of the model's outputs."""
    command = command_name(parameters)
    return {'time': 'time', command: command, **OUTPUT}


def _write(
    given: dict[str, np.ndarray], simulated: Future[dict[str, np.ndarray]], writer: CsvWriter,
    columns: dict[str, str], bar: ProgressBar,
) -> None:
    """Write a portion once it is simulated, with what was `given`."""
    seen = simulated.result() | given
    time = given['time']
    lost = ~np.isfinite(seen['chamber_pressure'])
    if lost.any():
        raise RunError('with these parameters the model has no solution from '
                       f'{time[np.argmax(lost)]:.10g} s on')
    writer.write_rows(np.column_stack([seen[name] for name in columns.values()]))
    bar.update(len(time))


def _check_columns(source: Path, command: str) -> None:
    """Raise RecordError where a column is missing, before anything is compiled."""
    known = csv_columns(source)
    for name in ('time', command):
        if name not in known:
            raise RecordError(f'{source}, row 1: there is no column {name}{_hint(command, known)}')


def _hint(command: str, known: tuple[str, ...]) -> str:
    """Return what to do where the table has the other kind of command."""
    if command == 'control_current' and 'set_point' in known:
        return '; a set_point needs position_controller.enabled: true in the parameters'
    if command == 'set_point' and 'control_current' in known:
        return '; a control_current needs position_controller.enabled: false in the parameters'
    return ''


def _portions(source: Path, command: str, pinned: tuple[str, ...]) -> Iterator[Portion]:
    """Yield the rows in portions; an empty cell keeps the value before."""
    names = (command, *pinned)
    standing = np.full(len(names), np.nan)
    for chunk in iterate_csv(source, ('time', *names)):
        held = [_held(values, last)
                for values, last in zip(chunk.values[:, 1:].T, standing, strict=True)]
        standing = np.array([values[-1] for values in held])
        yield Portion(chunk.values[:, 0], held[0], dict(zip(pinned, held[1:], strict=True)))


def _first_row(source: Path, command: str) -> tuple[float, float, dict[str, float]]:
    """Return time, command and state to start from; RecordError where a value is missing."""
    given = tuple(name for name in (*INITIAL, PROCESS) if name in csv_columns(source))
    names = ('time', command, *given)
    first = first_row(source, names)
    values = dict(zip(names, first.values[0].tolist(), strict=True))
    for name, value in values.items():
        if np.isnan(value):
            optional = ', or the column must go' if name in given else ''
            raise RecordError(
                f'{source}, row {first.rows[0]}, column {name}: the first row needs one{optional}')
    return values['time'], values[command], {name: values[name] for name in given}


def _held(values: np.ndarray, standing: float) -> np.ndarray:
    """Return the values with the one before in place of NaN."""
    latest = last_known(values)
    return np.where(latest < 0, standing, values[latest])


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
