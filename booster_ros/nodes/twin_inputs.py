# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a real valve publishes, plain or with time stamps, as samples for its twin."""

from collections import deque
from collections.abc import Callable, Mapping
import math
from typing import Any

from rclpy.node import Node
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Float64, Header

from ..model.gas import ATMOSPHERE
from ..twin.aligning import CHANNELS
from .tick_clock import NANOSECONDS

QUEUE_DEPTH = 1000

REMEMBERED = 400
"""Messages with stamps, and their times of publishing, that are remembered."""

FARTHEST = 1.0
"""Seconds by which the stamp of a plain message may lie before the newest one: where it would be
more, the clocks of the machines differ, and the newest stamp is taken."""

Received = Callable[[str, float, float], None]
"""Takes channel, stamp (s) and value (SI, gauge)."""


class TwinInputs:
    """
    Subscribes to every channel by its plain name, and to pressure and position with stamps too.

    Where a channel comes with stamps, its plain twin is not used, nor listened to any more: a
    message costs more than what is done with it. What has no stamp of its own
    then counts from the newest stamp that had been published before it, as the clock of the valve
    need not be that of this node; else from its arrival on the node's clock. The order of
    publishing is that of the middleware's time stamps, and is known once all have been handed
    over: a busy node is handed messages in bursts. So they wait for `flush`.
    """

    def __init__(self, node: Node, received: Received) -> None:
        self._node, self._clock = node, node.get_clock()
        self._received = received
        self._stamped: set[str] = set()
        self._newest = -math.inf
        self._waiting: list[tuple[str, int, float]] = []
        self._published: deque[tuple[int, float]] = deque(maxlen=REMEMBERED)
        subscribe: Any = node.create_subscription  # declared without the information on messages
        self._plain_ones = {
            channel: subscribe(Float64, channel, self._plain(channel), QUEUE_DEPTH)
            for channel in CHANNELS}
        subscribe(FluidPressure, 'chamber_pressure_stamped', self._on_pressure, QUEUE_DEPTH)
        subscribe(JointState, 'valve_position_stamped', self._on_position, QUEUE_DEPTH)

    def _plain(self, channel: str) -> Callable[[Float64, Mapping[str, Any]], None]:
        def receive(message: Float64, info: Mapping[str, Any]) -> None:
            if channel in self._stamped:
                return
            if self._stamped:
                self._waiting.append((channel, info['source_timestamp'], message.data))
            else:
                self._received(channel, self._clock.now().nanoseconds / NANOSECONDS, message.data)
        return receive

    def flush(self) -> None:
        """Hand on the plain messages that have come."""
        for channel in self._stamped & self._plain_ones.keys():
            self._node.destroy_subscription(self._plain_ones.pop(channel))
        waiting, self._waiting = self._waiting, []
        for channel, published, value in waiting:
            self._received(channel, self._newest_at(published), value)

    def _newest_at(self, published: int) -> float:
        """Return the newest of the stamps that had been published by then."""
        stamp = next((stamp for when, stamp in reversed(self._published) if when <= published),
                     -math.inf)
        return stamp if 0.0 <= self._newest - stamp <= FARTHEST else self._newest

    def _on_pressure(self, message: FluidPressure, info: Mapping[str, Any]) -> None:
        self._take('chamber_pressure', message.header, message.fluid_pressure - ATMOSPHERE, info)

    def _on_position(self, message: JointState, info: Mapping[str, Any]) -> None:
        if message.position:
            self._take('valve_position', message.header, message.position[0], info)

    def _take(self, channel: str, header: Header, value: float, info: Mapping[str, Any]) -> None:
        self._stamped.add(channel)
        self._newest = header.stamp.sec + header.stamp.nanosec / NANOSECONDS
        self._published.append((info['source_timestamp'], self._newest))
        self._received(channel, self._newest, value)
