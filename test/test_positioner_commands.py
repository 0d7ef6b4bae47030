# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A positioner that takes a tick for each command, and says when it is ready."""

from __future__ import annotations

from diagnostic_msgs.msg import DiagnosticArray
from positioner_process import Bench, start, state_of, with_parameters
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Bool, Float64

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def test_a_black_box_and_the_valve_alternate_without_a_handshake(ros_client):
    """The black box answers to a position; the first one comes as soon as both are there."""
    with start(*with_parameters(step_on_command='true')) as node:
        positions: list[float] = []
        publisher = ros_client.node.create_publisher(Float64, 'control_current', 10)

        def answer(message):
            positions.append(message.data)
            if len(positions) <= 100:
                publisher.publish(Float64(data=4.5e-4 if len(positions) < 80 else 4.2e-4))

        ros_client.node.create_subscription(Float64, 'valve_position', answer, 10)
        ros_client.spin_until(lambda: len(positions) == 101, 60.0)
        states = ros_client.listen('/positioner/state', DiagnosticArray)
        for _ in range(10):
            ros_client.spin_once()
        assert len(positions) == 101  # nobody commands, nothing moves
        # that of the last tick may still come; those of others would be of other times
        assert {round(100 * state_of(m)['time']) for m in states} <= {100}
        assert max(positions) > 1e-4
        assert node.interrupt() == 0, node.output


def test_each_command_is_followed_by_its_ticks_be_it_good_or_bad(ros_client):
    with start(*with_parameters(step_on_command='true', step_ticks=30)) as node:
        bench = Bench(ros_client)
        states, = bench.listen(positioner__state=DiagnosticArray)
        for current in (1e-4, 9.0, 2e-4):
            bench.command(current)
        ros_client.spin_until(lambda: len(states) >= 90)
        assert [state_of(m)['control_current'] for m in states] == [
            *[1e-4] * 60, *[2e-4] * 30]
        assert [round(100 * state_of(m)['time']) for m in states] == list(range(1, 91))
        assert bench.set(step_on_command=False).successful
        bench.command(3e-4)
        bench.step(1)
        ros_client.spin_until(lambda: len(states) >= 91)
        assert state_of(states[-1])['time'] == 0.91
        assert node.interrupt() == 0, node.output


def test_ready_is_told_to_those_who_come_late(ros_client):
    with start():
        told: list[Bool] = []
        ros_client.node.create_subscription(Bool, '/positioner/ready', told.append, LATCHED)
        ros_client.spin_until(lambda: bool(told))
        assert told[0].data
