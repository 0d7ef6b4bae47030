# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""When commands are sent: one per period of the clock."""

from collections.abc import Callable
from typing import Protocol

from rclpy.node import Node

from .node_time import NodeTime
from .tick_clock import NANOSECONDS

PHASE = 0.25
"""
Where between two samples of the positioner a command is sent, as a share of the period.

It is sent well after a sample, even a late one, and well before the next, so that there is no
doubt from which sample on it counts; and nearer to the sample before, to whose row the reader of a
bag gives it.
"""


class Player(Protocol):
    """What is to be played."""

    @property
    def duration(self) -> float:
        """Seconds after which the profile is over."""

    def begin(self, stamp: int) -> None:
        """Take note that the profile begins at this stamp, ns."""

    def send(self, played: float, stamp: int) -> None:
        """Send the command for `played` seconds after the start, at a stamp in ns."""

    def finish(self) -> None:
        """Take note that the profile is over."""

    def repeat(self) -> None:
        """Send the last command again."""


class Pace(Protocol):
    """Calls a player when it is time."""

    def missing(self) -> list[str]:
        """Return what is needed to play and still missing."""

    def begin(self, player: Player, last_sample: int) -> None:
        """Play from now on; `last_sample` is the stamp (ns) of the last sample, 0 if none came."""

    def stamp(self, column: str, received: int) -> int | None:
        """
        Return the stamp (ns) under which to record an output, None if it is not recorded.

        `received` is the stamp (ns) that it came with.
        """

    def left_behind(self) -> str:
        """Return the sentence on the state in which ending now leaves the positioner, or ''."""


class RealTime:
    """
    Sends a command per period of the clock that the node follows.

    What is sent depends on the time, not on the number of calls: a command that comes late is the
    one for now, and those that were missed are not made up for.
    """

    def __init__(
        self, node: Node, time: NodeTime, rate: float, on_jump: Callable[[], None]
    ) -> None:
        self._begin = 0
        self._node = node
        self._time = time
        self._rate = rate
        self._on_jump = on_jump
        self._zero = self._last = 0
        self._is_over = False

    def missing(self) -> list[str]:
        """Return that simulated time has not begun, if so."""
        return [] if self._time.now() else ['nothing has come on /clock']

    def begin(self, player: Player, last_sample: int) -> None:
        """Play from now on, in step with the samples if they come at the same rate."""
        period = round(NANOSECONDS / self._rate)
        now = self._time.now() + self._time.stamp_offset()
        delay = (last_sample + round(PHASE * period) - now) % period if last_sample else 0

        def start() -> None:
            self._node.destroy_timer(timer)
            self._start(player)

        timer = self._node.create_timer(delay / NANOSECONDS, start, clock=self._time.clock)

    def _start(self, player: Player) -> None:
        self._zero = self._last = self._time.now()
        self._begin = self._zero + self._time.stamp_offset()
        player.begin(self._begin)
        self._node.create_timer(
            1.0 / self._rate, lambda: self._on_timer(player), clock=self._time.clock)
        self._on_timer(player)

    def stamp(self, column: str, received: int) -> int | None:
        """Return the stamp as it is, None before the beginning."""
        return received if 0 < self._begin <= received else None

    def left_behind(self) -> str:
        """Return nothing: the positioner runs on."""
        return ''

    def _on_timer(self, player: Player) -> None:
        now = self._time.now()
        if now < self._last:
            self._zero -= self._last - now
            self._on_jump()
        self._last = now
        played = (now - self._zero) / NANOSECONDS
        if played < player.duration:
            player.send(played, now + self._time.stamp_offset())
        elif self._is_over:
            player.repeat()
        else:
            self._is_over = True
            player.finish()
