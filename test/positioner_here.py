# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The node `positioner` in the process of the test, which can look and reach into it."""

from __future__ import annotations

from collections.abc import Iterator
import contextlib
import threading

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from booster_ros.nodes.positioner import Positioner


@contextlib.contextmanager
def context_here(*ros_arguments: str) -> Iterator[list[str]]:
    """Initialise rclpy with these arguments for ROS, and return the command line."""
    arguments = ['--ros-args', *ros_arguments]
    rclpy.init(args=['positioner', *arguments], signal_handler_options=SignalHandlerOptions.NO)
    try:
        yield arguments
    finally:
        rclpy.try_shutdown()


@contextlib.contextmanager
def positioner_here(*ros_arguments: str) -> Iterator[Positioner]:
    """Return a positioner with these arguments for ROS; it does nothing unless it is spun."""
    with context_here(*ros_arguments) as arguments:
        node = Positioner(arguments)
        try:
            yield node
        finally:
            node.destroy_node()


@contextlib.contextmanager
def spinning(node: Node) -> Iterator[None]:
    """Spin the node beside the test."""
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    thread = threading.Thread(target=executor.spin)
    thread.start()
    try:
        yield
    finally:
        executor.shutdown()
        thread.join()
