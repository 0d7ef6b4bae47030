# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""An rclpy node inside the test, to talk to the node under test."""

from __future__ import annotations

from collections.abc import Callable
import contextlib
import time
from types import TracebackType
from typing import Any

import rclpy
from rclpy.client import Client
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from ros_process import PATIENCE


class RosClient:
    """A node with a context of its own; use it as a context manager."""

    def __init__(self, name: str = 'test_client'):
        """Join the domain that ROS_DOMAIN_ID names."""
        self._context = Context()
        rclpy.init(context=self._context)
        self.node = rclpy.create_node(name, context=self._context, enable_rosout=False)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._clients: dict[str, Client] = {}

    def spin_until(self, done: Callable[[], bool], timeout: float = PATIENCE) -> None:
        """
        Handle what arrives until `done()`.

        Raises:
            AssertionError: it is not done after `timeout` seconds.

        """
        end = time.monotonic() + timeout
        while not done():
            assert time.monotonic() < end, f'nothing came of it in {timeout} s'
            self.spin_once()

    def spin_once(self) -> None:
        """Handle one thing that arrives, or let a moment pass."""
        self._executor.spin_once(timeout_sec=0.05)

    def listen(self, topic: str, kind: type, depth: int = 1000) -> list[Any]:
        """Subscribe, and return the list to which each message is appended as it arrives."""
        messages: list[Any] = []
        self.node.create_subscription(kind, topic, messages.append, depth)
        return messages

    def forget(self) -> None:
        """End all subscriptions."""
        for subscription in list(self.node.subscriptions):
            self.node.destroy_subscription(subscription)

    def receive(
        self, topic: str, kind: type, count: int = 1, timeout: float = PATIENCE
    ) -> list[Any]:
        """Subscribe and return the first `count` messages."""
        messages = self.listen(topic, kind)
        self.spin_until(lambda: len(messages) >= count, timeout)
        return messages[:count]

    def call(self, service: str, kind: type, request: Any, attempts: int = 3) -> Any:
        """
        Wait for the service, call it and return the response.

        A service may answer before it knows who listens, and that answer is lost
        (github.com/ros2/rmw_fastrtps/issues/842). So what was not answered is asked again, unless
        one attempt is all that does no harm.

        Raises:
            AssertionError: there is no such service, or none of the attempts was answered.

        """
        client = self._clients.get(service)
        if client is None:
            client = self._clients[service] = self.node.create_client(kind, service)
        self.spin_until(client.service_is_ready)
        for _ in range(attempts):
            future = client.call_async(request)
            with contextlib.suppress(AssertionError):
                self.spin_until(future.done, PATIENCE / attempts)
                return future.result()
            client.remove_pending_request(future)
        raise AssertionError(f'{service} was asked {attempts} times and did not answer')

    def __enter__(self) -> RosClient:
        """Return the client itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Leave the domain."""
        self._executor.shutdown()
        self.node.destroy_node()
        self._context.try_shutdown()
