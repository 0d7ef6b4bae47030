# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The paper's step test over real ROS 2 topics, a positioner that holds its position, and a twin.

Starts the positioner and the fake controller as two processes, lets the controller play
0 → 0.4524 → 0 → 0.4524 mA in real time and record what it hears, and prints the paper's Table III
beside the same indices of that record. Then the controller plays set points of 4, 12 and 4 mm to a
positioner with a position controller, and the times of its response are printed. Last, a valve
begins to rub, and its twin says so, has it diagnosed, and adopts what was found.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
import os
from pathlib import Path
import sys

from ..paper.comparison import comparison
from ..paper.printed import table_3
from ..paper.step_test import DURATION, DWELL, levels, upward_steps
from ..paper.step_test_figure import draw_step_test
from ..records import Record, RecordError, read_record
from ..surroundings import INTERRUPTED
from .demo_closed_loop import show_closed_loop
from .demo_nodes import DemoError, play
from .demo_twin import show_twin
from .interruption import kept_interruption
from .path_argument import given_path
from .ros_domain import claim_domain
from .telling import complain

TICKS_PER_SECOND = 200
"""Rate of the positioner: at the default 100 Hz the wait for a tick is up to 1.9 % of the ISE."""

LONGEST_DELAY = 0.1
"""Longest delay of a response, s: usually 0.06 s; a later one was held up on its way."""


def main(args: Sequence[str] | None = None) -> int:
    """Run the step test and report it; return the exit status."""
    parser = argparse.ArgumentParser(prog='demo', description=__doc__)
    parser.add_argument(
        '--out',
        type=given_path,
        default=Path('out') / 'demo',
        help='folder for the record, the plot and the log (default: %(default)s)',
    )
    out: Path = parser.parse_args(args).out
    with kept_interruption():
        try:
            out.mkdir(parents=True, exist_ok=True)
            with own_domain(os.environ) as environment:
                record = play_step_test(out, environment)
                report(record, out / 'step_test.png')
                print()
                show_closed_loop(out, environment)
            show_twin(out)
        except (DemoError, RecordError, OSError, RuntimeError, ValueError) as error:
            complain('demo', error)
            return 2
        except KeyboardInterrupt:
            complain('demo', 'interrupted')
            return INTERRUPTED
    return 0


def play_step_test(out: Path, environment: Mapping[str, str]) -> Record:
    """Let the two nodes play the test, and return what the controller recorded."""
    log = out / 'positioner.log'
    print(
        f'Two nodes in ROS domain {environment["ROS_DOMAIN_ID"]} play the step test, '
        f'{DURATION:.0f} s in real time. The positioner logs to {log}.',
        flush=True,
    )
    settings = {
        'profile': 'steps',
        'levels': levels(),
        'dwell': DWELL,
        'feedback': 'stamped',
        'record_csv': str(out / 'record.csv'),
    }
    play(settings, {'publish_rate': float(TICKS_PER_SECOND)}, None, environment, log)
    return read_record(out / 'record.csv')


@contextmanager
def own_domain(environment: Mapping[str, str]) -> Iterator[dict[str, str]]:
    """Yield the environment with a ROS domain that nobody else uses, unless it names one."""
    if 'ROS_DOMAIN_ID' in environment:
        yield dict(environment)
        return
    domain = claim_domain()
    try:
        yield {
            **environment,
            'ROS_DOMAIN_ID': str(domain.id),
            'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
        }
    finally:
        domain.release()


def report(record: Record, plot: Path) -> None:
    """Print the table, draw the plot and say where it is."""
    responses = upward_steps(
        record['time'], record['control_current'], record['chamber_pressure']
    )
    print()
    print(comparison([response.indices() for response in responses], table_3()))
    late = [response.delay() for response in responses if response.delay() > LONGEST_DELAY]
    if late:
        print(
            f'\nThis machine was busy: a response began {max(late):.2f} s after its command, not '
            '0.06 s, which adds to settling time and integral square error.'
        )
    draw_step_test(record, responses, plot)
    print(f'\nPlot: {plot}\nRecord: {record.source}')


if __name__ == '__main__':
    sys.exit(main())
