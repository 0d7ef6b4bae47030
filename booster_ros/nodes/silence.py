# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Whether a positioner has fallen silent: it was killed, say, and its topics are still known."""

LONG = 1.0
LONGER = 3.0
"""Silent is who has not been heard for so many seconds and so many times the longest pause yet."""


class Silence:
    """Judges by real time, in seconds, as a positioner at a low rate has long pauses of its own."""

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
