# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What wears or tells of wear: way gone, turns, and numbers of the blocks."""

from collections.abc import Mapping

import numpy as np

Array = np.ndarray

WAY, TURNS = 'way [m]', 'turns'


class Counters:
    """
    Sums the way that the stem has gone, m, and how often it has turned.

    A motion counts once it is longer than `band` m (a play: neither noise nor the last digit of a
    sensor moves it). The sums go on from those of `before`.
    """

    def __init__(self, band: float, before: Mapping[str, float] | None = None) -> None:
        self.band = band
        self.way = (before or {}).get(WAY, 0.0)
        self.turns = (before or {}).get(TURNS, 0.0)
        self._place: float | None = None
        self._direction = 0

    def add(self, positions: Array) -> None:
        """Take readings of the position, m, shape (n,); what is not finite is passed over."""
        for position in positions[np.isfinite(positions)].tolist():
            if self._place is None:
                self._place = position
            moved = position - self._place
            if abs(moved) <= self.band:
                continue
            direction = 1 if moved > 0.0 else -1
            step = moved - direction * self.band
            self._place += step
            self.way += abs(step)
            self.turns += direction == -self._direction
            self._direction = direction

    @property
    def values(self) -> dict[str, float]:
        """The sums by name."""
        return {WAY: self.way, TURNS: float(self.turns)}
