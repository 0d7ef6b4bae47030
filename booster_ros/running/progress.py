# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How far a run is."""

from __future__ import annotations

import time


class Progress:
    """Counts what has ended of so many orders, and says how long the rest will take."""

    def __init__(self, count: int):
        self._count = count
        self._ended = 0
        self._started = time.monotonic()

    def one_more(self, text: str) -> str:
        """Count another one that has ended, told by `text`; return the line that says so."""
        self._ended += 1
        each = (time.monotonic() - self._started) / self._ended
        minutes = each * (self._count - self._ended) / 60.0
        return f'{self._ended}/{self._count} {text}; {minutes:.0f} min to go'
