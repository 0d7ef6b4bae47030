# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The positioner among others: topics, other DDS clients, names, commands, bad parameters."""

from __future__ import annotations

import math
import re

from diagnostic_msgs.msg import DiagnosticArray
from positioner_here import positioner_here
from positioner_process import Bench, details, report_of, start, with_parameters
import pytest
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy
from ros_process import RosProcess, program
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Float64

from booster_ros.model.parameters import ParameterError

FAST = with_parameters(publish_rate=200)
CURRENT = 0.4524e-3


def test_a_client_that_is_not_rclpy_commands_and_reads(ros_domain):
    rosless = pytest.importorskip('rosless')  # not among the packages that rosdep knows
    with start(*FAST) as node:
        outside = rosless.Node(domain=ros_domain)
        commands = outside.advertise('/control_current', 'std_msgs/msg/Float64')
        with outside.subscribe('/chamber_pressure', 'std_msgs/msg/Float64') as pressures:
            assert pressures.read(20).data == 0.0
            while (pressure := pressures.read(20).data) < 50e3:
                commands.send({'data': CURRENT})
        with outside.subscribe(
            '/chamber_pressure_stamped', 'sensor_msgs/msg/FluidPressure') as absolute:
            assert absolute.read(20).fluid_pressure >= 101_325 + pressure
        assert node.interrupt() == 0, node.output


def test_topics_are_what_a_default_subscription_reads(ros_client):
    with start(*FAST):
        for topic, kind in (
            ('/chamber_pressure', Float64), ('/valve_position', Float64),
            ('/chamber_pressure_stamped', FluidPressure), ('/valve_position_stamped', JointState),
            ('/positioner/state', DiagnosticArray), ('/diagnostics', DiagnosticArray),
        ):
            ros_client.receive(topic, kind)
            profile = ros_client.node.get_publishers_info_by_topic(topic)[0].qos_profile
            assert profile.reliability == ReliabilityPolicy.RELIABLE
            assert profile.durability == DurabilityPolicy.VOLATILE


def test_two_in_namespaces_have_their_own_topics_and_parameters(ros_client):
    with (
        start('-r', '__ns:=/a', *with_parameters(initial_state__chamber_pressure=1e4)),
        start('-r', '__ns:=/b', '-r', 'chamber_pressure:=p', '-r', '__node:=pilot'),
    ):
        there = ros_client.listen('/a/chamber_pressure', Float64)
        here = ros_client.listen('/b/p', Float64)
        diagnostics = ros_client.listen('/diagnostics', DiagnosticArray)
        first, second = Bench(ros_client, '/a/positioner'), Bench(ros_client, '/b/pilot')
        assert first.set(supply__pressure=3e5).successful
        ros_client.spin_until(lambda: there and here)  # a paused one publishes nothing
        assert second.pause(True).success

        def names():
            return {status.name for message in diagnostics for status in message.status}
        ros_client.spin_until(lambda: {'a/positioner: time', 'b/pilot: time'} <= names())
        # it vents; a message that a busy machine hears late is near zero, on either side
        assert there[0].data != 0.0
        assert -1.0 < there[0].data <= 1e4
        assert here[0].data == 0.0


@pytest.mark.parametrize(('policy', 'bad_commands', 'in_force', 'counts'), [
    ('refuse', (0.45, -1e-3, math.nan, -math.inf), 3e-4,
     {'refused: above the upper limit': 2, 'refused: below the lower limit': 2,
      'refused: not a number': 2, 'refused: infinite': 2}),
    ('limit', (math.nan, math.inf, -1e-3, 0.45), 2e-3,
     {'limited: above the upper limit': 2, 'limited: below the lower limit': 2,
      'refused: not a number': 2, 'refused: infinite': 2}),
])
def test_bad_commands_are_refused_or_limited_counted_and_warned_about_once(
    ros_client, policy, bad_commands, in_force, counts
):
    with start(*with_parameters(start_paused='true', invalid_current=policy)) as node:
        bench = Bench(ros_client)
        diagnostics = ros_client.listen('/diagnostics', DiagnosticArray)
        for current in (3e-4, *bad_commands, *bad_commands):
            bench.command(current)

        def counted():
            values = details(report_of(diagnostics[-1], 'command')) if diagnostics else {}
            return {key: int(value) for key, value in values.items()
                    if ':' in key and value != '0'}
        ros_client.spin_until(lambda: counted() == counts)
        report = report_of(diagnostics[-1], 'command')
        assert report.level == b'\x01'
        assert re.match(r'bad commands: \d, the last one was ', report.message)
        assert float(details(report)['current in force [A]']) == in_force
        warnings = [line for line in node.stderr if 'WARN' in line and 'control_current' in line]
        assert len(warnings) == 4
        assert sum('current_limits 0 to 0.002 A' in line for line in warnings) == 4


@pytest.mark.parametrize(('argument', 'sentence'), [
    ('supply.presure:=3e5', 'there is no parameter supply.presure; did you mean supply.pressure?'),
    ('supply.pressure:=many', "supply.pressure must be a number in Pa, got 'many'"),
    ('booster.s2:=1.0', 'booster.s1 .* must be greater than booster.s2'),
    ('supply.pressure:=.inf', 'supply.pressure must be finite'),
])
def test_a_parameter_that_cannot_be_used_is_refused_in_one_sentence(argument, sentence):
    with pytest.raises(ParameterError, match=f'^{sentence}') as refused, \
            positioner_here('-p', argument):
        pass
    assert '\n' not in str(refused.value)


@pytest.mark.parametrize(('arguments', 'sentence'), [
    (['-p', 'supply.presure:=3e5'],
     'there is no parameter supply.presure; did you mean supply.pressure?'),
    (['--params-file', 'no_such_file.yaml'], 'no_such_file.yaml'),
    (['--no-such-flag'], 'unknown ROS arguments.*--no-such-flag'),
])
def test_what_cannot_be_used_ends_the_start_with_one_sentence(arguments, sentence):
    with RosProcess(program('positioner', '--ros-args', *arguments)) as node:
        assert node.wait() == 2
        node.wait_for(f'^positioner: .*{sentence}')
        assert 'Traceback' not in node.output
        assert sum(line.startswith('positioner: ') for line in node.stderr) == 1


def parameter_file(folder, text):
    path = folder / 'p.yaml'
    path.write_text('/**:\n  ros__parameters:\n    ' + text.replace('\n', '\n    ') + '\n')
    return path


@pytest.mark.parametrize(('text', 'sentence'), [
    ('supply:\n  presure: 3e5', 'line 4: there is no parameter supply.presure; did you mean'),
    ('supply: {pressure: .nan}', 'line 3: supply.pressure must be finite'),
])
def test_what_is_wrong_in_a_file_is_said_with_its_line(tmp_path, text, sentence):
    path = parameter_file(tmp_path, text)
    with pytest.raises(ParameterError) as refused, positioner_here('--params-file', str(path)):
        pass
    assert str(refused.value).startswith(f'{path}, {sentence}')
    assert '\n' not in str(refused.value)


@pytest.mark.parametrize(('text', 'sentence'), [
    ('actuator: {bench_set: [1, 2.0]}', 'line 3: actuator.bench_set mixes types'),
    ('supply: {pressure: [}', 'line 3: not YAML'),
])
def test_what_rclpy_cannot_read_in_a_file_is_said_with_its_line(tmp_path, text, sentence):
    path = parameter_file(tmp_path, text)
    with RosProcess(program('positioner', '--ros-args', '--params-file', str(path))) as node:
        assert node.wait() == 2
        assert len(node.stderr) == 1
        assert node.stderr[0].startswith(f'positioner: {path}, {sentence}')


def test_a_file_is_used_and_logged_and_one_for_another_node_is_warned_about(tmp_path):
    path = tmp_path / 'p.yaml'
    path.write_text(
        '/**:\n  ros__parameters:\n    supply:\n      pressure: 410000\n'
        '    actuator: {bench_set: [140000, 290000], leak_area: 1.0e-9}\n')
    other = tmp_path / 'other.yaml'
    other.write_text('posisioner:\n  ros__parameters:\n    supply.pressure: 420000.0\n')
    with start('--params-file', str(path), '--params-file', str(other)) as node:
        node.wait_for(r'supply: \*pressure 410000\.0, temperature')
        node.wait_for(r'\*bench_set \[140000\.0, 290000\.0\].*\*leak_area 1e-09')
        node.wait_for(r'other\.yaml holds nothing for /positioner \(its sections: /posisioner\)')
        assert node.interrupt() == 0
        assert node.output.count('holds nothing') == 1
