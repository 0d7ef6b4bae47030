# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Resets and long steps of a positioner beside everything else that it does."""

from __future__ import annotations

from diagnostic_msgs.msg import DiagnosticArray
from positioner_process import Bench, start, state_of, with_parameters
import pytest
from ros_client import RosClient
from sensor_msgs.msg import FluidPressure
from std_msgs.msg import Float64
from std_srvs.srv import Trigger

TICK = 10_000_000
MILLION = 1_000_000


@pytest.fixture(scope='module')
def shared_bench():
    with start(*with_parameters(start_paused='true')) as node, RosClient() as client:
        yield Bench(client)
        assert node.interrupt() == 0, node.output
        assert 'Traceback' not in node.output


@pytest.fixture
def bench(shared_bench):
    shared_bench.pause(True)
    shared_bench.trigger('reset')
    yield shared_bench
    shared_bench.client.forget()


def stamp_of(message):
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


def test_a_reset_has_a_stamp_of_its_own_whether_ticks_run_or_not(bench):
    states, = bench.listen(positioner__state=DiagnosticArray)
    bench.step(2)
    bench.trigger('reset')
    bench.step(2)
    bench.client.spin_until(lambda: len(states) == 5)
    bench.pause(False)
    bench.client.spin_until(lambda: len(states) >= 10)
    bench.trigger('reset')
    before = len(states)
    bench.client.spin_until(lambda: len(states) >= before + 10)
    times = [state_of(message)['time'] for message in states]
    assert times.count(0.0) == 2
    running = states[5:]
    steps = {after - ago for ago, after in zip(map(stamp_of, running), map(stamp_of, running[1:]))}
    assert max(steps) < TICK + MILLION
    assert min(steps) > TICK - MILLION


@pytest.mark.parametrize('service', ['reset', 'pause'])
def test_others_have_their_turn_in_a_long_step_and_can_end_it(bench, service):
    pressures, = bench.listen(chamber_pressure_stamped=FluidPressure)
    assert bench.set(step_ticks=MILLION).successful
    client = bench.client.node.create_client(Trigger, 'positioner/step')
    bench.client.spin_until(client.service_is_ready)
    answer = client.call_async(Trigger.Request())
    bench.client.spin_until(lambda: len(pressures) > 20)
    bench.command(4e-4)  # waits for the end of the step
    assert bench.set(step_ticks=5).successful
    assert not answer.done()
    bench.trigger('reset') if service == 'reset' else bench.pause(False)
    bench.client.spin_until(answer.done)
    assert not answer.result().success
    assert answer.result().message.startswith('ended by ~/reset or ~/pause after ')
    bench.pause(True)
    bench.trigger('reset')
    assert bench.trigger('step').message.startswith('5 ticks, simulated time 0.05')


def test_commands_that_come_in_a_step_count_after_it(bench):
    states, = bench.listen(positioner__state=DiagnosticArray)
    assert bench.set(step_ticks=1000).successful
    client = bench.client.node.create_client(Trigger, 'positioner/step')
    bench.client.spin_until(client.service_is_ready)
    answer = client.call_async(Trigger.Request())
    bench.client.spin_until(lambda: len(states) > 20)
    for current in (1e-4, 2e-4):
        bench.command(current)
    assert not answer.done()
    bench.client.spin_until(answer.done)
    bench.step(1)
    # A listener that is starved may miss some of a burst longer than the publisher's history.
    bench.client.spin_until(lambda: state_of(states[-1])['control_current'] == 2e-4)
    assert {state_of(message)['control_current'] for message in states[:-1]} == {0.0}
    assert state_of(states[-1])['time'] == pytest.approx(1001 * TICK / 1e9)


def test_two_steps_at_a_time_are_taken_one_after_the_other(bench):
    pressures, = bench.listen(chamber_pressure=Float64)
    assert bench.set(step_ticks=100).successful
    client = bench.client.node.create_client(Trigger, 'positioner/step')
    bench.client.spin_until(client.service_is_ready)
    answers = [client.call_async(Trigger.Request()) for _ in range(2)]
    bench.client.spin_until(lambda: all(answer.done() for answer in answers))
    assert [answer.result().message for answer in answers] == [
        '100 ticks, simulated time 1.000000000 s', '100 ticks, simulated time 2.000000000 s']
    bench.client.spin_until(lambda: len(pressures) == 200)
