# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The paper's step test over real ROS 2 topics.

Starts the positioner and the fake controller as two processes, lets the controller play
0 → 0.4524 → 0 → 0.4524 mA in real time and record what it hears, and prints the paper's Table III
beside the same indices of that record.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
import os
from pathlib import Path
import signal
import subprocess
import sys
from typing import IO

from ..paper.comparison import comparison
from ..paper.printed import table_3
from ..paper.step_test import DURATION, DWELL, levels, upward_steps
from ..paper.step_test_figure import draw_step_test
from ..records import Record, RecordError, read_record
from ..surroundings import INTERRUPTED
from .interruption import kept_interruption
from .path_argument import given_path
from .ros_domain import claim_domain
from .telling import complain

TICKS_PER_SECOND = 200
"""Rate of the positioner: at the default 100 Hz the wait for a tick is up to 1.9 % of the ISE."""

LONGEST_DELAY = 0.1
"""Longest delay of a response, s: usually 0.06 s; a later one was held up on its way."""

GLANCE = 0.5
"""Time from one look for an interruption to the next, s."""

PATIENCE = 10.0
"""How long a process may take to end when it is told to, s."""


class DemoError(Exception):
    """The demo cannot go on; the message is one sentence for the user."""


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
            record = play_step_test(out)
            report(record, out / 'step_test.png')
        except (DemoError, RecordError, OSError, RuntimeError, ValueError) as error:
            complain('demo', error)
            return 2
        except KeyboardInterrupt:
            complain('demo', 'interrupted')
            return INTERRUPTED
    return 0


def play_step_test(out: Path) -> Record:
    """Let the two nodes play the test, and return what the controller recorded."""
    log = out / 'positioner.log'
    with own_domain(os.environ) as environment, log.open('w') as sink:
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
        rate = {'publish_rate': float(TICKS_PER_SECOND)}
        with (
            running('positioner', rate, environment, sink),
            running('fake_controller', settings, environment) as controller,
        ):
            status = ended(controller)
    if status != 0:
        raise DemoError(f'the fake controller ended with status {status}; see also {log}')
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


@contextmanager
def running(
    name: str,
    parameters: Mapping[str, object],
    environment: Mapping[str, str],
    sink: IO[str] | None = None,
) -> Iterator[subprocess.Popen[bytes]]:
    """Run one of the package's nodes in a process of its own, and end it at the end."""
    command = [sys.executable, '-m', 'booster_ros', name, '--ros-args']
    for parameter, value in parameters.items():
        command += ['-p', f'{parameter}:={value}']
    process = subprocess.Popen(command, env=environment, stdout=sink, stderr=sink)
    try:
        yield process
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
        try:
            process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def ended(process: subprocess.Popen[bytes]) -> int:
    """
    Return the exit status of a process once it has ended.

    KeyboardInterrupt comes out even where the signal was delivered to a thread of a library: that
    does not wake a wait without end.
    """
    with kept_interruption() as check:
        while True:
            try:
                return process.wait(GLANCE)
            except subprocess.TimeoutExpired:
                check()


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
