# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Runs ticks as they are due on the clock that a node follows, unless it is paused."""

from collections.abc import Callable

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from rclpy.parameter import Parameter

from .node_time import NodeTime
from .thinning import Thinning
from .throttle import Throttle
from .tick_clock import NANOSECONDS, TickClock


class Ticking:
    """
    The timer of the ticks; `run` runs so many of them.

    What a call cannot catch up is left to the next turn of the executor.
    """

    def __init__(
        self, node: Node, time: NodeTime, ticks: TickClock, throttle: Throttle,
        run: Callable[[int], None], paused: bool,
    ) -> None:
        """Nothing ticks before `start`."""
        self.paused = paused
        """Whether ticks run on request only."""
        self.thinning = Thinning()
        self._node = node
        self._time = time
        self._ticks = ticks
        self._throttle = throttle
        self._run = run
        self._started = False
        self._steady_clock = Clock(clock_type=ClockType.STEADY_TIME)
        self._catch_up = node.create_guard_condition(self._on_time)

    def start(self) -> None:
        """Tick from now on, on the clock that the node follows now and after each choice of it."""
        self._start_timer()
        self._node.add_post_set_parameters_callback(self._on_clock_choice)

    def pause(self, paused: bool) -> None:
        """Pause, or go on where it stood."""
        self.paused = paused
        if paused:
            self._timer.cancel()
        else:
            self._begin()
            self._timer.reset()

    @property
    def stands(self) -> bool:
        """Whether no tick comes by itself: paused, or before anything has come on /clock."""
        return self.paused or not self._started

    @property
    def thins(self) -> bool:
        """Whether the node cannot keep up with wall time, and is to publish less for that."""
        return not (self.paused or self._time.follows_clock_topic) and self.thinning.active(
            self._steady_now() / NANOSECONDS)

    def _start_timer(self) -> None:
        self._begin()
        self._timer = self._node.create_timer(1.0, self._on_time, clock=self._time.clock)
        self._timer.timer_period_ns = self._ticks.period
        self._timer.reset()
        if self.paused:
            self._timer.cancel()

    def _begin(self) -> None:
        """Owe no ticks for the past. Simulated time shows 0 until something comes on /clock."""
        now = self._time.now()
        self._started = now > 0
        self._ticks.start(now)

    def _on_clock_choice(self, applied: list[Parameter]) -> None:
        if any(parameter.name == 'use_sim_time' for parameter in applied):
            self._node.destroy_timer(self._timer)
            self._start_timer()

    def _on_time(self) -> None:
        """Run the ticks that are due."""
        if self.paused:
            return
        if not self._started:
            self._begin()
            self._timer.reset()
            self._node.get_logger().info('/clock has begun')
            return
        due = self._ticks.due(self._time.now())
        if self._ticks.jump:
            self._on_clock_jump()
        self.thinning.note(self._ticks.backlog, self._steady_now() / NANOSECONDS)
        self._run(due)
        if self._ticks.backlog:
            self._catch_up.trigger()

    def _on_clock_jump(self) -> None:
        self._timer.reset()
        jump = self._ticks.jump / NANOSECONDS
        kind = 'jump backwards' if jump < 0.0 else 'jump forwards'
        if self._throttle.passes(kind, self._steady_now()):
            self._node.get_logger().warning(
                f'the clock jumped by {jump:+.3f} s: not simulated, the state is kept')

    def _steady_now(self) -> int:
        return self._steady_clock.now().nanoseconds
