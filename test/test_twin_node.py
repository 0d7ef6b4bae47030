# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The node `twin` beside a real positioner that plays the real valve."""

from __future__ import annotations

import sqlite3
import time

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
import numpy as np
import pytest
import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from ros_process import PATIENCE
from sensor_msgs.msg import FluidPressure
from std_msgs.msg import Float64, Header

from booster_ros.nodes.twin import TwinNode
from booster_ros.nodes.twin_inputs import TwinInputs
from booster_ros.testing import Valve
from booster_ros.testing.matching import wait_for_match

pytestmark = pytest.mark.ros

RATE = 10.0
FAST = {'block': 2.0, 'learning': 60.0, 'false_alarms': 100.0, 'history': 30.0}


def test_in_a_burst_a_current_counts_from_the_stamp_that_was_published_before_it():
    context = Context()
    rclpy.init(context=context)
    node = Node('burst', context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    received = []
    inputs = TwinInputs(node, lambda *sample: received.append(sample))
    pressure = node.create_publisher(FluidPressure, 'chamber_pressure_stamped', 1000)
    current = node.create_publisher(Float64, 'control_current', 1000)

    def handle(count):
        end = time.monotonic() + PATIENCE
        while len(received) < count:
            assert time.monotonic() < end
            executor.spin_once(timeout_sec=0.05)
            if len(received) == count - 1:
                inputs.flush()

    wait_for_match(node, node)
    for sec in range(1, 7):
        pressure.publish(FluidPressure(header=Header(stamp=Time(nanosec=sec * 10_000_000)),
                                       fluid_pressure=2e5))
        if sec in (1, 3):
            current.publish(Float64(data=4e-4))
        if sec == 1:
            handle(2)
    handle(8)
    executor.shutdown()
    node.destroy_node()
    context.try_shutdown()
    stamps = [stamp for channel, stamp, _ in received if channel == 'control_current']
    assert stamps[-1] == 0.03


class Commander(Node):
    """Sends a current to the valve and to its twin alike, over the topic."""

    def __init__(self, context) -> None:
        super().__init__('commander', context=context)
        self.sent = self.create_publisher(Float64, 'control_current', 10)
        self.health: list[str] = []
        self.create_subscription(DiagnosticArray, '/diagnostics', self._on_health, 1000)
        self.create_subscription(Float64, 'valve_position', lambda message: None, 1000)

    def _on_health(self, message: DiagnosticArray) -> None:
        self.health += [status.message for status in message.status
                        if status.name == 'twin: valve']


def moved(valve: Valve, commander: Commander, twin: TwinNode, seconds: float,
          random: np.random.Generator) -> None:
    for tick in range(round(seconds * RATE)):
        if tick % 10 == 0:
            # up and down in turn: one operating cell, soon learnt
            current = 0.42e-3 + 0.03e-3 * (tick // 10 % 2) + 0.002e-3 * random.random()
            commander.sent.publish(Float64(data=current))
        valve.step()
        if tick % 5 == 4:
            twin.turn()
    twin.report()
    valve.step()


def test_a_fault_makes_a_healthy_valve_one_that_needs_maintenance(tmp_path):
    random = np.random.default_rng(1)
    store = tmp_path / 'trends.sqlite'
    noise = {'publish_rate': RATE, 'integration_step': 0.01,
             'measurement.pressure_noise': 150.0, 'measurement.position_noise': 8e-6}
    with Valve(noise) as valve:
        twin = TwinNode(context=valve.context,
                        parameter_overrides={**FAST, 'store': str(store)})
        commander = Commander(valve.context)
        valve.add(twin)
        valve.add(commander)
        moved(valve, commander, twin, 20.0, random)
        assert commander.health[-1].startswith('function check: learning')
        # what comes with stamps is not listened to twice
        assert {'/valve_position', '/chamber_pressure'}.isdisjoint(
            one.topic_name for one in twin.subscriptions)
        moved(valve, commander, twin, 90.0, random)
        assert commander.health[-1].startswith('good'), commander.health[-1]
        valve.set({'actuator.coulomb_friction': 300.0})
        moved(valve, commander, twin, 50.0, random)
        twin.keep()
        assert commander.health[-1].startswith('maintenance required: valve_position')
        # born at the stem: nothing is said of the pressure, which its own part still explains
        assert {alarm.channel for alarm in twin.twin.latched} == {'valve_position'}
        kept = sqlite3.connect(store)
        assert kept.execute('SELECT count(*) FROM alarm').fetchone()[0] > 0
        # a slow test is overtaken by what is kept each minute: the last of each name counts
        last = dict(kept.execute('SELECT name, value FROM trend ORDER BY rowid'))
        assert 0.05 < last['way [m]'] < 10.0
        # by the history, in which the packing rubs
        assert 200.0 < last['friction [N]'] < 330.0
