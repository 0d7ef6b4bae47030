# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a real valve publishes, plain or with time stamps, as samples for its twin."""

from collections.abc import Callable
import math

from rclpy.node import Node
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Float64, Header

from ..model.gas import ATMOSPHERE
from ..twin.aligning import CHANNELS
from .tick_clock import NANOSECONDS

QUEUE_DEPTH = 1000

Received = Callable[[str, float, float], None]
"""Takes channel, stamp (s) and value (SI, gauge)."""


class TwinInputs:
    """
    Subscribes to every channel by its plain name, and to pressure and position with stamps too.

    Where a channel comes with stamps, its plain twin is not used. What has no stamp of its own
    then counts from the newest stamp on, as the clock of the valve need not be that of this node;
    else from its arrival on the node's clock.
    """

    def __init__(self, node: Node, received: Received) -> None:
        self._clock = node.get_clock()
        self._received = received
        self._stamped: set[str] = set()
        self._newest = -math.inf
        for channel in CHANNELS:
            node.create_subscription(
                Float64, channel, self._plain(channel), QUEUE_DEPTH)
        node.create_subscription(
            FluidPressure, 'chamber_pressure_stamped', self._on_pressure, QUEUE_DEPTH)
        node.create_subscription(
            JointState, 'valve_position_stamped', self._on_position, QUEUE_DEPTH)

    def _plain(self, channel: str) -> Callable[[Float64], None]:
        def receive(message: Float64) -> None:
            if channel not in self._stamped:
                stamp = self._newest if self._stamped else (
                    self._clock.now().nanoseconds / NANOSECONDS)
                self._received(channel, stamp, message.data)
        return receive

    def _on_pressure(self, message: FluidPressure) -> None:
        self._take('chamber_pressure', message.header, message.fluid_pressure - ATMOSPHERE)

    def _on_position(self, message: JointState) -> None:
        if message.position:
            self._take('valve_position', message.header, message.position[0])

    def _take(self, channel: str, header: Header, value: float) -> None:
        self._stamped.add(channel)
        self._newest = header.stamp.sec + header.stamp.nanosec / NANOSECONDS
        self._received(channel, self._newest, value)
