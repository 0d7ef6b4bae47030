# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The set points of a positioner that holds its position, from three topics."""

from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from rclpy.subscription import Subscription
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from .command_guard import CommandRules
from .commands import DEPTH, Commands
from .throttle import Throttle


class SetPoints(Commands):
    """
    Subscribes to `set_point`, `set_point_current` and `joint_commands`: the last that came counts.

    A loop current becomes a set point by `position_of`; of joint commands the position of `joint`
    counts, and messages without it are those of other joints.
    """

    TOPIC = 'set_point'
    TOPICS = (TOPIC, 'set_point_current', 'joint_commands')

    def __init__(
        self, node: Node, rules: CommandRules, throttle: Throttle,
        changed: Callable[[], None], arrived: Callable[[], None],
        position_of: Callable[[float], float], joint: str,
    ) -> None:
        """Subscribe; ParameterError where `qos_overrides` do not fit."""
        super().__init__(node, rules, throttle, changed, arrived)
        self._position_of = position_of
        self._joint = joint
        self._others: dict[Subscription, tuple[type, Callable[..., float | None]]] = {
            node.create_subscription(
                Float64, 'set_point_current', self._on_current, DEPTH): (Float64, self._of_current),
            node.create_subscription(JointState, 'joint_commands', self._on_joints, DEPTH): (
                JointState, self._of_joints),
        }

    def take_waiting(self) -> None:
        """Take over the set points that came before a request, in the order of their sending."""
        waiting = [(stamp, message.data) for message, stamp in _taken(self.subscription, Float64)]
        for subscription, (kind, value_of) in self._others.items():
            for message, stamp in _taken(subscription, kind):
                value = value_of(message)
                if value is not None:
                    waiting.append((stamp, value))
        for _, value in sorted(waiting, key=lambda one: one[0]):
            self.offer(value)

    def _of_current(self, message: Float64) -> float:
        return self._position_of(message.data)

    def _of_joints(self, message: JointState) -> float | None:
        for name, position in zip(message.name, message.position):
            if name == self._joint:
                return float(position)
        return None

    def _on_current(self, message: Float64) -> None:
        self._on_command(Float64(data=self._of_current(message)))

    def _on_joints(self, message: JointState) -> None:
        position = self._of_joints(message)
        if position is not None:
            self._on_command(Float64(data=position))


def _taken(subscription: Subscription, kind: type) -> list[tuple[Any, int]]:
    """Return the messages that wait to be handled, each with the time of its sending, ns."""
    found = []
    handle = subscription.handle
    with handle:
        while (taken := handle.take_message(kind, False)) is not None:
            found.append((taken[0], taken[1]['source_timestamp']))
    return found
