# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
What a process finds around it when it starts, put into a state that a program can rely on.

Streams may be closed, full or of a reader that has gone, a terminal may lack a sign, the working
folder may have been deleted, signals come before a program has its own ways for them.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
import errno
import io
import os
from pathlib import Path
import signal
import sys
from types import FrameType
from typing import TextIO

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
"""Those that tell a program to end."""

INTERRUPTED = 130
"""The exit status of a program that was interrupted."""


class EndAtOnce:
    """
    What SIGINT, SIGTERM and SIGHUP do while a program has nothing to clean up: end it at once.

    While libraries are loaded, a KeyboardInterrupt could be lost in one of them; SIGTERM and SIGHUP
    would end the process without a word, and with another status. SIGHUP that is ignored, as under
    nohup, stays so.
    """

    def __init__(self, name: str, status: int) -> None:
        """End with `status`; `name` begins the sentence that says so."""
        self._name = name
        self._status = status
        for number in SIGNALS:
            if number != signal.SIGHUP or signal.getsignal(number) != signal.SIG_IGN:
                signal.signal(number, self._end)

    def _end(self, number: int, frame: FrameType | None) -> None:
        ignore_signals()
        if not isinstance(sys.exc_info()[1], KeyboardInterrupt):  # that one says so itself
            with suppress(OSError):
                os.write(2, f'{self._name}: interrupted\n'.encode())
        os._exit(self._status)


def ignore_signals() -> None:
    """Let signals do nothing from now on: it is too late to end otherwise."""
    for number in SIGNALS:
        signal.signal(number, signal.SIG_IGN)


def open_streams() -> None:
    """
    Let whatever is printed never fail.

    Streams that are closed lead nowhere from now on: the next file to be opened would take their
    place. A sign that the stream cannot show becomes a question mark.
    """
    for descriptor in range(3):
        try:
            os.fstat(descriptor)
        except OSError:
            nowhere = os.open(os.devnull, os.O_RDWR)  # takes the lowest number, which this one is
            if nowhere != descriptor:
                os.dup2(nowhere, descriptor)
                os.close(nowhere)
    for name, descriptor in (('stdout', 1), ('stderr', 2)):
        stream = getattr(sys, name)
        if stream is None or (stream is getattr(sys, f'__{name}__')):
            setattr(sys, name, _Forgiving(stream, descriptor))


def complaint_on_output() -> str:
    """Return why what was printed is lost, as on a full disk; '' where nothing is, or unread."""
    sys.stdout.flush()
    error = sys.stdout.error if isinstance(sys.stdout, _Forgiving) else None
    if error is None or error.errno == errno.EPIPE:
        return ''
    return f'what it prints cannot be written: {error.strerror}'


def working_folder_is_there() -> bool:
    """Tell whether the working folder has not been deleted."""
    try:
        os.getcwd()
    except OSError:
        return False
    return True


def environment_with_package() -> Mapping[str, str]:
    """Return the variables of a process that finds the package where this one did."""
    root = str(Path(__file__).resolve().parents[1])
    others = os.environ.get('PYTHONPATH')
    return {**os.environ, 'PYTHONPATH': f'{root}{os.pathsep}{others}' if others else root}


class _Forgiving(io.TextIOWrapper):
    """A stream that takes everything; once something cannot be written, it leads nowhere."""

    def __init__(self, stream: TextIO | None, descriptor: int) -> None:
        """Take the place of a stream, None where there was none, to this descriptor."""
        self.error: OSError | None = None
        """Why the first thing that could not be written could not be."""
        self._descriptor = descriptor
        buffer = os.fdopen(descriptor, 'wb', closefd=False) if stream is None else stream.buffer
        super().__init__(
            buffer, encoding='utf-8' if stream is None else stream.encoding, errors='replace',
            line_buffering=descriptor == 2 or os.isatty(descriptor))

    def write(self, text: str) -> int:
        """Write what can be written."""
        try:
            return super().write(text)
        except OSError as error:
            self._lead_nowhere(error)
            return len(text)

    def flush(self) -> None:
        """Write what has been kept back."""
        try:
            super().flush()
        except OSError as error:
            self._lead_nowhere(error)
            super().flush()

    def _lead_nowhere(self, error: OSError) -> None:
        self.error = self.error or error
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, self._descriptor)
        os.close(nowhere)
