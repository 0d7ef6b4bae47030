# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Whether a positioner has fallen silent: one that was killed, say, whose topics stay known."""

LONG = 1.5
LONGER = 3.0
"""Nothing heard for `LONG` seconds plus `LONGER` times the longest pause so far is silence."""


class Silence:
    """
    Judges by real time, s, and by the longest pause so far: at a low rate pauses are long.

    Until two have been heard, no pause is known, and none is judged.
    """

    def __init__(self) -> None:
        self._heard: float | None = None
        self._longest: float | None = None
        self._since = 0.0

    def heard(self, now: float) -> None:
        """Take note that something has come."""
        if self._heard is not None:
            self._longest = max(self._longest or 0.0, now - self._heard)
        self._heard = self._since = now

    def excuse(self, now: float) -> None:
        """Count the silence from now on: until now there was a reason for it."""
        self._since = now
        if self._heard is not None:
            self._heard = now

    def lasts(self, now: float) -> float:
        """Return for how long there has been silence, 0 where that is no longer than usual."""
        lasting = now - self._since
        usual = self._longest is None or lasting <= LONG + LONGER * self._longest
        return 0.0 if usual else lasting
