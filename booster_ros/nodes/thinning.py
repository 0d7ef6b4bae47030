# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""When a positioner that cannot keep up thins out what it publishes."""

PATIENCE = 2.0
"""Seconds of real time behind without a break after which topics are thinned out."""

HOLD = 30.0
"""Seconds for which they stay so once it has caught up: what held it up may still be there."""


class Thinning:
    """
    Judges by the ticks that are behind; times in s of a steady clock.

    A subscription that hangs makes every message dear, a large one most of all: its memory is not
    given back. Time and the plain outputs have to go on.
    """

    def __init__(self) -> None:
        self._behind_since: float | None = None
        self._until = -1.0
        self.left_out = 0
        """Ticks that were left out of the topics that are thinned out."""

    def note(self, backlog: int, now: float) -> None:
        """Take note of how many ticks are behind now."""
        if not backlog:
            self._behind_since = None
            return
        if self._behind_since is None:
            self._behind_since = now
        if now - self._behind_since >= PATIENCE or self.active(now):
            self._until = now + HOLD

    def active(self, now: float) -> bool:
        """Tell whether topics are thinned out now."""
        return now < self._until
