# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""`close_loop` in a process of its own: low priority, bounded time, one at a time, no waiting."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
import fcntl
import itertools
import os
from pathlib import Path
import resource
import signal
import subprocess
import sys
import time

import numpy as np

from ..model.system import PositionerParameters
from ..parameters.file import write_parameter_file
from ..surroundings import environment_with_package
from .history import write_record

Array = np.ndarray

RECORD, DECLARED, SAID = 'record.csv', 'declared.yaml', 'close_loop.txt'
"""What stands in the folder of a diagnosis beside what `close_loop` writes."""

NICE = 15
"""Niceness of the process: whatever else wants the processor goes first."""

TO_END = 3.0
"""Time, s, in which it may clean up when it is told to end, before it is killed."""

_LOCK = '.diagnosis.lock'


class BusyError(Exception):
    """Another diagnosis runs in this folder of reports; the message says so."""


class DiagnosisRun:
    """
    A running `close_loop`, in a folder of its own with its record and its declared model.

    The process holds a lock on the folder of reports until it ends, also where the process that
    started it was killed: so there are never two. Its processor time is limited too, so that even
    then it does not go on for ever.
    """

    def __init__(
        self, reports: Path, columns: Mapping[str, Array], declared: PositionerParameters,
        hypotheses: Sequence[str], limit: float, now: float,
    ) -> None:
        """
        Write record and declared model into a new folder of `reports`, and start.

        `columns` are those of the record, `hypotheses` the effects to try, all if empty. It has
        to end `limit` s after `now`, s of a clock that does not jump.

        Raises:
            BusyError: another one runs in `reports`.
            OSError, RecordError: no file can be written, or no process be started.

        """
        self.limit, self.began = limit, now
        self._told_to_end: float | None = None
        reports.mkdir(parents=True, exist_ok=True)
        lock = _locked(reports / _LOCK)
        try:
            self.folder = _new_folder(reports)
            write_record(self.folder / RECORD, columns)
            write_parameter_file(self.folder / DECLARED, declared, 'The model of the twin.')
            with (self.folder / SAID).open('wb') as said:
                self._process = subprocess.Popen(
                    self._command(hypotheses), stdin=subprocess.DEVNULL, stdout=said, stderr=said,
                    env=environment_with_package(), pass_fds=(lock,), start_new_session=True)
        finally:
            os.close(lock)  # the process has it now
        with suppress(OSError, ValueError):  # it may have ended
            os.setpriority(os.PRIO_PROCESS, self._process.pid, NICE)
            seconds = int(limit * (os.cpu_count() or 1)) + 1  # of all threads together
            resource.prlimit(self._process.pid, resource.RLIMIT_CPU, (seconds, seconds + 5))

    def _command(self, hypotheses: Sequence[str]) -> list[str]:
        return [sys.executable, '-m', 'booster_ros', 'close_loop',
                '--record', str(self.folder / RECORD), '--params', str(self.folder / DECLARED),
                '--out', str(self.folder), *(('--only', *hypotheses) if hypotheses else ())]

    def trouble(self, now: float) -> str | None:
        """Return None while it runs, '' once it is done, else a sentence on what failed."""
        status = self._process.poll()
        if status is None:
            self._hurry(now)
            return None
        if self._told_to_end is not None or status == -signal.SIGXCPU:
            return f'no answer within {self.limit:g} s'
        if status == 0:
            return ''
        if status < 0:
            return f'close_loop was ended by {signal.Signals(-status).name}'
        return _last_line(self.folder / SAID) or f'close_loop ended with status {status}'

    def _hurry(self, now: float) -> None:
        """Tell it to end when its time is over, and kill it where it does not."""
        if self._told_to_end is None:
            if now - self.began > self.limit:
                self._told_to_end = now
                self._signal(signal.SIGTERM)
        elif now - self._told_to_end > TO_END:
            self._signal(signal.SIGKILL)

    def end(self) -> None:
        """End it, if it still runs, and wait for that: nothing half written stays."""
        if self._process.poll() is not None:
            return
        self._signal(signal.SIGTERM)
        try:
            self._process.wait(TO_END)
        except subprocess.TimeoutExpired:
            self._signal(signal.SIGKILL)
            self._process.wait()

    def _signal(self, number: signal.Signals) -> None:
        with suppress(ProcessLookupError):
            os.killpg(self._process.pid, number)


def _locked(path: Path) -> int:
    """Return the descriptor of a locked file; BusyError where somebody else holds the lock."""
    descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW, 0o666)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(descriptor)
        raise BusyError(f'another diagnosis runs in {path.parent}') from None
    except OSError:
        pass  # a file system that knows no locks
    return descriptor


def _new_folder(reports: Path) -> Path:
    """Make a folder named by the time of day, with a number behind it where that is taken."""
    name = time.strftime('%Y-%m-%dT%H-%M-%S')
    for number in itertools.count(1):
        folder = reports / (name if number == 1 else f'{name}_{number}')
        with suppress(FileExistsError):
            folder.mkdir()
            return folder
    raise AssertionError('numbers have no end')


def _last_line(path: Path) -> str:
    try:
        lines = path.read_text(encoding='utf-8', errors='replace').split('\n')
    except OSError:
        return ''
    said = [line.strip() for line in lines if line.strip()]
    return said[-1] if said else ''
