# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which faults are on at a tick, and how far they have grown."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from ..model.outputs import Outputs
from .injection import AT_ONCE, Injection


@dataclass
class Running:
    """An injection of a schedule. `share` of its full strength is on now, 0 to 1."""

    injection: Injection
    share: float = 0.0
    began: float | None = None
    """Simulated time, s, at which it came on."""
    ended: float | None = None
    """Simulated time, s, from which on it goes."""
    share_at_end: float = 0.0

    @property
    def on(self) -> bool:
        """Whether it is on, however little."""
        return self.began is not None and (self.ended is None or self.share > 0.0)

    @property
    def over(self) -> bool:
        """Whether it has been on and is no more."""
        return self.ended is not None and self.share <= 0.0


class Schedule:
    """
    Faults over time. `advance` it before each tick; what is over is forgotten.

    Of the same fault injected again, the later one replaces the one before.
    """

    def __init__(self, timetable: Iterable[Injection] = ()) -> None:
        """Begin with the injections of a timetable."""
        self._running = [Running(injection) for injection in timetable]

    def add(self, injection: Injection) -> None:
        """Add an injection; one that begins at once replaces one of the same fault that is on."""
        if injection.begin == AT_ONCE:
            self.remove(injection.name)
        self._running.append(Running(injection))

    def remove(self, name: str) -> None:
        """Switch a fault off at once, and let none of that name come any more."""
        self._running = [one for one in self._running if one.injection.name != name]

    @property
    def on(self) -> list[Running]:
        """The faults that are on, in the order in which they were added."""
        return [one for one in self._running if one.on]

    @property
    def waiting(self) -> int:
        """How many are still to come."""
        return sum(one.began is None for one in self._running)

    def advance(self, time: float, tick: int, see: Callable[[], Outputs]) -> None:
        """
        Go on to the tick that starts at `time` (s), the number `tick` since the reset.

        `see` returns the outputs now; it is called where a condition asks for them only.
        """
        seen: list[Outputs] = []

        def outputs() -> Outputs:
            if not seen:
                seen.append(see())
            return seen[0]

        for one in self._running:
            _advance(one, time, tick, outputs)
        if any(one.over for one in self._running):
            self._running = [one for one in self._running if not one.over]


def _advance(one: Running, time: float, tick: int, outputs: Callable[[], Outputs]) -> None:
    given = one.injection
    if one.began is None:
        seen = outputs() if given.begin.condition else None
        if not given.begin.has_come(time, tick, seen):
            return
        one.began = time
    if one.ended is None:
        since = time - one.began
        one.share = min(since / given.ramp, 1.0) if given.ramp > 0.0 else 1.0
        seen = outputs() if given.end.condition else None
        # half a nanosecond, as a sum of periods is rarely a float
        if since >= given.duration - 5e-10 or given.end.has_come(time, tick, seen):
            one.ended, one.share_at_end = time, one.share
    if one.ended is not None:
        gone = (time - one.ended) / given.ramp_down if given.ramp_down > 0.0 else 1.0
        one.share = one.share_at_end * max(1.0 - gone, 0.0)
