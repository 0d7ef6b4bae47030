# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of controllers with `booster_ros.testing`: same bits, whoever controls and wherever."""

from __future__ import annotations

import os

import pytest
from rclpy.node import Node
from ros_process import RosProcess, program
from std_msgs.msg import Float64

from booster_ros.control.pi import PiController
from booster_ros.model.simulation import Plant
from booster_ros.model.system import PositionerParameters
from booster_ros.programs.ros_domain import claim_domain
from booster_ros.testing import Band, RemoteValve, Sample, Series, Valve

CURRENT = 0.4524e-3


def loop() -> PiController:
    return PiController(0.2, 5.0, 0.0, 6e-4, 4e-4)


class Loop(Node):
    """Answers each position with a current that is to bring the stem to 8 mm."""

    def __init__(self, context, name='loop'):
        super().__init__(name, context=context)
        self._pi = loop()
        self._currents = self.create_publisher(Float64, 'control_current', 10)
        self.create_subscription(Float64, 'valve_position', self._on_position, 10)

    def _on_position(self, message: Float64) -> None:
        self._currents.publish(Float64(data=self._pi.update(0.008 - message.data, 0.01)))


def controlled_by_function(valve, seconds):
    pi = loop()
    valve.run(seconds, lambda sample: pi.update(0.008 - sample.valve_position, 0.01))
    return valve.series.tobytes()


def test_a_run_is_the_model_bit_by_bit():
    plant = Plant(PositionerParameters())
    with Valve() as valve:
        valve.send(CURRENT)
        valve.run(1.0)
        for _ in range(100):
            plant.advance(CURRENT, 10)
        assert valve.now == Sample(1.0, CURRENT, *plant.readings())
        assert len(valve.series) == 101
        assert valve.reset() == valve.now == Sample(0.0, 0.0, 0.0, valve.now.valve_position)
        assert len(valve.series) == 1


def test_function_node_and_another_process_control_to_the_same_bits():
    seconds = 1.5
    with Valve() as valve:
        by_function = controlled_by_function(valve, seconds)
        assert valve.now.valve_position > 1e-3
        valve.reset()
        assert controlled_by_function(valve, seconds) == by_function
    with Valve() as valve:
        valve.add(Loop(valve.context))
        valve.run(seconds)
        assert valve.series.tobytes() == by_function
    domain = claim_domain()
    environment = {**os.environ, 'ROS_DOMAIN_ID': str(domain.id)}
    with RosProcess(program('positioner'), environment), RemoteValve(domain=domain.id) as valve:
        assert controlled_by_function(valve, seconds) == by_function
        valve.reset()
        assert controlled_by_function(valve, seconds) == by_function
        assert any('ticks per second' in line for line in valve.collect_log())
    domain.release()


def test_settled_is_what_stays_within_its_band():
    with Valve() as valve:
        valve.send(CURRENT)
        settled = valve.settle()
        assert settled.valve_position == pytest.approx(0.0128, abs=2e-4)
        assert settled.time > 1.0
        last = valve.series.since(settled.time - 0.985)
        assert len(last) == 100 - 1
        for column, half in Band()._asdict().items():
            assert last[column].max() - last[column].min() <= 2.0 * half
        valve.send(0.0)
        with pytest.raises(AssertionError, match=r'not settled after 1 s: .*chamber_pressure mov'):
            valve.settle(timeout=1.0, hold=0.5)


def test_parameters_are_set_while_it_runs_and_refused_with_the_reason():
    with Valve({'supply.pressure': 300e3}) as valve:
        valve.set({'supply.pressure': 410e3})
        assert valve.positioner.get_parameter('supply.pressure').value == 410e3
        with pytest.raises(AssertionError, match=r'booster\.s1 .* must be greater'):
            valve.set({'booster.s2': 1.0})


def test_several_valves_live_side_by_side():
    with Valve() as one, Valve({'publish_rate': 50.0}) as another:
        assert one.domain != another.domain
        one.send(CURRENT)
        one.run(0.5)
        another.run(0.5)
        assert one.now.chamber_pressure > 50e3
        assert (another.now.chamber_pressure, another.now.time) == (0.0, 0.5)


def test_a_node_that_shares_no_topic_is_no_controller():
    with Valve(namespace='/line') as valve:
        node = Loop(valve.context)
        with pytest.raises(AssertionError, match=r'/loop shares no topic with /line/positioner'):
            valve.add(node)
        node.destroy_node()


def test_what_a_node_raises_ends_the_test():
    class Broken(Loop):
        def _on_position(self, message):
            raise ZeroDivisionError

    with Valve() as valve, pytest.raises(ZeroDivisionError):
        valve.add(Broken(valve.context))


def test_assertions_on_a_series_say_when_and_by_how_much():
    series = Series()
    for k in range(5):
        series.append(Sample(0.1 * k, 1e-4, 1e5, 1e-3 * k))
    series.assert_between('valve_position', 0.0, 4e-3)
    with pytest.raises(AssertionError, match=r'valve_position is 0\.003 at 0\.3 s, outside 0 to 0'):
        series.assert_between('valve_position', 0.0, 2.5e-3)
    assert series.assert_reaches('valve_position', 2.1e-3, 2e-4) == pytest.approx(0.2)
    with pytest.raises(AssertionError, match=r'the nearest was 0\.004 at 0\.4 s'):
        series.assert_reaches('valve_position', 8e-3, 1e-4)
    assert list(series.since(0.25)['valve_position']) == pytest.approx([3e-3, 4e-3])
