# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Whether a positioner has fallen silent: one that was killed, say, whose topics stay known."""

LONG = 1.0
LONGER = 3.0
"""Nothing heard for `LONG` seconds plus `LONGER` times the longest pause so far is silence."""


class Silence:
    """Judges by real time, s, and by the longest pause so far: at a low rate pauses are long."""

    def __init__(self, now: float) -> None:
        self._heard = now
        self._longest = 0.0

    def heard(self, now: float) -> None:
        """Take note that something has come."""
        self._longest = max(self._longest, now - self._heard)
        self._heard = now

    def lasts(self, now: float) -> float:
        """Return for how long there has been silence, 0 where that is no longer than usual."""
        lasting = now - self._heard
        return lasting if lasting > LONG + LONGER * self._longest else 0.0
