# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Run a target on many inputs: `PYTHONPATH=test python -m fuzz csv --inputs 10000`.

Input k is made of the number k alone, so that `--first k --inputs 1` runs it again. An exception
that is none of ours, a hang and memory beyond the limit end the run and name the input.
"""

from __future__ import annotations

import argparse
from contextlib import suppress
from pathlib import Path
import random
import resource
import signal
import sys
import time

from . import mapped, plant, preparing, readers

TARGETS = {
    'bag': readers.bag,
    'csv': readers.csv,
    'mapped': mapped.run,
    'mapping_file': mapped.mapping_file,
    'parameter_file': readers.parameter_file,
    'plant': plant.run,
    'preparing': preparing.run,
}

PATIENCE = 120
"""
Seconds of processor time that an input may take: a run over a week, the longest record, takes 8 s,
and a record is prepared with four and more.
"""

MEMORY = 4 << 30
"""Bytes of address space that the process may take on top of what it has after the first input."""


def run(target: str, first: int, inputs: int) -> float:
    """Run a target on inputs; return the longest processor time of one, s."""
    with suppress(Exception):  # loads libraries, and compiles: that is not its time
        TARGETS[target](random.Random(first))
    longest = 0.0
    for number in range(first, first + inputs):
        signal.setitimer(signal.ITIMER_VIRTUAL, PATIENCE)
        begin = time.process_time()
        try:
            TARGETS[target](random.Random(number))
        except BaseException as error:
            raise AssertionError(f'{target}, input {number}: {error!r}') from error
        finally:
            signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        longest = max(longest, time.process_time() - begin)
    return longest


def hang(number: int, frame: object) -> None:
    """Raise TimeoutError."""
    raise TimeoutError(f'not done after {PATIENCE} s')


def main() -> int:
    """Run what the command line asks for."""
    parser = argparse.ArgumentParser(prog='fuzz', description=__doc__)
    parser.add_argument('target', choices=sorted(TARGETS))
    parser.add_argument('--inputs', type=int, default=10_000)
    parser.add_argument('--first', type=int, default=0)
    options = parser.parse_args()
    signal.signal(signal.SIGVTALRM, hang)
    run(options.target, options.first, 1)
    pages = int(Path('/proc/self/statm').read_text().split()[0])
    used = pages * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY, resource.RLIM_INFINITY))
    longest = run(options.target, options.first, options.inputs)
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss >> 10
    print(f'{options.target}: {options.inputs} inputs, the longest {longest:.2f} s, '
          f'{most} MB at most')
    return 0


if __name__ == '__main__':
    sys.exit(main())
