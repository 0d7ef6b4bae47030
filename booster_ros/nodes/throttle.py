# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Warnings that come once, and again only after a while."""


class Throttle:
    """
    Lets the first warning of each kind pass, then one per `period` (any unit of time).

    >>> throttle = Throttle(10)
    >>> [throttle.passes('hot', now) for now in (0, 5, 9, 10)]
    [True, False, False, True]
    """

    def __init__(self, period: int) -> None:
        self._period = period
        self._last: dict[str, int] = {}

    def passes(self, kind: str, now: int) -> bool:
        """Tell whether a warning of this kind is to be given at `now`."""
        last = self._last.get(kind)
        if last is not None and now - last < self._period:
            return False
        self._last[kind] = now
        return True
