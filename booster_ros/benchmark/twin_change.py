# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""One change of a drawn valve beside its twin, over topics, faster than real time."""

import json
import math
from pathlib import Path
import shutil
import time
from typing import NamedTuple

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
import numpy as np
from rclpy.node import Node
from std_msgs.msg import Float64, String
from std_srvs.srv import Trigger

from ..model.catalogue import EFFECTS
from ..nodes.ready import LATCHED
from ..nodes.twin import TwinNode
from ..testing import Valve
from .twin_valves import NOISE, near

NONE = 'none'

RATE = 20.0
TRIED = (
    'dead_time', 'ep_gain_loss', 'chamber_leak', 'exhaust_seat_leak', 'stem_friction',
    'stem_damping', 'effective_area_change', 'bench_set_shift', 'spring_rate_change',
    'position_backlash', 'position_sensor_bias', 'pressure_sensor_bias')
"""Hypotheses: what a valve may get, and two that look alike."""

SETTINGS = {'block': 1.0, 'learning': 600.0, 'false_alarms': 20.0, 'history': 40.0,
            'trial': 20.0, 'adopt_confirmed': True, 'diagnosis_timeout': 900.0,
            'hypotheses': ' '.join(TRIED)}
"""Blocks are shorter than by default; for each of them as many false alarms are promised as there,
and three times as many are learnt."""

LEARNT, BEFORE, PATIENCE, JUDGED = 630.0, 20.0, 90.0, 20.0
"""Time in which a valve is learnt, time after a restart before it changes, time in which an alarm
may come, and over which errors are taken, s."""

PIECE = 5.0


class Came(NamedTuple):
    """What came of a change; errors are root mean squares over both channels, in noise."""

    seed: int
    fault: str
    strength: float
    early: bool
    """Whether the valve was said not to be well before the change."""
    delay: float | None
    """From the change to the alarm, s; None where none came."""
    noticed: float | None
    """From the change to a health that is not good, with an alarm or without, s."""
    kind: str
    effects: list[str]
    places: list[str]
    group: list[str]
    """The effects found, and all that the report says they may be instead."""
    standing: str
    adoption: str
    before: float
    after: float | None
    """Error of the model before and, where one was adopted, of the adopted one."""

    @property
    def place(self) -> str:
        """Where the change is."""
        return '' if self.fault == NONE else EFFECTS[self.fault].location


class Bystander(Node):
    """Moves the valve, and hears what its twin says."""

    def __init__(self, valve: Valve, twin: TwinNode, random: np.random.Generator) -> None:
        super().__init__('bystander', context=valve.context)
        self._valve, self._twin = valve, twin
        self._ticks = 0
        self._middle = random.uniform(0.425e-3, 0.441e-3)
        self._width = random.uniform(3e-6, 8e-6)
        self._frequencies = random.uniform(0.1, 0.9, 3)
        self._current = self.create_publisher(Float64, 'control_current', 10)
        self.alarms: list[float] = []
        """When alarms came, s of the valve."""
        self.verdict: DiagnosticStatus | None = None
        self._state = ''
        self.unwell = math.nan
        """When the valve was first said not to be well, s."""
        self._left: list[tuple[float, str, float]] = []
        self.create_subscription(String, 'twin/alarm', self._on_alarm, LATCHED)
        self.create_subscription(DiagnosticStatus, 'twin/verdict', self._on_verdict, LATCHED)
        self.create_subscription(DiagnosticArray, 'twin/residuals', self._on_residuals, 10)
        self.create_subscription(DiagnosticArray, '/diagnostics', self._on_diagnostics, 10)
        self.create_subscription(Float64, 'valve_position', lambda message: None, 10)
        valve.add(twin)
        valve.add(self)

    def _on_alarm(self, message: String) -> None:
        self.alarms.append(self.now)

    def _on_verdict(self, message: DiagnosticStatus) -> None:
        self.verdict = message

    def _on_residuals(self, message: DiagnosticArray) -> None:
        for status in message.status:
            values = {one.key: float(one.value) for one in status.values}
            self._left.append((self.now, status.name, values['reading'] - values['predicted']))

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name == 'twin: diagnosis':
                self._state = status.message
            elif status.name == 'twin: valve' and math.isnan(self.unwell) and (
                    status.level != DiagnosticStatus.OK):
                self.unwell = self.now

    @property
    def now(self) -> float:
        """Time of the valve, s."""
        return self._ticks / RATE

    @property
    def told(self) -> dict[str, str]:
        """What the last verdict says for programs."""
        return {} if self.verdict is None else {one.key: one.value for one in self.verdict.values}

    def move(self, seconds: float) -> None:
        """Let the valve move for so long, and then the twin say how things stand."""
        for _ in range(round(seconds * RATE)):
            self._ticks += 1
            angles = 2.0 * np.pi * self._frequencies * self.now
            self._current.publish(Float64(
                data=self._middle + self._width * float(np.sin(angles).sum())))
            self._valve.step()
            if self._ticks % 5 == 0:
                self._twin.turn()
        self._twin.report()
        self._valve.turn()
        while self._state.startswith('a diagnosis runs'):  # in real time, which stands for none
            time.sleep(0.1)
            self._twin.turn()
            self._twin.report()
            self._valve.turn()

    def diagnose(self) -> None:
        """Call ~/diagnose and wait for what comes of it."""
        client = self.create_client(Trigger, 'twin/diagnose')
        answer = client.call_async(Trigger.Request())
        while not answer.done():
            self._valve.turn()
        self.move(1.0 / RATE)

    def error(self, begin: float, end: float) -> float:
        """Return what the model leaves from `begin` to `end` s, in noise, over both channels."""
        squares = [(left / NOISE[name])**2 for at, name, left in self._left if begin <= at < end]
        return math.sqrt(sum(squares) / len(squares)) if squares else math.nan


class Drawn:
    """A valve near the model that the twin has, but not equal, with readings that have noise."""

    def __init__(self, number: int, noise: int) -> None:
        """Draw valve and course by `number`, and the noise by `noise`."""
        self.random = np.random.default_rng([number, 1])
        self.parameters = {
            **near(self.random), 'publish_rate': RATE, 'measurement.seed': noise,
            'measurement.pressure_noise': NOISE['chamber_pressure'],
            'measurement.position_noise': NOISE['valve_position']}

    def beside(self, valve: Valve, **settings: str) -> Bystander:
        """Return who moves the valve, a twin beside it."""
        twin = TwinNode(context=valve.context, parameter_overrides={**SETTINGS, **settings})
        return Bystander(valve, twin, self.random)


def learn(number: int, memory: Path) -> None:
    """Let a twin learn a drawn valve, and keep that in a file."""
    drawn = Drawn(number, 0)
    with Valve(drawn.parameters) as valve:
        drawn.beside(valve, memory=str(memory)).move(LEARNT)


def changed(
    seed: int, number: int, memory: Path, fault: str, strength: float, folder: Path,
) -> Came:
    """
    Restart the twin of a valve that has been learnt, and let this valve change.

    `strength` is in sizes that a record shows well; `folder` gets memory and reports.
    """
    folder.mkdir(exist_ok=True)
    own = folder / memory.name
    shutil.copyfile(memory, own)
    drawn = Drawn(number, seed + 1)
    with Valve(drawn.parameters) as valve:
        beside = drawn.beside(valve, memory=str(own), reports=str(folder / 'reports'))
        beside.move(BEFORE)
        early, at = beside.unwell < beside.now, beside.now
        if fault != NONE:
            valve.inject(fault, strength=strength)
        while beside.verdict is None and (beside.now < at + PATIENCE or beside.alarms):
            beside.move(PIECE)
        if beside.verdict is None:
            beside.diagnose()
        judged = beside.now
        while beside.told['adoption'] == 'on trial':
            beside.move(PIECE)
        before, after = beside.error(judged - JUDGED, judged), None
        if beside.told['adoption'].startswith('adopted'):
            tried = beside.now
            beside.move(JUDGED)
            after = beside.error(tried, beside.now)
        return Came(
            seed, fault, strength, early, _delay(beside.alarms, at),
            _delay([beside.unwell], at), beside.told['kind'],
            beside.told['effects'].split(), *_found(beside.told['report']),
            beside.told['standing'], beside.told['adoption'], before, after)


def _delay(alarms: list[float], changed_at: float) -> float | None:
    return next((alarm - changed_at for alarm in alarms if alarm > changed_at), None)


def _found(report: str) -> tuple[list[str], list[str]]:
    """Return the places that a report names, and its effects with what they may be instead."""
    path = Path(report) / 'report.json'
    effects = json.loads(path.read_text(encoding='utf-8'))['effects'] if path.exists() else []
    return ([one['location'] for one in effects],
            [name for one in effects for name in (one['name'], *one['confused_with'])])
