# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""When to publish the first outputs to a controller that answers to outputs."""

from collections.abc import Callable

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node

from .commands import Commands
from .outputs import OutputPublishers

PERIOD = 0.05
"""Seconds of real time between two looks; who is there at two of them alike is complete."""


class KickOff:
    """Calls `kick` once when somebody commands and somebody listens, and no more are coming."""

    def __init__(
        self, node: Node, commands: Commands, outputs: OutputPublishers,
        kick: Callable[[], None],
    ) -> None:
        self._commands = commands
        self._outputs = outputs
        self._kick = kick
        self._there = (0, 0)
        self._timer = node.create_timer(
            PERIOD, self._look, clock=Clock(clock_type=ClockType.STEADY_TIME))
        self._timer.cancel()

    def begin(self) -> None:
        """Look out from now on."""
        self._there = (0, 0)
        self._timer.reset()

    def end(self) -> None:
        """Look out no more."""
        self._timer.cancel()

    def _look(self) -> None:
        there = self._commands.commanders(), self._outputs.listeners()
        if min(there) > 0 and there == self._there:
            self.end()
            self._kick()
        self._there = there
