# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""From alarm to verdict: when to diagnose which part of the history, and what came of it."""

from collections.abc import Sequence
import math
from pathlib import Path

from ..model.system import PositionerParameters
from ..records.record import RecordError
from .alarm import Alarm
from .diagnosis_run import BusyError, DiagnosisRun
from .history import FEWEST_ROWS, History
from .verdict import FAILED, Verdict, VerdictError, failed, verdict_of

ENOUGH = 0.98
"""Share of the span of the history from which on a record counts as full."""


class Diagnosing:
    """
    Diagnoses one record at a time, in a process beside this one.

    After an alarm it waits until the history is full of what came after the change, so that the
    record is of one valve. An alarm on a channel that has been diagnosed since `forget` starts
    nothing: an alarm comes again for as long as the valve is as it is.
    """

    def __init__(self, reports: Path, hypotheses: Sequence[str], limit: float) -> None:
        self._reports, self._hypotheses, self._limit = reports, tuple(hypotheses), limit
        self._run: DiagnosisRun | None = None
        self._since = math.nan
        self._waits_from: float | None = None
        self._channels: set[str] = set()

    @property
    def runs(self) -> bool:
        """Whether a diagnosis runs."""
        return self._run is not None

    @property
    def waits(self) -> bool:
        """Whether a diagnosis begins once the history is full of what came after an alarm."""
        return self._waits_from is not None

    def state(self, now: float, history: History) -> str:
        """Return what goes on, '' for nothing."""
        if self._run is not None:
            return f'a diagnosis runs, for {now - self._run.began:.0f} of {self._limit:g} s'
        if self._waits_from is not None:
            begin = max(self._waits_from, history.begin)
            have = history.end - begin if history.end > begin else 0.0
            return (f'a diagnosis begins once a record of {history.span:g} s has come since the '
                    f'change; {have:.0f} s have')
        return ''

    def forget(self) -> None:
        """Let an alarm on any channel start a diagnosis again."""
        self._channels.clear()

    def note(self, alarm: Alarm, block: float) -> bool:
        """
        Take an alarm; tell whether it leads to a diagnosis.

        `block` s is the length of what is judged as one: within the first block of those that the
        evidence grew over, the valve may still have been as before.
        """
        if alarm.channel in self._channels or self.waits or self.runs:
            return False
        self._channels.add(alarm.channel)
        self._since, self._waits_from = alarm.since, alarm.since + block
        return True

    def start(self, now: float, history: History, declared: PositionerParameters,
              since: float = math.nan) -> str:
        """
        Diagnose what there is now; return '' where it was started, else why not, a sentence.

        The record begins after the alarm that is waited for, else at `since` s if that is known.
        """
        if self._run is not None:
            return 'a diagnosis runs already'
        if self._waits_from is None:
            self._since = since
        begin = self._since if self._waits_from is None else self._waits_from
        columns = history.record(-math.inf if math.isnan(begin) else begin)
        count = len(columns.get('time', ()))
        if count < FEWEST_ROWS:
            return f'{count} rows have come, {FEWEST_ROWS} are needed'
        try:
            self._run = DiagnosisRun(
                self._reports, columns, declared, self._hypotheses, self._limit, now)
        except BusyError as busy:
            return str(busy)
        except (OSError, RecordError) as error:
            self._waits_from = None
            return f'the diagnosis cannot be started: {_reason(error)}'
        self._waits_from = None
        return ''

    def turn(self, now: float, history: History, declared: PositionerParameters
             ) -> Verdict | None:
        """Go on without waiting; return the verdict where one has been found."""
        if self._run is not None:
            return self._ended(self._run, now)
        if self._waits_from is None:
            return None
        if history.end < self._waits_from - history.span:  # the clock went back
            self._waits_from = None
            return self._failed('the clock went back before there was a record')
        begin = max(self._waits_from, history.begin)
        if not history.end - begin >= ENOUGH * history.span:
            return None
        why_not = self.start(now, history, declared)
        if self.waits or not why_not:  # another one runs in the same folder: later
            return None
        return self._failed(why_not)

    def _ended(self, run: DiagnosisRun, now: float) -> Verdict | None:
        trouble = run.trouble(now)
        if trouble is None:
            return None
        self._run = None
        since, self._since = self._since, math.nan
        if trouble:
            return failed(trouble, run.folder, since)
        try:
            return verdict_of(run.folder, since)
        except VerdictError as error:
            return failed(str(error), run.folder, since)

    def _failed(self, reason: str) -> Verdict:
        since, self._since = self._since, math.nan
        return Verdict(FAILED, reason, '', since, '', ())

    def end(self) -> None:
        """End what runs."""
        if self._run is not None:
            self._run.end()
            self._run = None


def _reason(error: Exception) -> str:
    if isinstance(error, OSError):
        return f'{error.filename}: {error.strerror}' if error.filename else str(error.strerror)
    return str(error)
