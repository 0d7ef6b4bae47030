# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Letting nodes of this process handle what has come for them, and no more."""

from rclpy.executors import Executor, TimeoutException


def handle_waiting(executor: Executor) -> None:
    """Call all callbacks that are ready, and those that become ready by them, without waiting."""
    try:
        while True:
            handler, _, _ = executor.wait_for_ready_callbacks(timeout_sec=0.0)
            handler()
            handler.result()
    except TimeoutException:
        pass
