# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A program under test in a process of its own, as a user starts it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
import os
from pathlib import Path
import re
import signal
import subprocess
import sys
import threading
from types import TracebackType
from typing import IO

import pytest

ROOT = Path(__file__).resolve().parent.parent

AS_OF_USERS = {
    'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
    **dict.fromkeys(('FASTRTPS_DEFAULT_PROFILES_FILE', 'FASTDDS_DEFAULT_PROFILES_FILE'),
                    str(ROOT / 'test' / 'fastdds.xml'))}
"""
Environment of what tests start: the transports that users have, on this machine alone.

Only that nodes announce themselves so often that those that start later know them at once, else
after up to 3 s.
"""

PATIENCE = 120.0
"""
Seconds after which a test takes what it waits for not to come.

They pass only where a test fails, so they can be many: on a machine that does ten other things, a
second's work takes long.
"""

HANGUP = pytest.param(signal.SIGHUP, marks=pytest.mark.skipif(
    signal.getsignal(signal.SIGHUP) == signal.SIG_IGN, reason='ignored by whoever runs the tests'))
"""The signal of a terminal that closes, for tests of what ends a program."""


def program(name: str, *arguments: str) -> list[str]:
    """Return the command that starts one of the package's programs from the source tree."""
    return [sys.executable, '-m', 'booster_ros', name, *arguments]


class RosProcess:
    """
    A running command whose output is collected line by line.

    Use it as a context manager: what still runs at the end is killed.

        with RosProcess(program("positioner")) as node:
            node.wait_for("running")
            assert node.interrupt() == 0
    """

    def __init__(self, command: Sequence[str], environment: Mapping[str, str] | None = None):
        """Start the command at the root of the sources, in this environment or the given one."""
        environment = dict(os.environ if environment is None else environment)
        environment['PYTHONUNBUFFERED'] = '1'
        environment.update(AS_OF_USERS)
        self._process = subprocess.Popen(
            list(command),
            cwd=ROOT,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        assert self._process.stdout is not None
        assert self._process.stderr is not None
        self.stdout: list[str] = []
        self.stderr: list[str] = []
        self._news = threading.Condition()
        self._readers = [
            threading.Thread(target=self._read, args=args, daemon=True)
            for args in (
                (self._process.stdout, self.stdout),
                (self._process.stderr, self.stderr),
            )
        ]
        for reader in self._readers:
            reader.start()

    def _read(self, stream: IO[str], lines: list[str]) -> None:
        with stream:
            for line in stream:
                with self._news:
                    lines.append(line.rstrip('\n'))
                    self._news.notify_all()
        with self._news:
            self._news.notify_all()

    @property
    def output(self) -> str:
        """Everything printed so far: what went to stdout, then what went to stderr."""
        return '\n'.join([*self.stdout, *self.stderr])

    def _find(self, pattern: str) -> str | None:
        return next((line for line in self.stdout + self.stderr if re.search(pattern, line)), None)

    def over(self) -> bool:
        """Tell whether it has ended."""
        return not any(reader.is_alive() for reader in self._readers)

    def wait_for(self, pattern: str, timeout: float = PATIENCE) -> str:
        """
        Return the first line, of either stream, in which the regular expression is found.

        Raises:
            AssertionError: the process ended, or `timeout` seconds passed, without such a line.

        """
        with self._news:
            self._news.wait_for(lambda: self._find(pattern) or self.over(), timeout)
            line = self._find(pattern)
        assert line is not None, f'no line with {pattern!r} in:\n{self.output}'
        return line

    def send(self, number: signal.Signals) -> None:
        """Send a signal."""
        self._process.send_signal(number)

    def wait(self, timeout: float = PATIENCE) -> int:
        """
        Wait for the end and return the exit status (negative: the signal that killed it).

        Raises:
            AssertionError: it still runs after `timeout` seconds.

        """
        try:
            status = self._process.wait(timeout)
        except subprocess.TimeoutExpired:
            raise AssertionError(f'still running after {timeout} s:\n{self.output}') from None
        for reader in self._readers:
            reader.join(timeout)
        return status

    def interrupt(self, timeout: float = PATIENCE) -> int:
        """Press Ctrl-C and return the exit status."""
        self.send(signal.SIGINT)
        return self.wait(timeout)

    def __enter__(self) -> RosProcess:
        """Return the process itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Kill what still runs."""
        self._process.kill()
        self._process.wait()
        for reader in self._readers:
            reader.join()
