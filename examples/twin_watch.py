# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Listens to a twin, and adopts the model that a diagnosis has found once it is confirmed."""

from diagnostic_msgs.msg import DiagnosticStatus
import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String
from std_srvs.srv import Trigger

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""What was said last comes to those who ask later as well."""


class TwinWatch(Node):
    """Logs what the twin says; the parameter `twin` is its name."""

    def __init__(self, context=None):
        """Subscribe to alarms and verdicts."""
        super().__init__('twin_watch', context=context)
        name = self.declare_parameter('twin', 'twin').value
        self._adopt = self.create_client(Trigger, f'{name}/adopt')
        self.create_subscription(String, f'{name}/alarm', self._on_alarm, LATCHED)
        self.create_subscription(DiagnosticStatus, f'{name}/verdict', self._on_verdict, LATCHED)

    def _on_alarm(self, alarm):
        self.get_logger().info(f'alarm: {alarm.data}')

    def _on_verdict(self, verdict):
        values = {entry.key: entry.value for entry in verdict.values}
        self.get_logger().info(f'verdict: {verdict.message}')
        if values['adoption']:
            self.get_logger().info(f'the found model: {values["adoption"]}')
        elif values['standing'] == 'confirmed':
            self._adopt.call_async(Trigger.Request()).add_done_callback(self._on_answer)

    def _on_answer(self, future):
        self.get_logger().info(future.result().message)


def main():
    """Run the node until it is told to end."""
    rclpy.init()
    try:
        rclpy.spin(TwinWatch())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == '__main__':
    main()
