# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The node `fake_controller` in the process of the test."""

from __future__ import annotations

from collections.abc import Callable
import contextlib
import time

from positioner_here import context_here
from positioner_process import with_parameters
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from ros_process import PATIENCE

from booster_ros.nodes.fake_controller import FakeController
from booster_ros.run_error import RunError


def played(
    *ros_arguments: str, then: Callable[[], object] | None = None, **parameters: object
) -> str:
    """
    Play in this process; return the sentence with which the run is given up, '' if it is not.

    `then` is called when half a second has been played.
    """
    with context_here(*ros_arguments, *with_parameters(**parameters)) as arguments:
        node, executor = FakeController(arguments), SingleThreadedExecutor()
        executor.add_node(node)
        end = time.monotonic() + PATIENCE
        try:
            while node.context.ok():
                assert time.monotonic() < end
                if then is not None and node._played >= 0.5:
                    then()
                    then = None
                    continue  # it may have ended this context
                with contextlib.suppress(ExternalShutdownException):
                    executor.spin_once(timeout_sec=0.05)
        except RunError as error:
            return str(error)
        finally:
            executor.shutdown()
            node.destroy_node()
    return ''
