# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Run the model over a table of currents."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
import sys

import numpy as np

from ..model.parameters import ParameterError, from_values
from ..model.start import start_of_readings
from ..model.stream import Stream
from ..model.system import PositionerParameters
from ..parameters.file import read_parameter_file
from ..records import CsvWriter, RecordError, check_inputs_stay
from ..run_error import RunError
from .compiling import announce_compilation
from .input_rows import InputRows, input_rows
from .interruption import ignore_interruptions, kept_interruption
from .mapping_options import add_mapping_options, mapping_for
from .path_argument import given_path
from .progress_bar import ProgressBar

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
    mapping = mapping_for(options.input, options)
    source = input_rows(options.input, mapping, parameters.actuator.travel)
    for note in source.notes:
        print(f'{options.input}: {note}', file=sys.stderr, flush=True)
    announce_compilation()
    run(parameters, source, options.out, check)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='simulate',
        description='Run the model over time and control current. Units are SI, pressures gauge.',
        epilog='IN needs the columns time (s) and control_current (A), by these names or mapped; '
        'a current stands from its row to the next. Where the first row also has '
        'chamber_pressure (Pa) and valve_position (m), the run starts where the sensors read '
        'these, else vented. OUT has '
        f'{", ".join(OUTPUT)}.',
    )
    add = parser.add_argument
    add('--params', type=given_path, required=True, metavar='P.yaml',
        help='a ROS 2 parameter file')
    add('--input', type=given_path, required=True, metavar='IN.csv',
        help='time and control_current')
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
    with (
        # entered first, left last: what is half written is removed before a portion is waited for
        ThreadPoolExecutor(1) as worker,
        _progress(source) as bar,
        CsvWriter(target, tuple(OUTPUT)) as writer,
    ):
        begin, current, initial = source.first()
        state, departure = start_of_readings(parameters, 0.0, current, initial)
        # what depends on time (drift, ripple) begins where the record begins
        stream = Stream(parameters, 0.0, current, state, departure=departure)
        ahead: tuple[np.ndarray, Future[dict[str, np.ndarray]]] | None = None
        for time, currents in source.portions():
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


def _progress(source: InputRows) -> ProgressBar:
    """Return a bar over the rows, silent where nobody looks at a terminal."""
    if not sys.stderr.isatty():
        return ProgressBar(disable=True)
    return ProgressBar(total=source.count(), unit=' rows', unit_scale=True)


if __name__ == '__main__':
    sys.exit(main())
