# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The part of the demo in which the positioner holds its position: set point in, travel out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from ..metrics.figures import figures_of
from ..metrics.response_figure import draw_responses
from ..metrics.response_table import table_of_steps
from ..model.parameters import from_values
from ..parameters.file import read_parameter_file
from ..records import Record, read_record
from .demo_nodes import DemoError, play

LEVELS = (0.004, 0.012, 0.004)
"""Set points, m: a quarter, three quarters and a quarter of the travel."""

DWELL = 8.0
"""How long each of them stands, s: the stem has arrived after 3 s."""

AT_REST = 187.5e3
"""Chamber pressure at which the valve rests at the first set point, Pa."""


def show_closed_loop(out: Path, environment: Mapping[str, str], dwell: float = DWELL) -> None:
    """Play the set points, print the times of the responses, draw the plot, say where it is."""
    record = play_set_points(out, environment, dwell)
    plot = out / 'closed_loop.png'
    travel = from_values(read_parameter_file(shipped('closed_loop.yaml')).physical).actuator.travel
    steps = figures_of(record).steps
    print(f'\nSteps of the set point, closed loop\n\n{table_of_steps(steps, travel)}')
    draw_responses(record, steps, plot)
    print(f'\nPlot: {plot}\nRecord: {record.source}')


def play_set_points(out: Path, environment: Mapping[str, str], dwell: float) -> Record:
    """Let the fake controller play set points to the positioner, and return its record."""
    log = out / 'closed_loop.log'
    print(
        f'The positioner now holds its position, and is commanded set points for '
        f'{len(LEVELS) * dwell:.0f} s. It logs to {log}.',
        flush=True,
    )
    settings = {
        'mode': 'set_point',
        'profile': 'steps',
        'levels': list(LEVELS),
        'dwell': dwell,
        'feedback': 'stamped',
        'record_csv': str(out / 'closed_loop.csv'),
    }
    start = {'initial_state.chamber_pressure': AT_REST}
    play(settings, start, shipped('closed_loop.yaml'), environment, log)
    return read_record(out / 'closed_loop.csv')


def shipped(name: str) -> Path:
    """Return a file of `config`, of the sources or of what is installed; DemoError without it."""
    for folder in Path(__file__).resolve().parents:
        for config in (folder / 'config', folder / 'share' / 'booster_ros' / 'config'):
            if (config / name).is_file():
                return config / name
    raise DemoError(f'config/{name} is neither in the sources nor installed')
