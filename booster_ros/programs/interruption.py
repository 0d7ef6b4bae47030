# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Keep an interruption that Python loses."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
import signal
import sys
import threading
from types import FrameType

from ..surroundings import SIGNALS, ignore_signals


@contextmanager
def kept_interruption() -> Iterator[Callable[[], None]]:
    """
    Yield a function that raises KeyboardInterrupt if one has come and has not ended the block.

    SIGINT raises KeyboardInterrupt in whatever Python code runs next. Where that is a callback
    of a weak reference (the import of a module has one), a finaliser or a callback from C, the
    interpreter prints the exception and goes on: who pressed Ctrl-C would wait for the end.
    SIGTERM and SIGHUP, which would end the process where it stands, raise it too, so that what is
    half written is removed; but only once, as a terminal that closes may send several. A second
    SIGINT raises it again where the first was lost, not while what that began is cleaned up. SIGHUP
    that is ignored, as under nohup, stays so. Outside the main thread, which alone is given
    signals, nothing is kept.
    """
    came = threading.Event()

    def interrupt(number: int, frame: FrameType | None) -> None:
        again = came.is_set()
        came.set()
        is_ending = isinstance(sys.exc_info()[1], KeyboardInterrupt)
        if not again or (number == signal.SIGINT and not is_ending):
            signal.default_int_handler(number, frame)

    def check() -> None:
        if came.is_set():
            raise KeyboardInterrupt

    if threading.current_thread() is not threading.main_thread():
        yield check
        return
    previous = {number: signal.signal(number, interrupt) for number in _heeded()}
    try:
        yield check
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)


def _heeded() -> Iterator[signal.Signals]:
    """Yield the signals that interrupt."""
    for number in SIGNALS:
        if number != signal.SIGHUP or signal.getsignal(number) != signal.SIG_IGN:
            yield number


def ignore_interruptions() -> None:
    """Let no signal interrupt the rest of `kept_interruption`: it is too late to stop."""
    if threading.current_thread() is threading.main_thread():
        ignore_signals()
