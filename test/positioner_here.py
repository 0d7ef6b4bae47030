# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The node `positioner` in the process of the test: its parameters and moments can be looked at."""

from __future__ import annotations

from collections.abc import Iterator
import contextlib

import rclpy
from rclpy.signals import SignalHandlerOptions

from booster_ros.nodes.positioner import Positioner


@contextlib.contextmanager
def positioner_here(*ros_arguments: str) -> Iterator[Positioner]:
    """Return a positioner with these arguments for ROS; it does nothing unless it is spun."""
    arguments = ['--ros-args', *ros_arguments]
    rclpy.init(args=['positioner', *arguments], signal_handler_options=SignalHandlerOptions.NO)
    try:
        node = Positioner(arguments)
        try:
            yield node
        finally:
            node.destroy_node()
    finally:
        rclpy.try_shutdown()
