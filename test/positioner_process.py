# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The node `positioner` in a process of its own, and what tests say to it."""

from __future__ import annotations

import contextlib
import signal
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.srv import SetParametersAtomically
from rclpy.duration import Duration
from rclpy.parameter import Parameter
from ros_client import RosClient
from ros_process import PATIENCE, RosProcess, program
from std_msgs.msg import Float64
from std_srvs.srv import SetBool, Trigger


def start(*ros_arguments: str) -> RosProcess:
    """Start a positioner with these arguments for ROS and wait until it runs."""
    node = RosProcess(program('positioner', '--ros-args', *ros_arguments))
    try:
        node.wait_for('ticks per second', 60.0)
    except AssertionError:
        node.send(signal.SIGKILL)  # nobody has it yet, to end it
        raise
    return node


def with_parameters(**values: object) -> list[str]:
    """Return the arguments that give parameters; `a__b` stands for `a.b`."""
    return [
        text for name, value in values.items()
        for text in ('-p', f'{name.replace("__", ".")}:={value}')
    ]


class Bench:
    """A client that commands, steps and sets one positioner."""

    def __init__(self, client: RosClient, name: str = 'positioner'):
        """Talk to the positioner of this name in the root namespace."""
        self.client = client
        self.name = name
        # With a queue of one DDS asks for the acknowledgement at once, else every three seconds.
        self._commands = client.node.create_publisher(Float64, 'control_current', 1)

    def command(self, current: float) -> None:
        """Command a current, A, and wait until the node has it."""
        self.client.spin_until(lambda: self._commands.get_subscription_count() > 0)
        self._commands.publish(Float64(data=current))
        assert self._commands.wait_for_all_acked(Duration(seconds=PATIENCE))

    def trigger(self, service: str) -> Trigger.Response:
        """Call ~/reset or ~/step."""
        attempts = 1 if service == 'step' else 3  # a step asked for twice may be taken twice
        return self.client.call(f'{self.name}/{service}', Trigger, Trigger.Request(), attempts)

    def pause(self, paused: bool) -> SetBool.Response:
        """Pause or go on."""
        return self.client.call(f'{self.name}/pause', SetBool, SetBool.Request(data=paused))

    def set(self, **values: Any) -> Any:
        """Set parameters together (`a__b` stands for `a.b`) and return the result."""
        parameters = [
            Parameter(name.replace('__', '.'), value=value).to_parameter_msg()
            for name, value in values.items()
        ]
        request = SetParametersAtomically.Request(parameters=parameters)
        return self.client.call(
            f'{self.name}/set_parameters_atomically', SetParametersAtomically, request).result

    def step(self, ticks: int) -> None:
        """Advance a paused positioner by so many ticks."""
        assert self.set(step_ticks=ticks).successful
        response = self.trigger('step')
        assert response.success, response.message

    def listen(self, **kinds: type) -> list[list[Any]]:
        """
        Subscribe to topics of a paused positioner; return a list of messages, still empty, of each.

        A subscription may know its publisher before the publisher knows it, and what is published
        in between is lost. A reset publishes once: when that has come, all that follows will.
        """
        received = [self.client.listen(topic.replace('__', '/'), kind)
                    for topic, kind in kinds.items()]
        while not all(received):
            self.trigger('reset')
            with contextlib.suppress(AssertionError):
                self.client.spin_until(lambda: all(received), timeout=5.0)
        for messages in received:
            messages.clear()
        return received


def state_of(message: DiagnosticArray) -> dict[str, float]:
    """Return the fields of a message from ~/state."""
    return {entry.key: float(entry.value) for entry in message.status[0].values}


def report_of(message: DiagnosticArray, task: str) -> Any:
    """Return one status of a message from /diagnostics."""
    return next(status for status in message.status if status.name.endswith(f': {task}'))


def details(status: Any) -> dict[str, str]:
    """Return the details of a status."""
    return {entry.key: entry.value for entry in status.values}
