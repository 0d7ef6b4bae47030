# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The node `twin`: the model of a valve beside the real one, and what the valve does differently.

Everything happens in one thread: samples wait for the next turn of a timer. `docs/twin.md`
describes topics, parameters, alarms.
"""

from collections.abc import Mapping, Sequence
import math
import sys
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
import numpy as np
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.context import Context
from rclpy.node import Node
from std_msgs.msg import Float64, Header, String
from std_srvs.srv import Trigger

from ..model.parameters import ParameterError, from_values
from ..model.system import PositionerParameters
from ..parameters.file import read_parameter_file
from ..twin.alarm import Alarm
from ..twin.condition import condition
from ..twin.health import FAILURE, GOOD, MAINTENANCE, OUT_OF_SPECIFICATION
from ..twin.settings import DESCRIPTIONS, TwinSettings, check, checked
from ..twin.store import Store, StoreError
from ..twin.trends import Counters
from ..twin.twin import Twin
from ..twin.verdict import moment
from .declaration import check_files, declare_table, destroyed_if_refused, overrides_of
from .outputs import quiet_publisher
from .process import run
from .ready import LATCHED, Ready
from .twin_answers import Answers
from .twin_inputs import TwinInputs
from .twin_memory import TwinMemory

DESCRIPTION = 'Run the model of a valve beside the real one, as a ROS 2 node.'
EXAMPLE = '--ros-args --params-file twin.yaml -p model:=positioner.yaml\n' \
    'All parameters: docs/twin.md, or `ros2 param describe` while it runs.'

LEVELS = {GOOD: DiagnosticStatus.OK, FAILURE: DiagnosticStatus.ERROR,
          OUT_OF_SPECIFICATION: DiagnosticStatus.WARN, MAINTENANCE: DiagnosticStatus.WARN}
"""Levels by NE 107 status; a function check is OK: the valve may be well."""

REST = 0.01
"""Time, s, that samples may wait: a hundred a second of each channel then come in one go, at two
thirds of the cost."""

REPORT_PERIOD = 1.0
STORE_PERIOD = 60.0
"""Seconds from one report, and from one row of trends, to the next."""


class TwinNode(Node):
    """Runs the model beside a real valve; ParameterError for bad parameters."""

    def __init__(
        self, arguments: Sequence[str] = (), *, node_name: str = 'twin',
        parameter_overrides: Mapping[str, Any] | None = None, context: Context | None = None,
    ) -> None:
        """Start; `arguments` is the command line, for the parameter files on it."""
        super().__init__(
            node_name, context=context,
            parameter_overrides=overrides_of(parameter_overrides or {}),
            automatically_declare_parameters_from_overrides=True)
        with destroyed_if_refused(self):
            self._begin(arguments)

    def _begin(self, arguments: Sequence[str]) -> None:
        check_files(arguments, self.get_fully_qualified_name(), checked)
        self._settings: TwinSettings = declare_table(
            self, DESCRIPTIONS, DESCRIPTIONS.keys(), checked, check)
        declared = _model(self._settings.model)
        self._memory = TwinMemory(self.get_logger(), self._settings.memory, declared)
        recalled = self._memory.recalled
        self.twin = Twin(recalled.model or declared, self._settings.alarms,
                         history=self._settings.answers.history)
        if recalled.calibration is not None:
            self.twin.recall(recalled.calibration)
        self._store = _store(self._settings.store)
        before = self._store.latest() if self._store else {}
        self._counters = Counters(0.002 * self.twin.parameters.actuator.travel, before)
        self._said = {name: quiet_publisher(self, Float64, f'~/{name}')
                      for name in ('chamber_pressure', 'valve_position')}
        self._residuals = quiet_publisher(self, DiagnosticArray, '~/residuals')
        self._trends = quiet_publisher(self, DiagnosticArray, '~/trends')
        self._alarms = self.create_publisher(String, '~/alarm', LATCHED)
        self._diagnostics = quiet_publisher(self, DiagnosticArray, '/diagnostics')
        self._answers = Answers(
            self, self.twin, self._settings.answers, recalled, self.remember)
        self._inputs = TwinInputs(self, self._on_sample)
        self._read: list[float] = []
        self._condition: dict[str, float] = {}
        """Figures of the valve by the last minutes, as they were told last."""
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(1.0 / self._settings.rate, self.turn, clock=steady)
        self.create_timer(REPORT_PERIOD, self.report, clock=steady)
        self.create_timer(STORE_PERIOD, self.keep, clock=steady)
        self.create_service(Trigger, '~/acknowledge', self._on_acknowledge)
        self._ready = Ready(self)

    def _on_sample(self, channel: str, stamp: float, value: float) -> None:
        self.twin.add(channel, stamp, value)
        if channel == 'valve_position':
            self._read.append(value)

    def turn(self) -> None:
        """Use the samples that have come, and publish what comes of them."""
        self._inputs.flush()
        found = self.twin.update()
        if self.twin.remark:
            self.get_logger().info(self.twin.remark)
            self.twin.remark = ''
        for name, now in self.twin.now.items():
            self._said[name].publish(Float64(data=now.said))
        self._residuals.publish(self._array([_residual(name, now)
                                             for name, now in self.twin.now.items()]))
        for alarm in found:
            self._on_alarm(alarm)
        said_more = self._answers.turn()
        if found:
            self.remember()
        if found or said_more:
            self.report()

    def _on_alarm(self, alarm: Alarm) -> None:
        sentence = f'{alarm.sentence}, since {moment(alarm.since)}'
        self.get_logger().warning(sentence)
        self._alarms.publish(String(data=sentence))
        if self._store:
            self._store.alarm(*alarm, alarm.sentence)
        self._answers.on_alarm(alarm)

    def report(self) -> None:
        """Publish health and trends."""
        status, reason = self.twin.health
        alarms, counts = self.twin.alarms, self.twin.aligner.counts
        values = {'status': status, 'false alarms promised [1/year]': (
            f'{self._settings.alarms.false_alarms:g}' if alarms and alarms.promised else 'none')}
        if alarms:
            values |= {'blocks judged': str(alarms.blocks),
                       'evidence, share of an alarm': f'{alarms.evidence:.3f}'}
        values |= {f'samples: {name}': str(count) for name, count in vars(counts).items()}
        self._diagnostics.publish(self._array([
            DiagnosticStatus(
                level=LEVELS.get(status, DiagnosticStatus.OK), name=f'{self._full_name()}: valve',
                message=f'{status}: {reason}', hardware_id='real valve',
                values=[KeyValue(key=key, value=value) for key, value in values.items()]),
            self._answers.status(f'{self._full_name()}: diagnosis')]))
        self._trends.publish(self._array([DiagnosticStatus(
            name='trends', values=[KeyValue(key=key, value=repr(value))
                                   for key, value in self._trend_values().items()])]))

    def remember(self) -> None:
        """Keep what has to be known again after a restart."""
        self._memory.save(self.twin, self._answers)

    def keep(self) -> None:
        """Find the valve's condition, append the trends to the store, keep what has been learnt."""
        if self._memory.is_due(self.twin):
            self.remember()
        self._condition = condition(self.twin.history.record(), self.twin.parameters).values
        if self._store and self.twin.now:
            self._store.trends(max(now.time for now in self.twin.now.values()),
                               self._trend_values())

    def _trend_values(self) -> dict[str, float]:
        read, self._read = self._read, []
        if read:
            self._counters.add(np.array(read))
        values = {**self._counters.values, **self._condition}
        for name, now in self.twin.now.items():
            values |= {f'{name}: {key}': value for key, value in (
                ('residual', now.read - now.said), ('misfit', now.uncertainty),
                ('noise', now.noise)) if math.isfinite(value)}
        return values

    def _array(self, statuses: list[DiagnosticStatus]) -> DiagnosticArray:
        return DiagnosticArray(
            header=Header(stamp=self.get_clock().now().to_msg()), status=statuses)

    def _full_name(self) -> str:
        return self.get_fully_qualified_name().lstrip('/')

    def _on_acknowledge(self, request: Trigger.Request, response: Trigger.Response
                        ) -> Trigger.Response:
        count = len(self.twin.latched)
        self.twin.acknowledge()
        self._answers.forget()
        self.remember()
        response.success, response.message = True, f'{count} alarms acknowledged'
        self.report()
        return response

    def destroy_node(self) -> None:
        """End what runs, and keep the last trends and what was learnt."""
        self._answers.end()
        self.remember()
        if self._store:
            self.keep()
            self._store.close()
            self._store = None
        super().destroy_node()


def _residual(name: str, now: Any) -> DiagnosticStatus:
    return DiagnosticStatus(name=name, values=[
        KeyValue(key=key, value=repr(value)) for key, value in (
            ('time [s]', now.time), ('reading', now.read), ('predicted', now.said),
            ('uncertainty', now.uncertainty), ('residual in noise', now.in_noise))])


def _model(path: str) -> PositionerParameters:
    return from_values(read_parameter_file(path).physical if path else {})


def _store(path: str) -> Store | None:
    try:
        return Store(path) if path else None
    except StoreError as error:
        raise ParameterError(f'store: {error}') from None


def main(args: Sequence[str] | None = None) -> int:
    """Run the node; `args` is the command line without the program's name."""
    arguments = sys.argv[1:] if args is None else list(args)
    return run('twin', DESCRIPTION, lambda: TwinNode(arguments), arguments, EXAMPLE, REST)


if __name__ == '__main__':
    sys.exit(main())
