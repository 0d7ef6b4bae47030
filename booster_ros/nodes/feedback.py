# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What comes back from a positioner: its outputs, from the plain topics or their stamped twins."""

from collections.abc import Callable

from rclpy.node import Node
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Float64, Header

from ..model.gas import ATMOSPHERE
from .node_time import NodeTime
from .tick_clock import NANOSECONDS

QUEUE_DEPTH = 1000
"""Messages that may wait while the node is busy."""

Received = Callable[[str, float, int], None]


class Feedback:
    """
    Calls `received` with column, value (Pa gauge, m) and stamp (ns) of each output that arrives.

    The stamp is the time of reception, or the one in the header of the stamped twins.
    """

    def __init__(self, node: Node, time: NodeTime, stamped: bool, received: Received) -> None:
        self._node = node
        self._time = time
        self._received = received
        if stamped:
            pressure = node.create_subscription(
                FluidPressure, 'chamber_pressure_stamped', self._on_stamped_pressure, QUEUE_DEPTH)
            position = node.create_subscription(
                JointState, 'valve_position_stamped', self._on_stamped_position, QUEUE_DEPTH)
        else:
            pressure = node.create_subscription(
                Float64, 'chamber_pressure', self._on_pressure, QUEUE_DEPTH)
            position = node.create_subscription(
                Float64, 'valve_position', self._on_position, QUEUE_DEPTH)
        self._subscriptions = (pressure, position)

    def missing_topics(self) -> list[str]:
        """Return the topics that nobody publishes."""
        return [
            subscription.topic_name for subscription in self._subscriptions
            if not subscription.get_publisher_count()
        ]

    def crowded_topics(self) -> list[str]:
        """Return the topics that several nodes publish, each with the names of these nodes."""
        crowds = {one.topic_name: self._publishers(one.topic_name) for one in self._subscriptions}
        return [f'{topic} ({", ".join(nodes)})' for topic, nodes in crowds.items()
                if len(nodes) > 1]

    def publishers(self) -> set[str]:
        """Return the names of the nodes that publish the outputs."""
        return {name for one in self._subscriptions for name in self._publishers(one.topic_name)}

    def _publishers(self, topic: str) -> list[str]:
        return sorted(f'{info.node_namespace.rstrip("/")}/{info.node_name}'
                      for info in self._node.get_publishers_info_by_topic(topic))

    def _now(self) -> int:
        return self._time.now() + self._time.stamp_offset()

    def _on_pressure(self, message: Float64) -> None:
        self._received('chamber_pressure', message.data, self._now())

    def _on_position(self, message: Float64) -> None:
        self._received('valve_position', message.data, self._now())

    def _on_stamped_pressure(self, message: FluidPressure) -> None:
        pressure = message.fluid_pressure - ATMOSPHERE
        self._received('chamber_pressure', pressure, _stamp(message.header))

    def _on_stamped_position(self, message: JointState) -> None:
        if message.position:
            self._received('valve_position', message.position[0], _stamp(message.header))


def _stamp(header: Header) -> int:
    return header.stamp.sec * NANOSECONDS + header.stamp.nanosec
