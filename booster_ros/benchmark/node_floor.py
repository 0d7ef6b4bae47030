# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What rclpy itself costs: a node whose timer only publishes what the positioner publishes."""

import sys

from rclpy.node import Node
from std_msgs.msg import Float64

from ..nodes.process import run


class Floor(Node):
    """Publishes two constants at the rate of its parameter `publish_rate`, Hz."""

    def __init__(self) -> None:
        super().__init__('floor')
        rate = self.declare_parameter('publish_rate', 100.0).value
        self._pressure = self.create_publisher(Float64, 'chamber_pressure', 1000)
        self._position = self.create_publisher(Float64, 'valve_position', 1000)
        self.create_timer(1.0 / rate, self._publish)

    def _publish(self) -> None:
        self._pressure.publish(Float64(data=270.3e3))
        self._position.publish(Float64(data=0.0128))


if __name__ == '__main__':
    sys.exit(run('floor', __doc__, Floor, sys.argv[1:]))
