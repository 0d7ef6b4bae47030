# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The life of a node's process: start it, spin it, end it cleanly however it is told to."""

import argparse
from collections.abc import Callable, Sequence
import os
import re
import signal
import sys
import threading
import time
import traceback
from types import FrameType

import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.utilities import ok, remove_ros_args, try_shutdown

from ..legible import legible
from ..model.parameters import ParameterError
from ..parameters.sections import files_on, read_sections
from ..run_error import RunError
from .handling import handle_waiting

DONE = 0
BAD_INPUT = 2

_EPILOG = 'Parameters, names and remappings follow --ros-args, as for any ROS 2 node:\n  '
_END_SIGNALS = (signal.SIGINT, signal.SIGTERM)


def run(
    name: str, description: str | None, make_node: Callable[[], Node], arguments: Sequence[str],
    example: str = '--ros-args -p NAME:=VALUE', rest: float = 0.0,
) -> int:
    """
    Spin the node that `make_node` returns until it is told to end; return the status.

    SIGINT, SIGTERM, SIGHUP and a shutdown tell it. Bad arguments and parameters (ParameterError of
    `make_node`) and a run that cannot go on (RunError of a callback) end with one sentence on
    stderr and status 2. `name`, `description` and `example` (arguments, and where to read on) are
    for `--help`, `arguments` is the command line without the program's name. A node that may be
    `rest` s late handles what has come meanwhile at once: rclpy's wait costs more than a message.
    """
    startup = _Startup()
    for number in _END_SIGNALS:
        signal.signal(number, startup.interrupt)
    _pass_hangups_on()
    try:
        for path in files_on(arguments):
            read_sections(path)  # complains in a sentence, as rcl does not
        argparse.ArgumentParser(
            prog=name, description=description, epilog=f'{_EPILOG}{name} {example}',
            formatter_class=argparse.RawDescriptionHelpFormatter,
        ).parse_args(remove_ros_args([name, *arguments])[1:])
        rclpy.init(args=[name, *arguments])
    except ParameterError as error:
        return _complain(name, str(error))
    except rclpy_implementation.UnknownROSArgsError as error:
        return _complain(name, f'unknown ROS arguments: {error}')
    except rclpy_implementation.RCLError as error:
        return _complain(name, _without_source_places(str(error)))
    startup.over = True
    executor = SingleThreadedExecutor()  # docs/decisions.md says why not EventsExecutor
    try:
        node = make_node()
        executor.add_node(node)
        while not _spun_to_the_end(executor, rest):
            node.get_logger().warning(
                'a time below zero on /clock, which no clock of ROS 2 can show: ignored',
                throttle_duration_sec=10.0)
    except ExternalShutdownException:
        pass
    except (ParameterError, RunError) as error:
        return _complain(name, str(error))
    except Exception as error:
        if 'PARAMETER_NOT_SET' in str(error):
            return _complain(name, 'an empty list ([]) is no value of a parameter')
        # rclpy raises all sorts where the context ends in the middle of something
        if ok():
            raise
    finally:
        _ignore_signals()
        _tear_down(executor)
    return DONE


def _spun_to_the_end(executor: SingleThreadedExecutor, rest: float) -> bool:
    """
    Spin until told to end; return False where a time on /clock is one that rclpy cannot hold.

    rclpy listens to /clock itself, and lets the ValueError of its own class of times out.
    """
    try:
        while rest:
            handle_waiting(executor)
            time.sleep(rest)
        executor.spin()
    except ValueError as error:
        if not any(frame.f_code.co_name == 'clock_callback'
                   for frame, _ in traceback.walk_tb(error.__traceback__)):
            raise
        return False
    return True


class _Startup:
    """
    What SIGINT and SIGTERM do in Python: end the process until rclpy has them, then nothing.

    From `rclpy.init` on rclpy's own handlers shut the context down, which ends the spinning.
    Python's KeyboardInterrupt beside that would come in the middle of the end, and a second one
    in the middle of cleaning up.
    """

    def __init__(self) -> None:
        self.over = False

    def interrupt(self, number: int, frame: FrameType | None) -> None:
        """Handle a signal."""
        if not self.over:
            sys.exit(DONE)


def _pass_hangups_on() -> None:
    """
    Let SIGHUP, which a terminal sends as it closes, do from now on what SIGTERM does.

    rclpy has no handler for SIGHUP, and one of Python's would not run before the spinning wakes: a
    thread is woken instead. Where SIGHUP is ignored, as under nohup, it stays so.
    """
    if signal.getsignal(signal.SIGHUP) == signal.SIG_IGN:
        return
    come, comes = os.pipe()
    os.set_blocking(comes, False)
    signal.set_wakeup_fd(comes)  # every signal that has a handler in Python writes its number there
    signal.signal(signal.SIGHUP, lambda number, frame: None)

    def wait() -> None:
        while True:
            if signal.SIGHUP in os.read(come, 64):
                os.kill(os.getpid(), signal.SIGTERM)

    threading.Thread(target=wait, name='hangups', daemon=True).start()


def _ignore_signals() -> None:
    """Let further signals do nothing; unlike a handler of Python's, that holds to the very end."""
    for number in (*_END_SIGNALS, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)


def _tear_down(executor: SingleThreadedExecutor) -> None:
    nodes = executor.get_nodes()
    executor.shutdown()
    for node in nodes:
        node.destroy_node()
    try_shutdown()


def _complain(name: str, sentence: str) -> int:
    print(f'{name}: {legible(sentence)}', file=sys.stderr)
    return BAD_INPUT


def _without_source_places(text: str) -> str:
    """Return an error of rcl without the places in its own source code."""
    return re.sub(r', at /[^,]*:\d+', '', text).removeprefix('failed to initialize rcl: ')
