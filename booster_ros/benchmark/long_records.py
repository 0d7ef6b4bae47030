# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What `simulate` takes for records of hours: time beside that of the model alone, and memory."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
import subprocess
import sys
import tempfile
import time
from typing import NamedTuple

import numpy as np

from ..model.parameters import from_values
from ..model.stream import Stream
from ..records import CsvWriter

HOURS = (1.0, 6.0, 24.0)
RATE = 100.0
PORTION = 60_000


class Cost(NamedTuple):
    """Wall and CPU time, s, and the largest resident memory, bytes, of a finished process."""

    wall: float
    cpu: float
    memory: float


def rows(hours: float) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield time (s) and current (A) in portions: a current that moves at every row."""
    size = round(hours * 3600.0 * RATE)
    for first in range(0, size, PORTION):
        t = np.arange(first, min(first + PORTION, size)) / RATE
        yield t, 0.41e-3 + 0.03e-3 * np.sin(0.3 * t)


def write_input(path: Path, hours: float) -> None:
    """Write such a record."""
    with CsvWriter(path, ('time', 'control_current')) as writer:
        for portion in rows(hours):
            writer.write_rows(np.column_stack(portion))


# A process counts the memory of the one that started it as its own until its program is loaded: so
# a small one has to start it.
_WATCH = """
import os, sys, time
begin = time.perf_counter()
child = os.posix_spawn(sys.argv[1], sys.argv[1:], os.environ)
_, status, used = os.wait4(child, 0)
print(status, time.perf_counter() - begin, used.ru_utime + used.ru_stime, 1024 * used.ru_maxrss)
"""


def cost_of(command: list[str]) -> Cost:
    """Run a command to its end; RuntimeError where it fails."""
    watched = subprocess.run(
        [sys.executable, '-S', '-c', _WATCH, *command], stdout=subprocess.PIPE, text=True,
        check=True)
    status, wall, cpu, memory = watched.stdout.splitlines()[-1].split()
    if status != '0':
        raise RuntimeError(f'{" ".join(command)} failed')
    return Cost(float(wall), float(cpu), float(memory))


def model_alone(hours: float) -> float:
    """Return the CPU time, s, of the model over these rows, nothing read or written."""
    stream = Stream(from_values({}), 0.0, 0.41e-3)
    stream.advance(np.array([0.0]), np.array([0.41e-3]))
    begin = time.process_time()
    for t, current in rows(hours):
        stream.advance(t, current)
    return time.process_time() - begin


def document() -> str:
    """Return the section on long records."""
    lines = ['| record | rows | wall, s | × real time | CPU, s | of it the model | memory, MB |',
             '|---|---|---|---|---|---|---|']
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder, 'in.csv'), Path(folder, 'out.csv')
        parameters = Path(folder, 'declared.yaml')
        parameters.write_text('/**:\n  ros__parameters: {}\n', encoding='utf-8')
        for hours in HOURS:
            write_input(source, hours)
            cost = cost_of([
                sys.executable, '-m', 'booster_ros', 'simulate', '--params', str(parameters),
                '--input', str(source), '--out', str(target)])
            lines.append(
                f'| {hours:g} h | {hours * 3600.0 * RATE / 1e6:.2f} million | {cost.wall:.1f} | '
                f'{hours * 3600.0 / cost.wall:.0f} | {cost.cpu:.1f} | '
                f'{100.0 * model_alone(hours) / cost.cpu:.0f} % | {cost.memory / 1e6:.0f} |')
    table = '\n'.join(lines)
    return f"""## Long records

`simulate` from CSV to CSV as a command, {RATE:g} Hz, the current moves at every row. Memory is the
largest of the whole process, with Python and the libraries.

{table}
"""
