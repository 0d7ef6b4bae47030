# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A Dask scheduler with workers, each a process of its own."""

from collections.abc import Iterator
from contextlib import contextmanager
import json
import os
from pathlib import Path
import subprocess
import sys
import time

from ros_process import ROOT

PLAIN = {**os.environ, 'PYTHONPATH': str(ROOT)}
"""Variables with which a process finds this checkout."""

CLI = 'distributed.cli.dask_'


@contextmanager
def scheduler(folder: Path, workers: int, **variables: str) -> Iterator[str]:
    """
    Yield the address of a scheduler with workers of one thread, which have these variables.

    Neither knows the package beforehand: the scheduler needs it not at all.
    """
    bare = {name: value for name, value in os.environ.items() if name != 'PYTHONPATH'}
    file = folder / 'scheduler.json'
    started = []
    try:
        started.append(subprocess.Popen(
            [sys.executable, '-m', f'{CLI}scheduler', '--host', '127.0.0.1', '--port', '0',
             '--no-dashboard', '--scheduler-file', str(file)], cwd=folder, env=bare,
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))
        while not file.exists():
            time.sleep(0.1)
            assert started[0].poll() is None
        started += [subprocess.Popen(
            [sys.executable, '-m', f'{CLI}worker', '--scheduler-file', str(file), '--nthreads', '1',
             '--no-nanny', '--no-dashboard'], cwd=folder, env={**PLAIN, **variables},
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) for _ in range(workers)]
        yield json.loads(file.read_text())['address']
    finally:
        for process in started[::-1]:
            process.terminate()
            process.wait(30)
