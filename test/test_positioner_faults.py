# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Faults of a running positioner: injected and cleared by services, and told on topics."""

from __future__ import annotations

from diagnostic_msgs.msg import DiagnosticArray
from positioner_here import positioner_here
from positioner_process import Bench, report_of, start, state_of, with_parameters
import pytest
from rcl_interfaces.srv import SetParametersAtomically
from rclpy.parameter import Parameter, get_parameter_value
from rclpy.qos import DurabilityPolicy, QoSProfile
from ros_client import RosClient
from ros_process import RosProcess, program
from std_msgs.msg import Float64

from booster_ros.faults.injection import injection
from booster_ros.faults.sensing import Imperfection, Sensor
from booster_ros.model.parameters import ParameterError, from_values
from booster_ros.model.simulation import Plant
from booster_ros.testing import Valve

CURRENT = 0.4524e-3
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


@pytest.fixture(scope='module')
def shared_bench():
    with start(*with_parameters(start_paused='true')) as node, RosClient() as client:
        yield Bench(client)
        assert node.interrupt() == 0, node.output
        assert 'Traceback' not in node.output


@pytest.fixture
def bench(shared_bench):
    shared_bench.trigger('reset')
    yield shared_bench
    shared_bench.client.forget()


def inject(bench, **fields):
    request = SetParametersAtomically.Request(parameters=[
        Parameter(name.replace('__', '.'), value=value).to_parameter_msg()
        for name, value in fields.items()])
    return bench.client.call('positioner/inject', SetParametersAtomically, request).result


def told(bench):
    """Return what a late listener hears of the faults: names and courses."""
    heard: list[DiagnosticArray] = []
    bench.client.node.create_subscription(
        DiagnosticArray, 'positioner/faults', heard.append, LATCHED)
    bench.client.spin_until(lambda: bool(heard))
    return {status.name: status.message for status in heard[-1].status}


def test_a_fault_is_on_from_the_next_tick_until_it_is_cleared(bench):
    states, = bench.listen(positioner__state=DiagnosticArray)
    diagnostics = bench.client.listen('/diagnostics', DiagnosticArray)
    bench.command(CURRENT)
    bench.step(10)
    assert told(bench) == {}
    assert inject(bench, fault='f9', parameters__actuator__leak_area=1e-6).reason == (
        'chamber_leak, strength 1')
    assert inject(bench, fault='stem_friction', strength='big', ramp=10.0).successful
    bench.step(10)
    assert told(bench) == {'chamber_leak': 'on', 'stem_friction': 'growing'}
    bench.client.spin_until(lambda: any(
        report_of(m, 'faults').message == 'on: chamber_leak, stem_friction' for m in diagnostics))
    assert bench.trigger('clear').message == 'cleared: chamber_leak, stem_friction'
    assert told(bench) == {}
    bench.step(10)
    bench.client.spin_until(lambda: len(states) == 30)
    assert [message.status[1].message for message in states] == [
        *[''] * 10, *['chamber_leak, stem_friction'] * 10, *[''] * 10]

    plant = Plant(from_values({}))
    expected = []
    for tick in range(30):
        fault = {'actuator.leak_area': 1e-6, 'actuator.coulomb_friction': 1200.0 * (
            0.01 * (tick - 10) / 10.0), 'actuator.stiction': 400.0 * (0.01 * (tick - 10) / 10.0)}
        now = from_values(fault if 10 <= tick < 20 else {})
        if now != plant.parameters:
            plant.parameters = now
        plant.advance(CURRENT, 10)
        expected.append(plant.outputs().chamber_pressure)
    assert [state_of(m)['chamber_pressure'] for m in states] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(('fields', 'reason'), [
    ({'fault': 'stem_fricton'}, 'there is no fault stem_fricton; did you mean stem_friction?'),
    ({'strength': 1.0}, 'a fault must have a name'),
    ({'fault': 'f4', 'strength': -9.0}, 'make actuator.coulomb_friction -2700 N'),
    ({'fault': 'f4', 'parameters__actuator__travel': 99.0}, 'actuator.travel must be between'),
])
def test_what_is_no_fault_is_refused_with_the_reason(bench, fields, reason):
    result = inject(bench, **fields)
    assert not result.successful
    assert reason in result.reason
    assert told(bench) == {}


def test_a_timetable_is_followed_anew_after_each_reset_and_can_be_changed(bench):
    timetable = '[{fault: supply_loss, at: 0.05, until: 0.15}, {fault: f13, at_tick: 12}]'
    # as `ros2 param set` makes a value of what is typed
    assert get_parameter_value(timetable).string_value == timetable
    states, = bench.listen(positioner__state=DiagnosticArray)
    assert bench.set(faults__timetable=timetable).successful
    for _ in range(2):
        bench.trigger('reset')
        states.clear()
        bench.step(20)
        bench.client.spin_until(lambda: len(states) == 20)
        assert [sum(name in m.status[1].message for name in (
            'supply_loss', 'position_sensor_bias')) for m in states] == [
            *[0] * 5, *[1] * 7, *[2] * 3, *[1] * 5]
        # the tick that begins at 0.05 s ends with the supply gone
        assert [state_of(m)['supply_pressure'] for m in states] == [
            *[4e5] * 5, *[0.0] * 10, *[4e5] * 5]
    assert not bench.set(faults__timetable='[{fault: f99}]').successful
    assert bench.set(faults__timetable='').successful
    assert told(bench) == {}


@pytest.mark.parametrize(('argument', 'sentence'), [
    ('faults.timetable:="{fault: f99}"', 'there is no fault f99'),
    ('faults.file:=/no/such/file', '/no/such/file: cannot be read: No such file'),
])
def test_a_timetable_that_is_none_is_refused_in_a_sentence(argument, sentence):
    with pytest.raises(ParameterError, match=sentence) as refused, positioner_here('-p', argument):
        pass
    assert '\n' not in str(refused.value)


def test_a_timetable_that_rclpy_cannot_read_ends_the_start_with_a_sentence():
    with RosProcess(program('positioner', '--ros-args', '-p', 'faults.timetable:=[3')) as node:
        assert node.wait() == 2
        assert 'faults.timetable' in node.stderr[-1]
        assert 'Traceback' not in node.output


def test_a_file_with_a_timetable_is_read_at_the_start(tmp_path):
    path = tmp_path / 'faults.yaml'
    path.write_text('- {fault: f16, at: 0.1, strength: small}\n')
    with Valve({'faults.file': str(path)}) as valve:
        valve.run(0.1)
        assert valve.faults == []
        valve.run(0.05)
        assert valve.faults == ['supply_loss']
        with pytest.raises(AssertionError, match='cannot be read'):
            valve.set({'faults.file': str(tmp_path / 'none.yaml')})
        assert valve.faults == ['supply_loss']


def test_a_condition_is_judged_by_what_the_valve_does():
    with Valve() as valve:
        valve.inject('supply_loss', when='valve_position > 0.004', ramp=0.5)
        valve.send(CURRENT)
        valve.run(0.2)
        assert valve.faults == []
        valve.run(5.0)
        assert valve.faults == ['supply_loss']
        reached = valve.series.assert_reaches('valve_position', 0.004, 1e-4)
        assert valve.series.since(reached)['valve_position'].max() < 0.0055


def test_published_readings_are_those_of_the_sensor_and_its_faults(ros_client):
    noise = {'measurement.position_noise': 1e-5, 'measurement.pressure_resolution': 500.0,
             'measurement.seed': 7}
    with Valve(noise) as valve:
        valve.send(CURRENT)
        valve.run(0.5)
        first = valve.series.tobytes()
        valve.reset()
        valve.send(CURRENT)
        valve.run(0.5)
        assert valve.series.tobytes() == first
        plant, position, pressure = Plant(from_values({})), Sensor('position', 7), Sensor(
            'pressure', 7)
        for k, sample in enumerate(valve.series):
            ideal = plant.readings()
            assert sample.chamber_pressure == pressure.read(
                ideal[0], Imperfection(resolution=500.0), [])
            assert sample.valve_position == position.read(ideal[1], Imperfection(noise=1e-5), [])
            assert k or sample.chamber_pressure == 0.0
            plant.advance(CURRENT, 10)
        assert {sample.chamber_pressure % 500.0 for sample in valve.series} == {0.0}


def test_a_fault_that_no_longer_fits_is_taken_away_and_said(capfd):
    with Valve() as valve:
        valve.inject('supply_ripple', parameters={'supply.ripple': 3e5})
        valve.run(0.1)
        valve.set({'supply.pressure': 2e5})
        assert valve.faults == []
        assert 'the fault supply_ripple is taken away: supply.ripple' in capfd.readouterr().err
        with pytest.raises(ParameterError, match=r'supply\.ripple'):
            valve.inject('supply_ripple', parameters={'supply.ripple': 3e5})
        assert injection({'fault': 'supply_ripple'})


def test_the_plain_topics_have_what_the_faulty_sensor_shows(bench):
    positions, pressures = bench.listen(valve_position=Float64, chamber_pressure=Float64)
    states, = bench.listen(positioner__state=DiagnosticArray)
    bench.command(6e-4)
    bench.step(100)
    assert inject(bench, fault='position_sensor_dead').successful
    assert inject(bench, fault='pressure_sensor_stuck').successful
    bench.step(50)
    bench.client.spin_until(lambda: len(states) >= 150 and len(positions) >= len(states))
    assert [message.data for message in positions[-50:]] == [0.0] * 50
    assert {message.data for message in pressures[-50:]} == {pressures[-51].data}
    last = state_of(states[-1])
    assert (last['measured_valve_position'], last['valve_position'] > 1e-4) == (0.0, True)
    assert last['measured_chamber_pressure'] == pressures[-1].data != last['chamber_pressure']
