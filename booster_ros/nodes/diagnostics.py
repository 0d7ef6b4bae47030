# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
What `/diagnostics` says about a positioner.

One report each on time, simulation, command, parameters, topics and faults.
"""

from collections.abc import Sequence
from typing import NamedTuple

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from std_msgs.msg import Header

from ..parameters.schema import VENT
from .command_guard import CommandGuard
from .deviation import TravelDeviation
from .tick_clock import NANOSECONDS, TickClock

OK, WARN, ERROR = 0, 1, 2
"""Levels of a report, as diagnostic_msgs numbers them."""

HARDWARE = 'simulated positioner'


class Report(NamedTuple):
    """One diagnostic status: level, name of the task, one line, and details."""

    level: int
    task: str
    message: str
    values: dict[str, str]


class ClockState(NamedTuple):
    """State of the node's clock: which it is, and what was seen of it since the last report."""

    follows_clock_topic: bool
    started: bool
    """The clock shows a time (simulated time is zero before the first /clock message)."""
    stands_still: bool
    """The clock showed the same time at the last report."""
    paused: bool
    """The simulation was paused by service."""


class Loss(NamedTuple):
    """The loss of the model's state: it is no longer finite, and stays so."""

    moment: int
    """Simulated time, ns, of the tick that could not be published."""
    reset: str
    """The name of the service that gives the model a state again."""

    def __str__(self) -> str:
        """Return the sentence that says so and what helps."""
        return (
            f'the model cannot be simulated with these parameters: its state is no finite number '
            f'at {seconds(self.moment)} s of simulated time, nothing is published until other '
            f'parameters are set and {self.reset} is called')


def time_report(
    clock: ClockState, ticks: TickClock, late_before: int, thinned: int = 0
) -> Report:
    """Report on the clock and late ticks; `late_before` of these were known at the last report."""
    level, message = OK, 'on time'
    late = ticks.late_ticks - late_before
    if clock.follows_clock_topic and not clock.started:
        level, message = WARN, 'use_sim_time is true, but nothing has come on /clock'
    elif clock.paused:
        message = 'paused by ~/pause'
    elif clock.follows_clock_topic and clock.stands_still:
        message = '/clock stands still'
    elif ticks.backlog > 0:
        level, message = WARN, f'ticks behind: {ticks.backlog}'
    elif thinned:
        level, message = WARN, 'behind until lately'
    elif late > 0 and not clock.follows_clock_topic:
        level, message = WARN, f'late ticks caught up: {late}'
    if thinned:
        message += '; the stamped topics and ~/state are thinned out (does a subscription hang?)'
    return Report(level, 'time', message, {
        'clock': '/clock' if clock.follows_clock_topic else 'wall time',
        'simulated time [s]': seconds(ticks.simulated),
        'ticks': str(ticks.total_ticks),
        'late ticks': str(ticks.late_ticks),
        'caught up [s]': seconds(ticks.late_ticks * ticks.period),
        'longest delay [s]': seconds(ticks.longest_delay),
        'ticks behind': str(ticks.backlog),
        'skipped forward jumps of the clock [s]': seconds(ticks.skipped),
        'backward jumps of the clock': str(ticks.backward_jumps),
    })


def simulation_report(loss: Loss | None) -> Report:
    """Report on the state of the model."""
    if loss is None:
        return Report(OK, 'simulation', 'its state is finite', {})
    return Report(ERROR, 'simulation', str(loss), {
        'lost at simulated time [s]': seconds(loss.moment)})


def command_report(guard: CommandGuard, bad_before: int) -> Report:
    """Report on the command in force; `bad_before` bad ones were known at the last report."""
    level, message = OK, 'in force'
    bad = guard.bad - bad_before
    if bad > 0:
        level, message = WARN, f'bad commands: {bad}, the last one was {guard.last_cause}'
    elif guard.stale:
        done = 'vented' if guard.rules.stale_command == VENT else 'held'
        level, message = WARN, f'stale, {done}'
    elif guard.waiting:
        message = 'no command yet'
    name = {'control_current': 'current', 'set_point': 'set point'}[guard.rules.name]
    values = {f'{name} in force [{guard.rules.unit}]': repr(guard.current),
              'accepted': str(guard.accepted)}
    values |= {f'refused: {cause}': str(count) for cause, count in guard.refused.items()}
    values |= {f'limited: {cause}': str(count) for cause, count in guard.limited.items()}
    return Report(level, 'command', message, values)


def parameter_report(changes: int, last_change: str) -> Report:
    """Report on the changes of parameters at run time."""
    message = f'last change: {last_change}' if last_change else 'as started'
    return Report(OK, 'parameters', message, {'changes': str(changes)})


def travel_report(watch: TravelDeviation) -> Report:
    """Report on how far the valve is from its set point."""
    level, message = OK, 'within the band'
    if watch.alarm:
        level = WARN
        message = f'off the set point by {watch.deviation:.3g} m for {watch.delay:g} s or longer'
    return Report(level, 'travel', message, {
        'travel deviation [m]': repr(watch.deviation), 'alarm band [m]': repr(watch.band)})


def topic_report(trouble: Sequence[str]) -> Report:
    """Report on other nodes, of which `trouble` says what is in the way."""
    if not trouble:
        return Report(OK, 'topics', 'nobody is in the way', {})
    return Report(WARN, 'topics', '; '.join(trouble), {'in the way': str(len(trouble))})


def fault_report(faults: Sequence[str], to_come: int) -> Report:
    """Report on the faults that are on, and how many are to come."""
    values = {'to come': str(to_come)}
    if not faults:
        return Report(OK, 'faults', 'none on', values)
    return Report(WARN, 'faults', f'on: {", ".join(faults)}', values)


def diagnostic_message(reports: Sequence[Report], node: str, stamp: Time) -> DiagnosticArray:
    """Return the reports of a node as the message for `/diagnostics`."""
    return DiagnosticArray(header=Header(stamp=stamp), status=[
        DiagnosticStatus(
            level=bytes([report.level]), name=f'{node.lstrip("/")}: {report.task}',
            message=report.message, hardware_id=HARDWARE,
            values=[KeyValue(key=key, value=value) for key, value in report.values.items()])
        for report in reports])


def seconds(nanoseconds: int) -> str:
    """
    Return nanoseconds as seconds, exactly.

    >>> seconds(1_010_000_000)
    '1.010000000'
    """
    return f'{nanoseconds // NANOSECONDS}.{nanoseconds % NANOSECONDS:09d}'
