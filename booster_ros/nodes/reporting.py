# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""When a positioner reports on /diagnostics: regularly, and when it becomes better or worse."""

from collections.abc import Callable
from typing import NamedTuple

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node

from .command_guard import CommandGuard
from .declaration import ParameterWatch
from .diagnostics import (
    ClockState,
    Loss,
    Report,
    command_report,
    diagnostic_message,
    fault_report,
    parameter_report,
    simulation_report,
    time_report,
    topic_report,
)
from .node_time import NodeTime
from .outputs import quiet_publisher
from .tick_clock import TickClock


class Condition(NamedTuple):
    """What a positioner knows of itself."""

    paused: bool
    """A service paused it."""
    loss: Loss | None
    thinned: int
    """Ticks left out of some topics, because the node cannot keep up; 0 where it does."""
    trouble: list[str]
    """What other nodes are in the way of."""
    faults: list[str]
    """The faults that are on."""
    to_come: int
    """How many faults are still to come."""
    travel: list[Report]
    """On the travel, where a set point is commanded."""


class Reporter:
    """Publishes the reports of a positioner, which tells its `condition`."""

    def __init__(
        self, node: Node, time: NodeTime, ticks: TickClock, guard: CommandGuard,
        watch: ParameterWatch, condition: Callable[[], Condition],
    ) -> None:
        self._node = node
        self._time = time
        self._ticks = ticks
        self._guard = guard
        self._watch = watch
        self._condition = condition
        self._publisher = quiet_publisher(node, DiagnosticArray, '/diagnostics')
        self._reported: tuple[int, ...] = ()
        self._late_reported = self._bad_reported = 0
        self._clock_reported = -1

    def report_regularly(self) -> None:
        """Report; later reports count what has come since this one."""
        self.report()
        self._late_reported = self._ticks.late_ticks
        self._bad_reported = self._guard.bad
        self._clock_reported = self._time.now()

    def report_change(self) -> None:
        """Report at once if something has become better or worse."""
        if tuple(report.level for report in self._reports()) != self._reported:
            self.report()

    def report(self) -> None:
        """Report at once."""
        reports = self._reports()
        self._reported = tuple(report.level for report in reports)
        self._publisher.publish(diagnostic_message(
            reports, self._node.get_fully_qualified_name(),
            self._node.get_clock().now().to_msg()))

    def _reports(self) -> list[Report]:
        now = self._time.now()
        paused, loss, thinned, trouble, faults, to_come, travel = self._condition()
        clock = ClockState(
            self._time.follows_clock_topic, now > 0, now == self._clock_reported, paused)
        return [
            time_report(clock, self._ticks, self._late_reported, thinned),
            simulation_report(loss),
            command_report(self._guard, self._bad_reported),
            parameter_report(self._watch.changes, self._watch.last_change),
            topic_report(trouble),
            fault_report(faults, to_come),
            *travel,
        ]
