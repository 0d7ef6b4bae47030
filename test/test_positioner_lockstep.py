# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A paused positioner steps exactly as told, and does exactly what the model does."""

from __future__ import annotations

import itertools

from diagnostic_msgs.msg import DiagnosticArray
from positioner_here import positioner_here
from positioner_process import Bench, details, report_of, start, state_of, with_parameters
import numpy as np
import pytest
from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor
from ros_client import RosClient
from ros_process import PATIENCE
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Float64
from std_srvs.srv import Trigger

from booster_ros.model.simulation import Plant
from booster_ros.model.system import PositionerParameters

CURRENT = 0.4524e-3


AT_REST = {
    'initial_state__chamber_pressure': 0.0,
    'initial_state__valve_position': -1.0,
    'initial_state__control_current': 0.0,
    'command_timeout': 0.0,
    'stale_command': 'hold',
}


@pytest.fixture(scope='module')
def shared_bench():
    with start(*with_parameters(start_paused='true')) as node, RosClient() as client:
        yield Bench(client)
        assert node.interrupt() == 0, node.output


@pytest.fixture
def bench(shared_bench):
    assert shared_bench.set(**AT_REST).successful
    shared_bench.pause(True)
    shared_bench.trigger('reset')
    yield shared_bench
    shared_bench.client.forget()


def played(bench, ticks=40):
    """Return the pressures of a lockstep run: rest, a step, zero again."""
    pressures, = bench.listen(chamber_pressure=Float64)
    bench.trigger('reset')
    for current in (0.0, CURRENT, 0.0):
        bench.command(current)
        bench.step(ticks)
    bench.client.spin_until(lambda: len(pressures) >= 3 * ticks + 1)
    return [message.data for message in pressures]


def test_lockstep_is_the_model_bit_by_bit(bench):
    plant = Plant(PositionerParameters())
    expected = [0.0]
    for current in (0.0, CURRENT, 0.0):
        for _ in range(40):
            plant.advance(current, 10)
            expected.append(plant.outputs().measured_chamber_pressure)
    assert played(bench) == expected
    assert max(expected) > 100e3


def test_two_runs_are_bit_identical(bench):
    first = played(bench)
    assert len(first) == 121
    bench.client.forget()
    assert first == played(bench)


def test_each_tick_is_published_on_every_topic_one_period_apart(bench):
    pressures, positions, states = bench.listen(
        chamber_pressure_stamped=FluidPressure, valve_position_stamped=JointState,
        positioner__state=DiagnosticArray)
    bench.command(CURRENT)
    bench.step(25)
    bench.step(25)
    bench.client.spin_until(lambda: min(map(len, (pressures, positions, states))) >= 50)
    assert len(pressures) == len(positions) == len(states) == 50

    last = state_of(states[-1])
    assert last['time'] == 0.5
    assert last['control_current'] == CURRENT
    assert 101_325 + last['chamber_pressure'] == pressures[-1].fluid_pressure
    assert (positions[-1].name, list(positions[-1].position)) == (
        ['valve_stem'], [last['valve_position']])
    assert list(positions[-1].velocity) == [last['stem_velocity']]
    stamps = [p.header.stamp.sec * 10**9 + p.header.stamp.nanosec for p in pressures]
    within_a_call = stamps[24] - stamps[0]
    assert within_a_call == 24 * 10_000_000
    assert [p.header.stamp for p in pressures] == [p.header.stamp for p in positions]


def test_stamps_of_a_step_are_even_though_the_clocks_are_read_again(monkeypatch):
    """A step in portions between which the offset of the node's clock is known better."""
    offsets = itertools.count(10**18, 20)
    with positioner_here('-p', 'start_paused:=true') as node:
        monkeypatch.setattr(node._time, 'stamp_offset', lambda: next(offsets))
        stamps = []
        monkeypatch.setattr(node, '_publish', lambda stamp, thinned=False: stamps.append(stamp))
        count = 3 * node._ticks.piece
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        executor.spin_until_future_complete(
            executor.create_task(node._stepping.advance, count), PATIENCE)
        executor.shutdown()
    assert len(stamps) == count
    assert set(np.diff(stamps)) == {10_000_000}


def test_the_state_names_every_output_and_its_unit(bench):
    states, = bench.listen(positioner__state=DiagnosticArray)
    bench.step(1)
    bench.client.spin_until(lambda: len(states) > 0)
    assert set(state_of(states[0])) == set(Plant(PositionerParameters()).outputs()._fields)
    assert 'mass_flow kg/s' in states[0].status[0].message


def test_a_reset_goes_to_the_given_state(bench):
    states, = bench.listen(positioner__state=DiagnosticArray)
    bench.step(3)
    assert bench.set(
        initial_state__chamber_pressure=225e3, initial_state__valve_position=0.004,
        initial_state__control_current=CURRENT).successful
    bench.trigger('reset')
    bench.client.spin_until(lambda: len(states) >= 4)
    state = state_of(states[-1])
    assert (state['time'], state['chamber_pressure'], state['valve_position']) == (
        0.0, 225e3, 0.004)
    assert state['control_current'] == CURRENT
    assert state['back_pressure'] == pytest.approx(244.45e3)


def test_a_command_that_came_before_a_reset_is_not_in_force_after_it(ros_client):
    with positioner_here(*with_parameters(start_paused='true')) as node:
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        publisher = ros_client.node.create_publisher(Float64, 'control_current', 1)
        ros_client.spin_until(lambda: publisher.get_subscription_count() > 0)
        ros_client.spin_until(lambda: node.count_publishers('control_current') > 0)
        publisher.publish(Float64(data=CURRENT))
        assert publisher.wait_for_all_acked(Duration(seconds=PATIENCE))
        # Nothing has been spun: the executor has found the request first, as it can.
        assert node._on_reset(Trigger.Request(), Trigger.Response()).success
        for _ in range(20):
            executor.spin_once(timeout_sec=0.02)
        executor.create_task(node._on_step, Trigger.Request(), Trigger.Response())
        executor.spin_once(timeout_sec=1.0)
        assert node._ticks.ticks == 1
        assert node._plant.outputs().control_current == 0.0
        assert node._guard.accepted == 1  # it had arrived
        executor.shutdown()


def test_a_reset_without_a_position_lets_the_spring_find_it(bench):
    positions, = bench.listen(valve_position=Float64)
    assert bench.set(initial_state__chamber_pressure=225e3).successful
    bench.trigger('reset')
    bench.client.spin_until(lambda: len(positions) >= 1)
    assert positions[0].data == pytest.approx(0.008, abs=1e-9)


@pytest.mark.parametrize(('policy', 'current'), [('hold', CURRENT), ('vent', 0.0)])
def test_a_command_goes_stale_after_its_timeout(bench, policy, current):
    diagnostics = bench.client.listen('/diagnostics', DiagnosticArray)
    states, = bench.listen(positioner__state=DiagnosticArray)
    assert bench.set(command_timeout=0.1, stale_command=policy).successful
    bench.command(CURRENT)
    bench.step(15)
    bench.client.spin_until(lambda: len(states) >= 15)
    currents = [state_of(message)['control_current'] for message in states]
    assert currents[:11] == [CURRENT] * 11
    assert currents[11:] == [current] * 4
    bench.client.spin_until(
        lambda: any(report_of(m, 'command').message.startswith('stale') for m in diagnostics))
    bench.command(2e-4)
    bench.step(1)
    bench.client.spin_until(lambda: len(states) >= 16)
    assert state_of(states[-1])['control_current'] == 2e-4


def test_new_current_limits_limit_the_current_in_force_from_the_next_tick(bench):
    states, = bench.listen(positioner__state=DiagnosticArray)
    bench.command(1.9e-3)
    bench.step(1)
    assert bench.set(current_limits=[0.0, 1e-3]).successful
    bench.step(1)
    assert bench.set(current_limits=[0.0, 2e-3]).successful
    bench.client.spin_until(lambda: len(states) >= 2)
    assert [state_of(message)['control_current'] for message in states] == [1.9e-3, 1e-3]


def test_while_paused_nothing_moves_and_diagnostics_say_so(bench):
    diagnostics = bench.client.listen('/diagnostics', DiagnosticArray)
    bench.client.spin_until(lambda: len(diagnostics) >= 2)
    times = {details(report_of(m, 'time'))['simulated time [s]'] for m in diagnostics}
    assert times == {'0.000000000'}
    assert report_of(diagnostics[-1], 'time').message == 'paused by ~/pause'


def test_after_a_pause_ticks_go_on_where_they_stood(bench):
    states, = bench.listen(positioner__state=DiagnosticArray)
    bench.step(5)
    assert bench.pause(False).message == 'running'
    bench.client.spin_until(lambda: len(states) >= 8)
    assert [state_of(state)['time'] for state in states[:8]] == pytest.approx(
        [0.01 * (k + 1) for k in range(8)])


def test_only_a_paused_positioner_steps(bench):
    bench.pause(False)
    response = bench.trigger('step')
    assert not response.success
    assert '~/pause' in response.message
