# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Run the model over a table of currents or set points."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
import sys

import numpy as np

from ..model.parameters import ParameterError, from_values
from ..model.loop_start import start_of_run
from ..model.stream import Stream, command_name
from ..model.system import PositionerParameters
from ..model.undefined import UNDEFINED
from ..parameters.file import read_parameter_file
from ..records import CsvWriter, RecordError, check_inputs_stay
from ..run_error import RunError
from ..surroundings import INTERRUPTED
from .compiling import announce_compilation
from .input_rows import PROCESS, InputRows, input_rows
from .interruption import ignore_interruptions, kept_interruption
from .mapping_options import add_mapping_options, mapping_for
from .path_argument import given_path
from .progress_bar import ProgressBar
from .telling import complain

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
    command = command_name(parameters)
    mapping = mapping_for(options.input, options)
    source = input_rows(options.input, command, mapping, parameters.actuator.travel)
    for note in source.notes:
        complain(str(options.input), note)
    announce_compilation()
    run(parameters, source, options.out, check)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='simulate',
        description='Run the model over time and control current. Units are SI, pressures gauge.',
        epilog='IN needs the columns time (s) and control_current (A), or set_point (m) where P '
        'enables the position controller, by these names or mapped; a command stands from its row '
        'to the next. Where the first row also has chamber_pressure (Pa) and valve_position (m), '
        'the run starts where the sensors read these, else vented. A column pressure_drop (Pa) '
        f'pushes the stem. OUT has {", ".join(OUTPUT)}, and the set_point that was followed.',
    )
    add = parser.add_argument
    add('--params', type=given_path, required=True, metavar='P.yaml',
        help='a ROS 2 parameter file')
    add('--input', type=given_path, required=True, metavar='IN.csv',
        help='time and control_current or set_point')
    add('--out', type=given_path, required=True, metavar='OUT.csv', help='file to write')
    add_mapping_options(parser)
    return parser


def run(
    parameters: PositionerParameters, source: InputRows, target: Path, check: Callable[[], None]
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
        command = source.command
        begin, first, initial = source.first()
        pushes = PROCESS in initial and parameters.actuator.plug_area != 0.0
        pinned = (PROCESS,) if pushes else ()
        try:
            state, departure = start_of_run(parameters, 0.0, first, initial)
            # what depends on time (drift, ripple) begins where the record begins
            stream = Stream(parameters, 0.0, first, state, pinned, departure=departure)
        except UNDEFINED:
            raise RunError('with these parameters the model has no state to start from') from None
        ahead: tuple[dict[str, np.ndarray], Future[dict[str, np.ndarray]]] | None = None
        for time, commands, held in source.portions(pinned):
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


def _progress(source: InputRows) -> ProgressBar:
    """Return a bar over the rows, silent where nobody looks at a terminal."""
    if not sys.stderr.isatty():
        return ProgressBar(disable=True)
    return ProgressBar(total=source.count(), unit=' rows', unit_scale=True)


if __name__ == '__main__':
    sys.exit(main())
