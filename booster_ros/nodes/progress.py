# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Show how far a profile is: a bar on a terminal, a line in the log now and then elsewhere."""

import math
import sys
from typing import Any

from rclpy.impl.rcutils_logger import RcutilsLogger

LINES = 10
"""Lines in the log for a whole profile."""

ENDLESS_PERIOD = 60.0
"""Seconds between two lines for a profile that is repeated for ever."""


class Progress:
    """Shows the seconds played of `duration`, which may be infinite."""

    def __init__(self, duration: float, logger: RcutilsLogger) -> None:
        self._duration = duration
        self._logger = logger
        self._period = duration / LINES if math.isfinite(duration) else ENDLESS_PERIOD
        self._next_line = self._period
        self._bar = _bar(duration) if sys.stderr.isatty() else None

    def show(self, played: float) -> None:
        """Show that `played` seconds have been played."""
        if self._bar is not None:
            self._bar.update(min(played, self._duration) - self._bar.n)
        elif played >= self._next_line:
            # half a nanosecond more, as 22.0 // 4.4 is 4: the fifth line would come twice
            self._next_line = ((played + 5e-10) // self._period + 1.0) * self._period
            if math.isfinite(self._duration):
                share = min(played / self._duration, 1.0)
                self._logger.info(f'{played:.1f} of {self._duration:g} s played, {share:.0%}')
            else:
                self._logger.info(f'{played:.0f} s played')

    def close(self) -> None:
        """Close the bar, so that what follows begins on a new line."""
        if self._bar is not None:
            self._bar.close()


def _bar(duration: float) -> Any:
    try:
        from tqdm import tqdm
    except ImportError:
        return None
    if not math.isfinite(duration):
        return tqdm(bar_format='{n:.1f} s played')
    return tqdm(total=duration, bar_format='{l_bar}{bar}| {n:.1f} of {total:.1f} s')
