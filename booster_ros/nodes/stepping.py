# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Ticks on request: in portions, between which other callbacks have their turn."""

from collections.abc import Callable, Generator

from rclpy.executors import Executor
from rclpy.node import Node


class Stepping:
    """Runs the ticks that a request asks for; what `begin` returns for it runs so many at once."""

    def __init__(self, node: Node, portion: int, begin: Callable[[], Callable[[int], None]]
                 ) -> None:
        self._node = node
        self._portion = portion
        self._begin = begin
        self._left = 0

    def stop(self) -> None:
        """Run no more ticks of the request that is under way."""
        self._left = 0

    async def advance(self, count: int) -> int:
        """
        Run `count` ticks and return how many there were: fewer if `stop` was called.

        Requests are served one after the other.
        """
        executor = self._node.executor
        assert executor is not None
        while self._left > 0:
            await _Turn(executor)
        self._left = count
        run = self._begin()
        done = 0
        while self._left > 0:
            portion = min(self._left, self._portion)
            run(portion)
            done += portion
            self._left -= portion
            if self._left > 0:
                await _Turn(executor)
        self._left = 0
        return done


class _Turn:
    """Awaited by a task of an executor: others come first."""

    def __init__(self, executor: Executor) -> None:
        self._executor = executor

    def __await__(self) -> Generator[None, None, None]:
        self._executor.wake()  # it waits for something to happen before it asks a task again
        yield
