# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A PI controller of the stem's position: answers each position with a current."""

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from std_msgs.msg import Float64

GAIN = 0.2
"""Current by error, A/m."""

RESET_TIME = 5.0
"""Time in which a standing error doubles the answer to it, s."""

LOWEST, HIGHEST = 0.0, 6e-4
"""Range of the current, A."""

AT_REST = 4e-4
"""Current to begin with, A: the stem is about to leave its seat."""


class PiController(Node):
    """Brings the stem to `set_point` (m); `period` (s) is that of the positions."""

    def __init__(self, context=None):
        """Start with the set point that is given as a parameter."""
        super().__init__('pi_controller', context=context)
        self.set_point = self.declare_parameter('set_point', 0.0).value
        self.period = self.declare_parameter('period', 0.01).value
        self._standing = AT_REST
        self._currents = self.create_publisher(Float64, 'control_current', 10)
        self.create_subscription(Float64, 'valve_position', self._on_position, 10)

    def _on_position(self, position):
        self._currents.publish(Float64(data=self.current(position.data)))

    def current(self, position):
        """Return the current, A, for a position, m, a period after the one before."""
        error = self.set_point - position
        wanted = self._standing + GAIN * error
        current = min(max(wanted, LOWEST), HIGHEST)
        if current == wanted:  # at its limits it does not wind up
            self._standing += GAIN * error * self.period / RESET_TIME
        return current


def main():
    """Run the node until it is told to end."""
    rclpy.init()
    try:
        rclpy.spin(PiController())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == '__main__':
    main()
