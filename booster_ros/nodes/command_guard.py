# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The current that drives the positioner: commands are checked, stale ones held or vented."""

import math
from typing import NamedTuple

from ..parameters.schema import LIMIT, VENT, NodeSettings
from .tick_clock import nanoseconds

NOT_A_NUMBER = 'not a number'
INFINITE = 'infinite'
BELOW = 'below the lower limit'
ABOVE = 'above the upper limit'
CAUSES = (NOT_A_NUMBER, INFINITE, BELOW, ABOVE)


class CommandRules(NamedTuple):
    """
    What is done with commands: limits, policies by name, timeout in s (0: never stale).

    `name` and `unit` are those of what is commanded, `limits` says where its limits are from,
    `vented` is the command in force where a stale one vents.
    """

    low: float
    high: float
    invalid_current: str
    command_timeout: float
    stale_command: str
    name: str = 'control_current'
    unit: str = 'A'
    limits: str = 'current_limits'
    vented: float = 0.0


def rules_of(settings: NodeSettings) -> CommandRules:
    """Return the rules that the parameters of the node give."""
    low, high = settings.current_limits
    return CommandRules(
        low, high, settings.invalid_current, settings.command_timeout, settings.stale_command)


class Verdict(NamedTuple):
    """The current to use in A, None when the command is refused, and what was wrong with it."""

    current: float | None
    cause: str | None


def judge(current: float, rules: CommandRules) -> Verdict:
    """
    Check a commanded current, A.

    Numbers that are not finite say nothing about the current that is wanted, so that there is
    nothing to limit them to: they are refused under either policy.

    >>> judge(0.45, CommandRules(0.0, 0.002, 'limit', 0.0, 'hold'))
    Verdict(current=0.002, cause='above the upper limit')
    """
    if math.isnan(current):
        return Verdict(None, NOT_A_NUMBER)
    if math.isinf(current):
        return Verdict(None, INFINITE)
    if rules.low <= current <= rules.high:
        return Verdict(current, None)
    cause, limit = (BELOW, rules.low) if current < rules.low else (ABOVE, rules.high)
    return Verdict(limit if rules.invalid_current == LIMIT else None, cause)


class CommandGuard:
    """
    Keeps the command in force: the last one that was not refused, unless it has gone stale.

    Age is counted in simulated time, so that a paused simulation does not age its command and a
    lockstep run is repeatable. A refused command does not refresh the one in force.
    """

    def __init__(self, rules: CommandRules, current: float = 0.0) -> None:
        self.rules = rules
        self.refused = dict.fromkeys(CAUSES, 0)
        """Commands refused so far, by cause."""
        self.limited = dict.fromkeys(CAUSES, 0)
        """Commands limited so far, by cause."""
        self.accepted = 0
        """Commands taken over so far, limited ones included."""
        self.last_cause = ''
        """What was wrong with the last bad command."""
        self.force(current)

    def force(self, current: float) -> None:
        """Put `current` (A) in force as if no command had come yet; it does not go stale."""
        self._current = current
        self._arrived: int | None = None
        self._new = False
        self._stale = False

    def follow(self, rules: CommandRules) -> bool:
        """
        Follow these rules from now on; return whether they limit the current in force.

        It is limited whatever the rules say of bad commands: it was accepted, and no command
        before it is known to be within the new limits.
        """
        self.rules = rules
        before = self._current
        self._current = min(max(before, rules.low), rules.high)
        return self._current != before and not self.vents

    @property
    def current(self) -> float:
        """The command in force: 0 A where a stale one vents, whatever the limits are."""
        return self.rules.vented if self.vents else self._current

    @property
    def vents(self) -> bool:
        """Whether the last command is stale and nothing is to drive the valve."""
        return self._stale and self.rules.stale_command == VENT

    @property
    def bad(self) -> int:
        """Commands refused or limited so far."""
        return sum(self.refused.values()) + sum(self.limited.values())

    @property
    def waiting(self) -> bool:
        """Whether no command has come since the start or the last reset."""
        return self._arrived is None and not self._new

    @property
    def stale(self) -> bool:
        """Whether the last command is older than the timeout."""
        return self._stale

    def offer(self, current: float) -> Verdict:
        """Take a commanded current (A) over at the next tick, unless it is refused."""
        verdict = judge(current, self.rules)
        if verdict.cause is not None:
            counts = self.refused if verdict.current is None else self.limited
            counts[verdict.cause] += 1
            self.last_cause = verdict.cause
        if verdict.current is not None:
            self.accepted += 1
            self._current = verdict.current
            self._new = True
        return verdict

    def complaint(self, current: float, verdict: Verdict) -> str:
        """Return the sentence about a bad command of this current, A."""
        rules, done = self.rules, 'refused' if verdict.current is None else 'limited'
        return (
            f'{rules.name} {current:g} {rules.unit} is {verdict.cause} ({rules.limits} '
            f'{rules.low:g} to {rules.high:g} {rules.unit}): {done}, {self.current:g} {rules.unit} '
            f'in force; bad commands so far: {self.bad}')

    def at_tick(self, simulated: int) -> float:
        """Return the current, A, for the tick that starts at this simulated time (ns)."""
        if self._new:
            self._arrived = simulated
            self._new = False
        timeout = self.rules.command_timeout
        self._stale = (
            timeout > 0.0
            and self._arrived is not None
            and simulated - self._arrived > nanoseconds(timeout)
        )
        return self.current
