# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A positioner that holds its position: set points from three topics, and what is said of them."""

from __future__ import annotations

from controller_here import played
from diagnostic_msgs.msg import DiagnosticArray
import numpy as np
from positioner_here import positioner_here
from positioner_process import Bench, details, report_of, start, state_of, with_parameters
import pytest
from rclpy.duration import Duration
from ros_client import RosClient
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from booster_ros.model.controlled_plant import make_plant
from booster_ros.model.parameters import from_values
from booster_ros.nodes.deviation import TravelDeviation
from booster_ros.records import read_record

TRAVEL = 0.016
STEP = 0.01
"""Integration step, s: a tick each."""
LOOP = from_values({'position_controller.enabled': True})


def arguments(**others: object) -> list[str]:
    """Return the arguments for a paused positioner whose controller holds 4 mm."""
    return with_parameters(
        position_controller__enabled='true', initial_state__chamber_pressure=187500.0,
        initial_state__valve_position=0.004, start_paused='true',
        integration_step=STEP, **others)


@pytest.fixture(scope='module')
def shared_bench():
    with start(*arguments()) as node, RosClient() as client:
        yield Bench(client)
        assert node.interrupt() == 0, node.output


@pytest.fixture
def bench(shared_bench):
    assert shared_bench.set(
        command_timeout=0.0, stale_command='hold', actuator__plug_area=0.0,
        deviation_delay=10.0).successful
    shared_bench.pause(True)
    shared_bench.trigger('reset')
    yield shared_bench
    shared_bench.client.forget()


PUBLISHERS: dict = {}


def publish(bench, kind, topic, **fields):
    """Publish one message, and wait until the positioner has it."""
    # With a queue of one DDS asks for the acknowledgement at once.
    publisher = PUBLISHERS.setdefault(topic, bench.client.node.create_publisher(kind, topic, 1))
    bench.client.spin_until(lambda: publisher.get_subscription_count() > 0)
    publisher.publish(kind(**fields))
    assert publisher.wait_for_all_acked(Duration(seconds=20))


def model_after(set_point, ticks):
    """Return the position that the model has so long after a step of the set point."""
    plant = make_plant(LOOP, STEP)
    plant.reset(187.5e3, 0.004)
    plant.advance(set_point, ticks)
    return plant.readings()[1]


@pytest.mark.parametrize(('kind', 'topic', 'fields'), [
    (Float64, 'set_point', {'data': 0.006}),
    (Float64, 'set_point_current', {'data': 0.010}),
    (JointState, 'joint_commands', {'name': ['arm', 'valve_stem'], 'position': [1.0, 0.006]}),
], ids=['m', 'A', 'joint'])
def test_a_set_point_moves_the_stem_as_in_the_model(bench, kind, topic, fields):
    positions, = bench.listen(valve_position=Float64)
    publish(bench, kind, topic, **fields)
    bench.step(100)
    bench.client.spin_until(lambda: len(positions) >= 100)
    assert positions[-1].data == model_after(0.006, 100)
    assert positions[-1].data > 0.0055


def last_report(bench, reports, task):
    """Return the last status on a task, after one that comes now."""
    reports.clear()
    bench.client.spin_until(lambda: len(reports) > 0)
    return report_of(reports[-1], task)


def test_the_last_that_came_counts_and_other_joints_do_not(bench):
    states, = bench.listen(positioner__state=DiagnosticArray)
    publish(bench, JointState, 'joint_commands', name=['valve_stem'], position=[0.005])
    bench.step(1)
    publish(bench, Float64, 'set_point', data=0.006)
    bench.step(1)
    publish(bench, JointState, 'joint_commands', name=['arm'], position=[0.007])
    publish(bench, JointState, 'joint_commands', name=['valve_stem'])
    bench.step(1)
    bench.client.spin_until(lambda: len(states) >= 3)
    assert [state_of(state)['set_point'] for state in states] == [0.005, 0.006, 0.006]
    assert state_of(states[-1])['control_current'] > 0.43e-3


@pytest.mark.parametrize('bad', [float('nan'), 8.0, -0.001])
def test_a_set_point_that_cannot_be_meant_is_refused(bench, bad):
    reports = bench.client.listen('/diagnostics', DiagnosticArray)
    publish(bench, Float64, 'set_point', data=0.005)
    publish(bench, Float64, 'set_point', data=bad)
    bench.step(1)
    values = details(last_report(bench, reports, 'command'))
    assert values['set point in force [m]'] == '0.005'
    assert sum(int(count) for name, count in values.items() if name.startswith('refused')) > 0


def test_a_stale_set_point_is_vented_where_that_is_asked_for(bench):
    assert bench.set(command_timeout=0.5, stale_command='vent').successful
    states, = bench.listen(positioner__state=DiagnosticArray)
    publish(bench, Float64, 'set_point', data=0.005)
    bench.step(250)
    bench.client.spin_until(lambda: len(states) >= 250)
    assert state_of(states[40])['control_current'] > 0.4e-3
    assert state_of(states[-1])['control_current'] == 0.0
    assert state_of(states[-1])['chamber_pressure'] < 150e3
    publish(bench, Float64, 'set_point', data=0.005)
    bench.step(1)
    bench.client.spin_until(lambda: len(states) >= 251)
    assert state_of(states[-1])['control_current'] > 0.4e-3


def test_a_travel_deviation_that_lasts_is_a_warning(bench):
    """A valve that is commanded beyond what its supply can move stays where it is."""
    reports = bench.client.listen('/diagnostics', DiagnosticArray)
    assert bench.set(deviation_delay=1.0).successful
    publish(bench, Float64, 'set_point', data=0.012)
    bench.step(50)
    assert last_report(bench, reports, 'travel').level == b'\x00'
    assert bench.set(supply__pressure=150e3).successful
    bench.step(300)
    status = last_report(bench, reports, 'travel')
    assert status.level == b'\x01'
    assert 'off the set point by' in status.message
    assert float(details(status)['travel deviation [m]']) > 0.05 * TRAVEL
    assert bench.set(supply__pressure=400e3).successful


def test_a_pressure_drop_pushes_the_stem(bench):
    assert bench.set(actuator__plug_area=2e-3).successful
    positions, = bench.listen(valve_position=Float64)
    publish(bench, Float64, 'pressure_drop', data=2e5)
    publish(bench, Float64, 'pressure_drop', data=float('nan'))
    bench.step(20)
    bench.client.spin_until(lambda: len(positions) >= 20)
    plant = make_plant(from_values({'position_controller.enabled': True,
                                    'actuator.plug_area': 2e-3}), STEP)
    plant.reset(187.5e3, 0.004)
    plant.pressure_drop = 2e5
    plant.advance(0.004, 20)
    assert positions[-1].data == plant.readings()[1] < 3.99e-3
    publish(bench, Float64, 'pressure_drop', data=0.0)


def test_a_current_is_no_input_and_the_controller_stays_on(bench):
    assert bench._commands.get_subscription_count() == 0
    result = bench.set(position_controller__enabled=False)
    assert not result.successful
    assert 'position_controller.enabled' in result.reason


@pytest.mark.parametrize(('given', 'joint', 'frame'), [
    ([], 'line_a_valve_stem', 'line_a_positioner'),
    (['-p', 'joint_name:=v7', '-p', 'frame_id:=flange'], 'v7', 'flange')])
def test_joints_and_frames_are_told_apart_by_their_namespace(given, joint, frame):
    with positioner_here('-r', '__ns:=/line_a', *given) as node:
        message = node._outputs._position_of(node._plant.outputs(), node._outputs._header(0))
        assert (message.name, message.header.frame_id) == ([joint], frame)


def test_an_alarm_comes_after_the_delay_and_goes_at_once():
    watch = TravelDeviation(band=1e-3, delay=2.0)
    changes = [watch.note(deviation, time) for deviation, time in (
        (2e-3, 0.0), (-2e-3, 1.9), (-2e-3, 2.0), (-2e-3, 3.0), (0.5e-3, 3.1), (2e-3, 4.0))]
    assert changes == [False, False, True, False, True, False]
    assert not watch.alarm


def test_the_fake_controller_plays_set_points_and_records_them(tmp_path, bench):
    assert bench.set(step_ticks=1).successful
    csv, bag = tmp_path / 'record.csv', tmp_path / 'record'
    assert played(mode='set_point', levels=[0.004, 0.006], dwell=1.0, lockstep=True,
                  record_csv=csv, record_bag=bag) == ''
    record = read_record(csv)
    assert list(record.columns) == ['time', 'set_point', 'chamber_pressure', 'valve_position']
    assert set(record['set_point']) == {0.004, 0.006}
    assert len(record) == 201
    plant = make_plant(LOOP, STEP)
    plant.reset(187.5e3, 0.004)
    for set_point, position in zip(record['set_point'], record['valve_position']):
        assert position == pytest.approx(plant.readings()[1], abs=1e-8)
        plant.advance(set_point, 1)
    from_bag = read_record(bag)
    np.testing.assert_allclose(from_bag['set_point'], record['set_point'], atol=1e-9)
