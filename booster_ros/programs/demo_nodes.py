# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The two nodes of the demo, each in a process of its own."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
import signal
import subprocess
import sys
from typing import IO

from .interruption import kept_interruption

GLANCE = 0.5
"""Time from one look for an interruption to the next, s."""

PATIENCE = 10.0
"""How long a process may take to end when it is told to, s."""


class DemoError(Exception):
    """The demo cannot go on; the message is one sentence for the user."""


def play(
    settings: Mapping[str, object],
    positioner: Mapping[str, object],
    params_file: Path | None,
    environment: Mapping[str, str],
    log: Path,
) -> None:
    """
    Let the fake controller play to a positioner, which writes what it says into `log`.

    `settings` and `positioner` are parameters of the two nodes, `params_file` the positioner's
    file, if any. DemoError where the controller does not end with status 0.
    """
    with (
        log.open('w') as sink,
        running('positioner', positioner, environment, sink, params_file),
        running('fake_controller', settings, environment) as controller,
    ):
        status = ended(controller)
    if status != 0:
        raise DemoError(f'the fake controller ended with status {status}; see also {log}')


@contextmanager
def running(
    name: str,
    parameters: Mapping[str, object],
    environment: Mapping[str, str],
    sink: IO[str] | None = None,
    params_file: Path | None = None,
) -> Iterator[subprocess.Popen[bytes]]:
    """Run one of the package's nodes in a process of its own, and end it at the end."""
    command = [sys.executable, '-m', 'booster_ros', name, '--ros-args']
    if params_file is not None:
        command += ['--params-file', str(params_file)]
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
