# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What other nodes do that keeps commands and outputs from being what they seem is said."""

from __future__ import annotations

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from positioner_here import positioner_here
from positioner_process import details, report_of, start, with_parameters
import pytest
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_msgs.msg import Float64

from booster_ros.model.parameters import ParameterError

BEST_EFFORT = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
OVERRIDE = 'qos_overrides./control_current.subscription.'


def wait_for_report(client, diagnostics, text):
    client.spin_until(lambda: any(
        text in report_of(message, 'topics').message for message in diagnostics))
    report = next(report_of(message, 'topics') for message in diagnostics
                  if text in report_of(message, 'topics').message)
    assert report.level == DiagnosticStatus.WARN


def test_commands_that_cannot_arrive_are_reported_with_who_sends_them(ros_client):
    with start() as node:
        diagnostics = ros_client.listen('/diagnostics', DiagnosticArray)
        ros_client.spin_until(lambda: len(diagnostics) > 0)
        assert report_of(diagnostics[0], 'topics').level == DiagnosticStatus.OK
        publisher = ros_client.node.create_publisher(Float64, 'control_current', BEST_EFFORT)
        wait_for_report(
            ros_client, diagnostics, 'the commands of /test_client do not arrive, their QoS does '
            'not fit: Best effort publisher and reliable subscription')
        node.wait_for('WARN.*the commands of /test_client do not arrive')
        ros_client.node.destroy_publisher(publisher)
        ros_client.spin_until(
            lambda: report_of(diagnostics[-1], 'topics').level == DiagnosticStatus.OK)
        assert node.output.count('the commands of /test_client do not arrive') == 1


def test_they_arrive_where_the_qos_is_overridden(ros_client):
    with start('-p', f'{OVERRIDE}reliability:=best_effort'):
        diagnostics = ros_client.listen('/diagnostics', DiagnosticArray)
        publisher = ros_client.node.create_publisher(Float64, 'control_current', BEST_EFFORT)

        def arrived():
            publisher.publish(Float64(data=1e-4))
            return diagnostics and int(
                details(report_of(diagnostics[-1], 'command'))['accepted']) > 0
        ros_client.spin_until(arrived)
        assert report_of(diagnostics[-1], 'topics').level == DiagnosticStatus.OK


@pytest.mark.parametrize('override', ['reliability:=often', 'depth:=many', 'reliability:=3'])
def test_an_override_that_is_none_is_refused_in_a_sentence(override):
    with pytest.raises(ParameterError, match=r'^qos_overrides of control_current: ') as refused, \
            positioner_here('-p', f'{OVERRIDE}{override}'):
        pass
    assert '\n' not in str(refused.value)


def test_two_of_one_name_on_the_same_topics_are_told_of_each_other(ros_client):
    diagnostics = ros_client.listen('/diagnostics', DiagnosticArray)
    with start() as first, start():
        first.wait_for('WARN.*another node is called /positioner too')
        first.wait_for(r'several publish /valve_position \(/positioner, /positioner\)')
        wait_for_report(ros_client, diagnostics, 'another node is called /positioner too')


def test_a_node_that_cannot_keep_up_leaves_large_topics_out_and_says_so(ros_client):
    with positioner_here(*with_parameters(start_paused='true')) as node:
        node._ticking.thinning._until = float('inf')
        node._ticking.paused = False
        states = ros_client.listen('/positioner/state', DiagnosticArray)
        plain = ros_client.listen('chamber_pressure', Float64)
        publisher = node._outputs.always_published[0]
        ros_client.spin_until(lambda: publisher.get_subscription_count() > 0)
        ros_client.spin_until(lambda: node.count_subscribers('/positioner/state') > 0)
        ros_client.spin_until(lambda: ros_client.node.count_publishers('/positioner/state') > 0)
        for _ in range(20):
            node._run_ticks(10)
        ros_client.spin_until(lambda: len(plain) == 200)
        ros_client.spin_until(lambda: len(states) == 20)
        report = node._reporter._reports()[0]
        assert report.level == 1
        assert 'thinned out (does a subscription hang?)' in report.message
