# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""`python -m booster_ros NAME …` and the installed executables: load a program and start it."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from importlib import import_module
import sys

from .legible import legible
from .surroundings import (
    INTERRUPTED, EndAtOnce, complaint_on_output, ignore_signals, open_streams,
    working_folder_is_there)

# Name → (module with `main(args) -> int`, what it does). setup.py installs the same names.
PROGRAMS = {
    'positioner': ('booster_ros.nodes.positioner', 'the node: a simulated valve positioner'),
    'fake_controller': (
        'booster_ros.nodes.fake_controller',
        'a node that plays a current profile or closes the position loop, and can record',
    ),
    'twin': (
        'booster_ros.nodes.twin',
        'a node that runs the model beside a real valve and says when the valve has changed',
    ),
    'simulate': (
        'booster_ros.programs.simulate', 'run the model over a table of currents or set points'),
    'inspect': (
        'booster_ros.programs.inspect',
        "say what a logger's file holds, and write a mapping that tells how it is read",
    ),
    'close_loop': (
        'booster_ros.programs.close_loop',
        'say what the model lacks, judged by a record, and write the model that has it',
    ),
    'fleet': (
        'booster_ros.programs.fleet',
        'run close_loop over the valves of a plant, and say which need attention'),
    'metrics': (
        'booster_ros.programs.metrics',
        'step response, dead band and hunting of a valve, from set point and position',
    ),
    'paper': ('booster_ros.programs.paper', "reproduce the paper's tables and identification"),
    'demo': (
        'booster_ros.programs.demo',
        "the paper's step responses and a position that is held, over real topics, with plots",
    ),
    'campaign': (
        'booster_ros.programs.campaign',
        'judge close_loop on sets of records whose truth is known, and compare two states of it',
    ),
}


def usage() -> str:
    """Return the list of programs."""
    width = max(map(len, PROGRAMS))
    lines = [f'  {name:{width}}  {purpose}' for name, (_, purpose) in PROGRAMS.items()]
    head = 'usage: python -m booster_ros NAME [ARGUMENTS]\n\nprograms (each knows --help):'
    return '\n'.join([head, *lines])


def main(args: list[str] | None = None) -> int:
    """Start the named program with the remaining arguments and return its exit status."""
    args = sys.argv[1:] if args is None else args
    if args and args[0] in ('-h', '--help'):
        print(usage())
        return 0
    if not args:
        print(usage(), file=sys.stderr)
        return 2
    name, *rest = args
    if name not in PROGRAMS:
        known = ', '.join(PROGRAMS)
        print(f"booster_ros: no program is called '{legible(name)}'; there are {known}",
              file=sys.stderr)
        return 2
    return start(name, rest)


def start(name: str, args: list[str] | None = None) -> int:
    """
    Run a program and return its exit status; `args` are those of the command line if not given.

    Libraries take a second or more to load. Who interrupts that reads a sentence, and gets the
    status that the program has when it is interrupted later.
    """
    module = PROGRAMS[name][0]
    try:
        program = import_module(module)
    except KeyboardInterrupt:
        print(f'{name}: interrupted', file=sys.stderr)
        return _status_of_interrupted(name)
    return int(program.main(args))


def _status_of_interrupted(name: str) -> int:
    """Return the exit status of a program that was interrupted: nodes are ended in no other way."""
    is_node = name in PROGRAMS and PROGRAMS[name][0].startswith('booster_ros.nodes')
    return 0 if is_node else INTERRUPTED


def in_a_process_of_its_own(name: str, run: Callable[[], int]) -> int:
    """Return the exit status of what `run` does, whatever the process finds around it."""
    open_streams()
    if not working_folder_is_there():
        print(f'{name}: the working folder has been deleted, change to another one',
              file=sys.stderr)
        return 2
    EndAtOnce(name, _status_of_interrupted(name))
    try:
        status = run()
    except SystemExit as end:  # argparse's
        status = int(end.code or 0)
    ignore_signals()
    complaint = complaint_on_output()
    if complaint:
        print(f'{name}: {complaint}', file=sys.stderr)
        return status or 2
    return status


# what setup.py installs
(positioner, fake_controller, twin, simulate, inspect, close_loop, fleet, metrics, paper, demo,
 campaign) = (partial(in_a_process_of_its_own, name, partial(start, name)) for name in PROGRAMS)


if __name__ == '__main__':
    asked = sys.argv[1] if sys.argv[1:2] and sys.argv[1] in PROGRAMS else 'booster_ros'
    sys.exit(in_a_process_of_its_own(asked, main))
