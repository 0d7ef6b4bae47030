# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the twin does about an alarm: a diagnosis, a verdict, and a found model on trial."""

from __future__ import annotations

from collections.abc import Callable
import math
from pathlib import Path
import time

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from rclpy.node import Node
from std_srvs.srv import Trigger

from ..model.parameters import ParameterError, from_values, to_values
from ..model.system import PositionerParameters
from ..parameters.file import read_parameter_file
from ..twin.alarm import Alarm
from ..twin.diagnosing import Diagnosing
from ..twin.memory import Memory, OnTrial
from ..twin.settings import AnswerSettings
from ..twin.twin import Twin
from ..twin.verdict import FAILED, FOUND, NOTHING, Verdict
from .ready import LATCHED
from .remote_parameters import RemoteParameters

OFF = 'nothing is diagnosed, as the parameter reports names no folder'
TRYING = 'on trial'

LEVELS = {NOTHING: DiagnosticStatus.OK, FOUND: DiagnosticStatus.WARN,
          FAILED: DiagnosticStatus.ERROR}


class Answers:
    """
    Offers ~/diagnose and ~/adopt, publishes ~/verdict; `turn` has to be called now and then.

    `changed` is called when something is to be kept over a restart. ParameterError where reports
    cannot be written.
    """

    def __init__(self, node: Node, twin: Twin, settings: AnswerSettings, recalled: Memory,
                 changed: Callable[[], None]) -> None:
        self._node, self._twin, self._settings = node, twin, settings
        self._changed = changed
        self._log = node.get_logger()
        self._diagnosing = Diagnosing(
            _folder(settings.reports), settings.hypotheses, settings.diagnosis_timeout
        ) if settings.reports else None
        self.adopted: PositionerParameters | None = recalled.model
        """The model that was adopted and kept."""
        self.verdict = recalled.verdict
        """The last verdict."""
        self.on_trial: OnTrial | None = None
        """The positioner that has a model on trial, and what it had before."""
        self._remote: RemoteParameters | None = None
        self._given_up = 0.0
        self._news = False
        self._awaits_alarms = True
        self._publisher = node.create_publisher(DiagnosticStatus, '~/verdict', LATCHED)
        node.create_service(Trigger, '~/diagnose', self._on_diagnose)
        node.create_service(Trigger, '~/adopt', self._on_adopt)
        self._go_on(recalled)

    def _go_on(self, recalled: Memory) -> None:
        """Take up what was when the twin ended."""
        if recalled.model is not None:
            self._log.info('the model that was adopted before the restart goes on')
        if self.verdict is not None:
            if self.verdict.adoption == TRYING:
                self._conclude('rolled back: the twin ended during the trial')
                self._log.warning(f'the found model was {self.verdict.adoption}')
            self._publish()
        if recalled.on_trial is not None:
            self.on_trial = recalled.on_trial
            self._put_back()

    def on_alarm(self, alarm: Alarm) -> None:
        """Diagnose once there is a record, where this alarm tells anything new."""
        alarms = self._twin.alarms
        if self._diagnosing is None or alarms is None or self._twin.trial is not None:
            return
        if self._diagnosing.note(alarm, self._twin.settings.block * (alarms.join or 1)):
            self._log.info(self._state())

    def _answer_earlier(self) -> None:
        """Take up an alarm that there was before a restart, and no verdict yet."""
        self._awaits_alarms = False
        for alarm in sorted(self._twin.latched, key=lambda one: one.since)[:1]:
            if self.verdict is None or not self.verdict.since >= alarm.since:
                self.on_alarm(alarm)

    def forget(self) -> None:
        """Let an alarm start a diagnosis even where one like it has."""
        if self._diagnosing is not None:
            self._diagnosing.forget()

    def turn(self) -> bool:
        """Go on with what runs beside the twin; tell whether there is something new to report."""
        if self._awaits_alarms and self._twin.runs:
            self._answer_earlier()
        if self._remote is not None:
            self._remote.turn()
        if self._diagnosing is not None and self._twin.trial is None:
            found = self._diagnosing.turn(
                time.monotonic(), self._twin.history, self._twin.parameters)
            if found is not None:
                self._on_verdict(found)
        trial = self._twin.trial
        if trial is not None and (trial.is_over or time.monotonic() > self._given_up):
            self._end_trial()
        news, self._news = self._news, False
        return news

    def _on_verdict(self, verdict: Verdict) -> None:
        self.verdict = verdict
        told = f'{verdict.sentence} (report: {verdict.folder})' if verdict.folder else (
            verdict.sentence)
        (self._log.error if verdict.kind == FAILED else self._log.warning)(told)
        self._publish()
        self._changed()
        if self._settings.adopt_confirmed and verdict.is_confirmed:
            self._log.info(self._adopt()[1])

    def _on_diagnose(self, request: Trigger.Request, response: Trigger.Response
                     ) -> Trigger.Response:
        response.success, response.message = False, OFF
        if self._twin.trial is not None:
            response.message = 'a model is on trial, whose end is awaited first'
        elif self._diagnosing is not None:
            why_not = self._diagnosing.start(
                time.monotonic(), self._twin.history, self._twin.parameters,
                min((one.since for one in self._twin.latched), default=math.nan))
            response.success = not why_not
            response.message = why_not or self._state()
            self._news = True
        return response

    def _on_adopt(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success, response.message = self._adopt()
        return response

    def _adopt(self) -> tuple[bool, str]:
        """Put the found model on trial; return whether, and a sentence."""
        verdict = self.verdict
        if self._twin.trial is not None:
            return False, 'a model is on trial already'
        if self._diagnosing is not None and self._diagnosing.runs:
            return False, 'a diagnosis runs, whose end is awaited first'
        if verdict is None or verdict.kind != FOUND:
            return False, 'no diagnosis has found anything that could be adopted'
        if verdict.adoption:
            return False, f'the model of the last verdict was {verdict.adoption}'
        if not self._twin.runs:
            return False, 'nothing has come of the valve yet that models could be compared by'
        try:
            found = from_values(read_parameter_file(
                Path(verdict.folder) / 'positioner.yaml').physical)
        except ParameterError as error:
            return False, str(error)
        self._twin.try_out(found, self._settings.trial, verdict.uncertainty)
        self._given_up = time.monotonic() + 10.0 * self._settings.trial + 60.0
        self._conclude(TRYING)
        self._publish()
        self._changed()
        if self._settings.adopt_into:
            self._give(found)
        return True, (f'the found model is on trial for {self._settings.trial:g} s beside the one '
                      'before, and kept if it predicts better')

    def _end_trial(self) -> None:
        found = self._twin.parameters
        outcome = self._twin.end_trial()
        if outcome.is_kept:
            self.adopted, self.on_trial = found, None
            self.forget()
        self._conclude(f'{"adopted" if outcome.is_kept else "rolled back"}: {outcome.sentence}')
        assert self.verdict is not None
        self._log.warning(f'the found model was {self.verdict.adoption}')
        self._publish()
        self._changed()
        if self.on_trial is not None:
            self._put_back()

    def _conclude(self, adoption: str) -> None:
        assert self.verdict is not None
        self.verdict = self.verdict._replace(adoption=adoption)

    def _positioner(self, name: str) -> RemoteParameters:
        if self._remote is None or self._remote.name != name:
            self._remote = RemoteParameters(self._node, name)
        return self._remote

    def _give(self, found: PositionerParameters) -> None:
        """Set the parameters of the positioner, all or none, and keep what they were."""
        name = self._settings.adopt_into

        def keep(before: dict[str, object]) -> None:
            self.on_trial = OnTrial(name, before)
            self._changed()

        def say(problem: str) -> None:
            if problem:
                self._log.error(f'the found model was not given to {name}: {problem}')
            else:
                self._log.info(f'{name} has the found model')

        self._positioner(name).exchange(to_values(found), keep, say)

    def _put_back(self) -> None:
        """Set the parameters of the positioner to what they were before the trial."""
        assert self.on_trial is not None
        name, before = self.on_trial

        def say(problem: str) -> None:
            self.on_trial = None
            self._changed()
            if problem:
                self._log.error(f'{name} could not be set back to the model before: {problem}')
            else:
                self._log.info(f'{name} has been set back to the model before')

        self._positioner(name).put(before, say)

    def _publish(self) -> None:
        if self.verdict is None:
            return
        self._news = True
        one = self.verdict
        values = {
            'kind': one.kind, 'effects': ' '.join(one.effects), 'standing': one.standing,
            'since [s]': repr(one.since), 'report': one.folder, 'adoption': one.adoption}
        self._publisher.publish(DiagnosticStatus(
            level=LEVELS[one.kind], name=f'{self._node.get_fully_qualified_name()[1:]}: verdict',
            message=one.sentence, hardware_id='real valve',
            values=[KeyValue(key=key, value=value) for key, value in values.items()]))

    def _state(self) -> str:
        """Return what goes on, or the last verdict, in a sentence."""
        if self._twin.trial is not None:
            return (f'the found model is on trial, {self._twin.trial.seconds:.0f} of '
                    f'{self._settings.trial:g} s')
        going_on = '' if self._diagnosing is None else self._diagnosing.state(
            time.monotonic(), self._twin.history)
        if going_on:
            return going_on
        if self.verdict is not None:
            adoption = f'; the found model was {self.verdict.adoption}' if (
                self.verdict.adoption) else ''
            return self.verdict.sentence + adoption
        return OFF if self._diagnosing is None else 'nothing has been diagnosed yet'

    def status(self, name: str) -> DiagnosticStatus:
        """Return what `/diagnostics` says of all this."""
        level = DiagnosticStatus.OK if self.verdict is None else LEVELS[self.verdict.kind]
        if self.verdict is not None and self.verdict.adoption.startswith('adopted'):
            level = DiagnosticStatus.OK  # the twin knows of it now
        return DiagnosticStatus(
            level=level, name=name, message=self._state(), hardware_id='real valve')

    def end(self) -> None:
        """End the diagnosis that runs."""
        if self._diagnosing is not None:
            self._diagnosing.end()


def _folder(path: str) -> Path:
    """Return the folder of reports, made where there is none."""
    folder = Path(path).absolute()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ParameterError(f'reports: {folder}: {error.strerror}') from None
    return folder
