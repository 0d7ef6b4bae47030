# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Travel deviation: how far a valve is from its set point, and since when too far."""

import math


class TravelDeviation:
    """
    Raises an alarm where the deviation has been beyond its band for a while.

    >>> watch = TravelDeviation(band=1e-3, delay=2.0)
    >>> watch.note(5e-3, 0.0), watch.note(5e-3, 2.5), watch.alarm, watch.note(0.0, 3.0)
    (False, True, True, True)
    """

    def __init__(self, band: float = math.inf, delay: float = 0.0) -> None:
        self.band = band
        """Deviation, m, either way, up to which nothing is wrong."""
        self.delay = delay
        """Simulated time, s, for which it must be beyond."""
        self.reset()

    def reset(self) -> None:
        """Begin anew, without an alarm."""
        self.deviation = 0.0
        """Set point less position, m, when it was looked at last."""
        self.alarm = False
        """Whether it has been beyond the band for longer than the delay."""
        self._since: float | None = None

    def note(self, deviation: float, time: float) -> bool:
        """Note a deviation (m) at a simulated time (s); return whether the alarm has changed."""
        self.deviation = deviation
        if abs(deviation) <= self.band:
            self._since = None
        elif self._since is None:
            self._since = time
        before = self.alarm
        self.alarm = self._since is not None and time - self._since >= self.delay
        return self.alarm != before
