# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Simulated time follows the clock: wall time, late ticks, /clock and its jumps."""

from __future__ import annotations

import signal
import statistics

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
from positioner_process import Bench, details, report_of, start, state_of, with_parameters
import pytest
from ros_client import RosClient
from ros_process import RosProcess
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import FluidPressure

TICK = 10_000_000
SECOND = 1_000_000_000


def stamp_of(message):
    return message.header.stamp.sec * SECOND + message.header.stamp.nanosec


def ticks_of(states):
    """Return the number of the tick, since the start, of each message."""
    return [round(state_of(message)['time'] * SECOND) // TICK for message in states]


def time_details(diagnostics):
    return details(report_of(diagnostics[-1], 'time')) if diagnostics else {}


def test_on_wall_time_each_tick_is_one_period_of_the_clock(ros_client):
    with start():
        states = ros_client.receive('/positioner/state', DiagnosticArray, 60)
    assert ticks_of(states) == list(range(ticks_of(states)[0], ticks_of(states)[0] + 60))
    # The first ones are left out, and the others compared with their median, because reading the
    # system's clock beside the steady one can be interrupted.
    origins = [stamp_of(m) - round(state_of(m)['time'] * SECOND) for m in states[20:]]
    assert max(origins, key=lambda o: -abs(o - statistics.median(origins))) == pytest.approx(
        statistics.median(origins), abs=SECOND // 1000)


def test_ticks_of_a_stopped_process_are_caught_up_and_counted(ros_client):
    with start(*with_parameters(publish_rate=100)) as node:
        states = ros_client.listen('/positioner/state', DiagnosticArray)
        diagnostics = ros_client.listen('/diagnostics', DiagnosticArray)
        ros_client.spin_until(lambda: len(states) >= 3)
        node.send(signal.SIGSTOP)
        end = ros_client.node.get_clock().now().nanoseconds + SECOND // 2
        ros_client.spin_until(
            lambda: ros_client.node.get_clock().now().nanoseconds > end)
        before = len(states)
        node.send(signal.SIGCONT)
        ros_client.spin_until(lambda: len(states) >= before + 60)
        ticks = ticks_of(states)
        assert ticks == list(range(ticks[0], ticks[0] + len(ticks)))
        ros_client.spin_until(lambda: int(time_details(diagnostics).get('late ticks', 0)) >= 45)
        assert float(time_details(diagnostics)['longest delay [s]']) > 0.45
        assert any(
            report_of(message, 'time').message.startswith('late ticks caught up: ')
            for message in diagnostics)
        assert node.interrupt() == 0, node.output


class SimulatedTime:
    """Publishes /clock, of which a node keeps the last message only."""

    def __init__(self, client: RosClient, node: RosProcess):
        """Publish with the client's node to the node under test."""
        self._client = client
        self._node = node
        self._publisher = client.node.create_publisher(Clock, '/clock', 10)

    def begin(self, nanoseconds: int) -> None:
        """Show the first time until the node has seen it: /clock is best effort."""
        while '/clock has begun' not in self._node.output:
            self.show(nanoseconds)
            self._client.spin_once()

    def show(self, nanoseconds: int) -> None:
        """Let the clock show this time."""
        self._client.spin_until(lambda: self._publisher.get_subscription_count() > 0)
        self._publisher.publish(Clock(clock=Time(
            sec=nanoseconds // SECOND, nanosec=nanoseconds % SECOND)))


@pytest.fixture
def simulated(ros_client):
    """Return a positioner on simulated time, its clock and what it publishes."""
    with start('-p', 'use_sim_time:=true') as node:
        clock = SimulatedTime(ros_client, node)
        diagnostics = ros_client.listen('/diagnostics', DiagnosticArray)
        pressures, = Bench(ros_client).listen(chamber_pressure_stamped=FluidPressure)
        yield node, ros_client, clock, pressures, diagnostics
        assert node.interrupt() == 0, node.output
        assert 'Traceback' not in node.output


def show_until(client, clock, moments, pressures, count):
    """Show moments one by one, each as soon as the ticks up to the one before have come."""
    for moment, needed in zip(moments, count, strict=True):
        clock.show(moment)
        client.spin_until(lambda needed=needed: len(pressures) >= needed)


def test_simulated_time_ticks_with_clock_and_pauses_with_it(simulated):
    node, client, clock, pressures, diagnostics = simulated
    begin = 1_700_000_000 * SECOND
    node.wait_for('nothing has come on /clock')
    client.spin_until(lambda: any(
        'nothing has come on /clock' in report_of(m, 'time').message for m in diagnostics))
    assert pressures == []

    clock.begin(begin)
    moments = [begin + k * TICK for k in (1, 2, 3, 8, 9, 20)]
    show_until(client, clock, moments, pressures, (1, 2, 3, 8, 9, 20))
    assert [stamp_of(m) for m in pressures] == [begin + k * TICK for k in range(1, 21)]

    client.spin_until(
        lambda: report_of(diagnostics[-1], 'time').message == '/clock stands still')
    assert len(pressures) == 20
    assert time_details(diagnostics)['simulated time [s]'] == '0.200000000'
    clock.show(begin + 21 * TICK)
    client.spin_until(lambda: len(pressures) >= 21)


def test_a_time_below_zero_on_clock_is_ignored_and_said(simulated):
    node, client, clock, pressures, _ = simulated
    clock.begin(10 * SECOND)
    while '/clock has begun' in node.output and 'below zero' not in node.output:
        clock.show(-5 * SECOND)
        client.spin_once()
    show_until(client, clock, [10 * SECOND + TICK], pressures, [1])


def test_a_coarse_clock_is_followed_without_a_gap(simulated):
    _, client, clock, pressures, _ = simulated
    clock.begin(SECOND)
    show_until(client, clock, [3 * SECOND], pressures, [200])
    show_until(client, clock, [3 * SECOND + SECOND // 2], pressures, [250])
    assert [stamp_of(m) for m in pressures] == [SECOND + k * TICK for k in range(1, 251)]


def test_jumps_of_the_clock_are_warned_about_and_the_state_is_kept(simulated):
    node, client, clock, pressures, diagnostics = simulated
    clock.begin(100 * SECOND)
    show_until(client, clock, [100 * SECOND + k * TICK for k in (1, 2)], pressures, (1, 2))

    moment, before = 5 * SECOND, len(pressures)
    while len(pressures) < before + 2:
        clock.show(moment)
        moment += TICK
        client.spin_once()
    node.wait_for(r'the clock jumped by -9[45]\.\d+ s: not simulated, the state is kept')
    assert 5 * SECOND < stamp_of(pressures[-1]) < moment

    clock.show(5000 * SECOND)
    node.wait_for(r'the clock jumped by \+49\d\d\.\d+ s')
    client.spin_until(lambda: stamp_of(pressures[-1]) >= 5000 * SECOND)
    # A message from between the two jumps knows of the first only: the later one is waited for.
    client.spin_until(lambda: float(
        time_details(diagnostics).get('skipped forward jumps of the clock [s]', 0)) > 4900)
    assert time_details(diagnostics)['backward jumps of the clock'] == '1'
    assert float(time_details(diagnostics)['simulated time [s]']) < 1.0


def test_a_clock_that_jumps_all_the_time_is_warned_about_once(simulated):
    node, client, clock, pressures, diagnostics = simulated
    clock.begin(SECOND)
    for jump in range(1, 6):
        clock.show(1000 * jump * SECOND)
        client.spin_until(lambda jump=jump: len(pressures) >= jump)
    client.spin_until(lambda: float(
        time_details(diagnostics).get('skipped forward jumps of the clock [s]', 0)) > 4900)
    node.wait_for('the clock jumped by')
    assert node.output.count('the clock jumped by') == 1


def test_the_clock_can_be_chosen_while_the_node_runs(ros_client):
    with start() as node:
        bench = Bench(ros_client)
        pressures = ros_client.listen('/chamber_pressure_stamped', FluidPressure)
        ros_client.spin_until(lambda: len(pressures) > 0)
        assert bench.set(use_sim_time=True).successful
        clock = SimulatedTime(ros_client, node)
        clock.begin(SECOND)
        clock.show(SECOND + TICK)
        ros_client.spin_until(lambda: stamp_of(pressures[-1]) == SECOND + TICK)
        assert bench.set(use_sim_time=False).successful
        ros_client.spin_until(lambda: stamp_of(pressures[-1]) > 1_000_000 * SECOND)
        assert node.interrupt() == 0, node.output
