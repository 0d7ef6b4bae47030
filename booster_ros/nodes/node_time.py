# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which clock the simulation follows: /clock if the node is told to, else a steady one."""

from time import monotonic_ns, time_ns
from typing import cast

from rclpy.clock import Clock, ROSClock
from rclpy.clock_type import ClockType
from rclpy.node import Node


class NodeTime:
    """
    The time that ticks are counted on.

    On wall time that is a steady clock: the system's clock may be set while the node runs, and
    would take simulated time with it. Messages are stamped by the node's clock in any case.
    """

    def __init__(self, node: Node) -> None:
        self._node_clock = cast(ROSClock, node.get_clock())
        self._steady_clock = Clock(clock_type=ClockType.STEADY_TIME)
        self._offset = 0

    @property
    def follows_clock_topic(self) -> bool:
        """Whether the time is that of /clock."""
        return self._node_clock.ros_time_is_active

    @property
    def clock(self) -> Clock:
        """The clock to create timers on."""
        return self._node_clock if self.follows_clock_topic else self._steady_clock

    def now(self) -> int:
        """Return the time, ns; 0 as long as nothing has come on /clock."""
        # Python reads the clocks that rcl reads, forty times as fast as through rclpy.
        if not self.follows_clock_topic:
            return monotonic_ns()
        return self._node_clock.now().nanoseconds

    def stamp_offset(self) -> int:
        """
        Return what to add to a time of this clock to get the node's clock, ns.

        The two clocks cannot be read at once. The offset changes only where two readings of one
        clock, around a reading of the other, rule the old offset out. So stamps are as even as
        ticks and do not step back where the process was held up between readings.
        """
        if self.follows_clock_topic:
            return 0
        before = monotonic_ns()
        stamp = time_ns()
        after = monotonic_ns()
        self._offset = min(max(self._offset, stamp - after), stamp - before)
        return self._offset
