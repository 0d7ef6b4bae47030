# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The pressure drop over the process valve, which pushes the stem."""

import math

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from std_msgs.msg import Float64

from ..model.simulation import Plant
from .throttle import Throttle

DEPTH = 10


class ProcessPressure:
    """
    Subscribes to `pressure_drop` (Pa) and pushes a plant with the last one that came, 0 at first.

    A value that is not finite is refused: what came before stays.
    """

    def __init__(self, node: Node, throttle: Throttle) -> None:
        self._logger = node.get_logger()
        self._throttle = throttle
        self._clock = Clock(clock_type=ClockType.STEADY_TIME)
        self._drop = 0.0
        node.create_subscription(Float64, 'pressure_drop', self._on_drop, DEPTH)

    def push(self, plant: Plant) -> None:
        """Let the process push the stem from now on."""
        plant.pressure_drop = self._drop

    def _on_drop(self, message: Float64) -> None:
        if math.isfinite(message.data):
            self._drop = message.data
        elif self._throttle.passes('pressure_drop', self._clock.now().nanoseconds):
            self._logger.warning(
                f'pressure_drop {message.data:g} Pa is refused, {self._drop:g} Pa in force')
