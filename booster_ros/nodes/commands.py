# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The commands of a positioner: how they arrive, wait for their tick and are complained of."""

from collections.abc import Callable

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from rclpy.qos_overriding_options import QoSOverridingOptions
from std_msgs.msg import Float64

from ..model.parameters import ParameterError
from .command_guard import CommandGuard, CommandRules
from .throttle import Throttle

DEPTH = 100
"""Commands kept until they are handled; of those for one tick the last one counts."""


class Commands:
    """
    Subscribes to `control_current` and keeps the current in force, see `CommandGuard`.

    `changed` is called where commands have become better or worse, `arrived` for each one that
    was handled. Commands that are held back (while the ticks of one request run) are handled
    afterwards, so that it does not depend on when they arrive what they do.
    """

    TOPIC = 'control_current'
    TOPICS: tuple[str, ...] = (TOPIC,)

    def __init__(
        self, node: Node, rules: CommandRules, throttle: Throttle,
        changed: Callable[[], None], arrived: Callable[[], None],
    ) -> None:
        """Subscribe, with the QoS that `qos_overrides` ask for; ParameterError if they cannot."""
        self.guard = CommandGuard(rules)
        self._node = node
        self._logger = node.get_logger()
        self._throttle = throttle
        self._changed = changed
        self._arrived = arrived
        self._clock = Clock(clock_type=ClockType.STEADY_TIME)
        self._held: list[Float64] | None = None
        try:
            self.subscription = node.create_subscription(
                Float64, self.TOPIC, self._on_command, DEPTH,
                qos_overriding_options=QoSOverridingOptions.with_default_policies())
        except (AssertionError, AttributeError, RuntimeError, TypeError, ValueError) as error:
            problem = error if isinstance(error, RuntimeError) else 'a value of the wrong kind'
            raise ParameterError(f'qos_overrides of {self.TOPIC}: {problem}') from None

    def commanders(self) -> int:
        """Return how many publishers of commands there are."""
        return sum(map(self._node.count_publishers, self.TOPICS))

    def at_tick(self, simulated: int) -> float:
        """Return the current, A, for the tick that starts at this simulated time (ns)."""
        was_stale = self.guard.stale
        current = self.guard.at_tick(simulated)
        if self.guard.stale != was_stale:
            self._on_stale_change()
        return current

    def take_waiting(self) -> None:
        """
        Take over the commands that came before a request, for a step to use or a reset to forget.

        The executor asks for waiting messages before it asks for requests: a command and a request
        that both arrive between these two would be handled in the wrong order.
        """
        while (message := self.take()) is not None:
            self.offer(message.data)

    def take(self) -> Float64 | None:
        """Return the next command that waits to be handled, None if there is none."""
        waiting = self.subscription.handle
        with waiting:
            taken = waiting.take_message(Float64, False)
        return None if taken is None else taken[0]

    def hold_back(self) -> None:
        """Let commands wait from now on."""
        self._held = self._held or []

    def release(self) -> None:
        """Handle the commands that have waited, and those to come at once."""
        held, self._held = self._held or [], None
        for message in held:
            self._on_command(message)

    def _on_command(self, message: Float64) -> None:
        if self._held is not None:
            self._held.append(message)
            return
        self.offer(message.data)
        self._arrived()

    def offer(self, current: float) -> None:
        """Take a current (A) over at the next tick, or complain of it."""
        verdict = self.guard.offer(current)
        if verdict.cause is None:
            return
        if self._throttle.passes(verdict.cause, self._clock.now().nanoseconds):
            self._logger.warning(self.guard.complaint(current, verdict))
        self._changed()

    def _on_stale_change(self) -> None:
        rules = self.guard.rules
        if not self.guard.stale:
            self._logger.info(f'{self.TOPIC} is being commanded again')
        elif self._throttle.passes('stale', self._clock.now().nanoseconds):
            self._logger.warning(
                f'{self.TOPIC} is older than command_timeout ({rules.command_timeout:g} s): '
                f'{rules.stale_command}')
        self._changed()
