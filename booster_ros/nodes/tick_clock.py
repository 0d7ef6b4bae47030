# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Turn what a clock shows into ticks that are due, and ticks into integration steps.

All of it is counted in whole nanoseconds on a grid of ticks, so that simulated time and the clock
never drift apart, however long it runs and however late the timer calls. Tick n lies n periods
after the start, and the steps up to it are floor(n · period / step): where the period is no
multiple of the step, the remainder is carried to the next tick.
"""

NANOSECONDS = 1_000_000_000


def nanoseconds(seconds: float) -> int:
    """Return `seconds` as a whole number of nanoseconds."""
    return round(seconds * NANOSECONDS)


class TickClock:
    """
    The grid of ticks; knows nothing of where the time comes from.

    `piece` bounds the ticks that one call of `due` hands out, `max_catch_up` is the longest gap of
    the clock (nanoseconds) that is integrated; a longer one is a jump of the clock, not lateness.

    >>> clock = TickClock(period=10, step=4, max_catch_up=1000, piece=8)
    >>> clock.start(100)
    >>> clock.due(109), clock.due(121)
    (0, 2)
    >>> clock.run_tick(), clock.run_tick(), clock.simulated
    (2, 3, 20)
    """

    def __init__(self, period: int, step: int, max_catch_up: int, piece: int) -> None:
        self.period = period
        self.step = step
        self.max_catch_up = max_catch_up
        self.piece = piece
        self.ticks = 0
        """Ticks since the last reset."""
        self.total_ticks = 0
        """Ticks since the program started."""
        self.late_ticks = 0
        """Ticks that ran more than a period after they were due."""
        self.skipped = 0
        """Clock time, ns, that was not simulated because the clock jumped forwards."""
        self.backward_jumps = 0
        """How often the clock jumped backwards."""
        self.longest_delay = 0
        """Longest time from when a tick was due to when it ran, ns."""
        self.jump = 0
        """By how much, ns, the clock had jumped at the last call of `due`; 0 for no jump."""
        self.backlog = 0
        """Ticks that were due at the last call of `due` beyond those it handed out."""
        self._next_due = 0
        self._last_now = 0

    @property
    def simulated(self) -> int:
        """Simulated time since the last reset, ns: the ticks' time on the clock."""
        return self.ticks * self.period

    @property
    def next_due(self) -> int:
        """Where on the clock the next tick lies, ns."""
        return self._next_due

    def start(self, now: int) -> None:
        """Let the next tick be due one period after `now`; time before `now` is not owed."""
        self._next_due = now + self.period
        self._last_now = now
        self.backlog = 0

    def reset(self) -> None:
        """Count simulated time from zero; the grid on the clock stays where it is."""
        self.ticks = 0

    def skip(self) -> int:
        """Use up the next place on the grid without a tick, and return where it lies, ns."""
        self._next_due += self.period
        return self._next_due - self.period

    def due(self, now: int) -> int:
        """
        Return how many ticks to run at clock time `now`, ns; late ones are counted.

        A clock that jumped backwards, or forwards by more than `max_catch_up`, starts a new grid:
        the state of the simulation is kept, the gap is not simulated.
        """
        self.jump = 0
        if now < self._last_now:
            self.jump = now - self._last_now
            self.backward_jumps += 1
            self.start(now)
            return 0
        self._last_now = now
        if now < self._next_due:
            return 0
        if now - self._next_due > self.max_catch_up:
            self.jump = now - self._next_due
            self.skipped += self.jump
            self._next_due = now
        self.longest_delay = max(self.longest_delay, now - self._next_due)
        ticks = (now - self._next_due) // self.period + 1
        handed_out = min(ticks, self.piece)
        self.late_ticks += min(handed_out, ticks - 1)
        self.backlog = ticks - handed_out
        return handed_out

    def run_tick(self) -> int:
        """Go on to the next tick and return the integration steps it takes."""
        before = self.ticks * self.period // self.step
        self.ticks += 1
        self.total_ticks += 1
        self._next_due += self.period
        return self.ticks * self.period // self.step - before
