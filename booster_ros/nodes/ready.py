# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Says that a node is ready, to whoever asks however late."""

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Bool

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""The last message reaches those who subscribe later as well, with the same QoS."""


class Ready:
    """Publishes `true` on `~/ready`, latched, as soon as the node handles what arrives."""

    def __init__(self, node: Node) -> None:
        """Let the first turn of the executor say it; the node is to be complete by then."""
        self._node = node
        self._publisher = node.create_publisher(Bool, '~/ready', LATCHED)
        self._timer = node.create_timer(
            0.0, self.tell, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def tell(self) -> None:
        """Say it now."""
        self._node.destroy_timer(self._timer)
        self._publisher.publish(Bool(data=True))
