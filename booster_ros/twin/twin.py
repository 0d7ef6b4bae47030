# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The twin of one valve: samples in; prediction, residuals, alarms and health out."""

from collections.abc import Mapping
from dataclasses import dataclass, field
import math
from typing import Any, NamedTuple

import numpy as np

from ..model.system import PositionerParameters
from ..signals.noise_level import white_noise
from .adoption import Outcome, Trial
from .aligning import CHANNELS, Aligner
from .alarm import Alarm, Alarms, Settings
from .health import Health, health
from .history import History
from .memory import digest_of
from .predictor import COMPARED, POSITION, PRESSURE, Predictor, Prediction
from .summaries import FEWEST_ROWS, KINDS, summary

LISTENING = 3.0
"""Time, s, after which the channels that have come are those that the valve has."""

RECALLING = 30.0
"""The same where a calibration is of channels that have not come yet: who restarts all at once
starts some later than others."""

SILENT = 5.0
"""Time, s, without a sample from which a channel is lost, while others come."""

BEYOND = 1.2
"""Share of the span from which a reading cannot be."""

TIMES_LEARNT = 3.0
"""Factor on the most that the model missed while the valve was learnt, beyond which the valve is no
longer the one that was: also where its operating point is new, and no alarm can be given."""

REMEMBERED = 0.05
"""Weight of a new block in the running levels of noise and residual."""


class Now(NamedTuple):
    """The last row of a channel: reading, prediction and its standard uncertainty, noise (SI)."""

    time: float
    read: float
    said: float
    uncertainty: float
    noise: float

    @property
    def in_noise(self) -> float:
        """The residual in units of the noise."""
        return (self.read - self.said) / self.noise if self.noise > 0.0 else math.nan


@dataclass
class _Running:
    """A model beside the valve, and how the valve is by it."""

    parameters: PositionerParameters
    predictor: Predictor | None = None
    """None before the channels are known."""
    alarms: Alarms | None = None
    misfit: dict[str, float] = field(default_factory=dict)
    learnt: dict[str, float] = field(default_factory=dict)
    """The largest misfit of each channel while the valve was learnt."""
    latched: list[Alarm] = field(default_factory=list)


class Twin:
    """
    Runs the model of `parameters` beside samples of a valve; `settings` are of its alarms.

    `history` is the length, s, of what came last that is kept.
    """

    def __init__(
        self, parameters: PositionerParameters, settings: Settings, compiled: bool = True,
        aligner: Aligner | None = None, history: float = 300.0,
    ) -> None:
        self.settings = settings
        self.aligner = aligner or Aligner()
        self.history = History(history)
        self.trial: Trial | None = None
        """The comparison of the model that runs with the one before, None where there is none."""
        self.remark = ''
        """A sentence on a calibration that was recalled: that it goes on, or why it is no use."""
        self._model = _Running(parameters)
        self._before: _Running | None = None
        """What goes on beside a model on trial, and comes back where that fails."""
        self._recalled: Mapping[str, Any] | None = None
        self.now: dict[str, Now] = {}
        self._compiled = compiled
        self._came: dict[str, float] = {}
        self._begun = math.nan
        self._noise: dict[str, float] = {}
        self._block: Prediction | None = None
        self._gap: float | None = None
        """Longest gap, s, of this valve; None while it is not known."""
        self._rows = 0
        """Rows of the last block."""

    @property
    def parameters(self) -> PositionerParameters:
        """The parameters of the model that runs."""
        return self._model.parameters

    def try_out(self, parameters: PositionerParameters, seconds: float,
                uncertainty: Mapping[str, float] | None = None) -> None:
        """
        Run another model on trial: `seconds` s beside the one so far, see `adoption`.

        `uncertainty` is that of its predictions (SI), by channel, until what it misses here tells.
        What is healthy for it has to be learnt anew.
        """
        if not self.runs:
            raise RuntimeError('nothing runs that another model could be compared with')
        self._before = self._model
        self._model, self._block = _Running(parameters, misfit=dict(uncertainty or {})), None
        assert self._gap is not None
        self.trial = Trial(seconds, self._gap)

    def end_trial(self) -> Outcome:
        """Keep the model on trial if it was better, else go on with the one before."""
        assert self.trial is not None
        assert self._before is not None
        outcome = self.trial.outcome(self._noise)
        if not outcome.is_kept:
            self._model, self._block = self._before, None
        self.trial = self._before = None
        return outcome

    def calibration(self) -> dict[str, Any] | None:
        """
        Return how the valve is while it is healthy, as plain values; None where nothing is known.

        Of a model on trial nothing is told, but of the one before.
        """
        model = self._before or self._model
        if model.alarms is None:
            return None
        return {
            'model': digest_of(model.parameters), 'channels': sorted(self._came),
            'noise': self._noise, 'learnt': model.learnt, 'alarms': model.alarms.as_values(),
            'latched': [list(one) for one in model.latched]}

    def recall(self, calibration: Mapping[str, Any]) -> None:
        """Go on from a calibration once the channels are known; `remark` says if it is no use."""
        if isinstance(calibration.get('channels'), list):
            self._recalled = calibration

    def _restored(self, names: list[tuple[str, str]]) -> Alarms | None:
        """Return the alarms of the calibration that was recalled, None where there is no use."""
        recalled, self._recalled = self._recalled, None
        if recalled is None:
            return None
        try:
            if recalled['model'] != digest_of(self._model.parameters):
                self.remark = 'the calibration is of another model: it is made anew'
                return None
            alarms = Alarms.restored(self.settings, names, recalled['alarms'])
            if alarms is None or recalled['channels'] != sorted(self._came):
                self.remark = ('the calibration is of other channels or of other parameters of '
                               'alarms: it is made anew')
                return None
            self._model.latched = [Alarm(*one) for one in recalled['latched']]
            self._noise, self._model.learnt = (
                {str(name): float(one) for name, one in recalled[kind].items()}
                for kind in ('noise', 'learnt'))
        except (KeyError, TypeError, ValueError) as error:
            self.remark = f'the calibration is damaged ({error!r}): it is made anew'
            return None
        self.remark = 'the calibration from before the restart goes on'
        return alarms

    def acknowledge(self) -> None:
        """Take the alarms as seen."""
        self._model.latched = []

    @property
    def latched(self) -> list[Alarm]:
        """Alarms since the last acknowledgement."""
        return self._model.latched

    @property
    def alarms(self) -> Alarms | None:
        """The alarms; None before the channels are known."""
        return self._model.alarms

    @property
    def spans(self) -> dict[str, float]:
        """The spans that residuals are shares of: Pa, m."""
        return {PRESSURE: self._model.parameters.supply.pressure,
                POSITION: self._model.parameters.actuator.travel}

    def add(self, channel: str, stamp: float, value: float) -> None:
        """Take a sample: stamp in s, value in SI units, pressures gauge."""
        self.aligner.add(channel, stamp, value)
        if math.isfinite(value):
            if math.isnan(self._begun):
                self._begun = stamp
            self._came[channel] = stamp

    def update(self) -> list[Alarm]:
        """Go on over the samples that are complete; return new alarms."""
        if self._model.predictor is None and not self._listened():
            return []
        assert self._model.predictor is not None
        if self.aligner.jumped:
            self.aligner.jumped = False
            self._model.predictor.restart()
            if self._before is not None and self._before.predictor is not None:
                self._before.predictor.restart()
            self.history.clear()
            self._block = None
        rows = self.aligner.rows()
        if not len(rows['time']):
            return []
        self.history.add(rows)
        said = self._model.predictor.advance(rows)
        if self.trial is not None and self._before is not None:
            assert self._before.predictor is not None
            self.trial.note(self._before.predictor.advance(rows), said)
        if not len(said.time):
            return []
        self._show(said)
        found = self._end_blocks(said)
        self._model.latched = [*self.latched, *found]
        return found

    def _end_blocks(self, said: Prediction) -> list[Alarm]:
        """Judge the blocks that these rows complete, whatever the portions in which they come."""
        found = []
        rows = said if self._block is None else self._block.followed_by(said)
        while len(rows.time) and rows.time[-1] - rows.time[0] >= self.settings.block:
            end = int(np.searchsorted(rows.time, rows.time[0] + self.settings.block))
            found += self._judge(rows.part(slice(end)))
            rows = rows.part(slice(end, None))
        self._block = rows
        return found

    @property
    def runs(self) -> bool:
        """Whether a model runs."""
        return self._model.predictor is not None

    def _listened(self) -> bool:
        newest = max(self._came.values(), default=-math.inf)
        if math.isnan(self._begun):
            return False
        if newest < self._begun:  # the clock went back
            self._begun = newest
        if newest - self._begun < LISTENING:
            return False
        awaited = set(self._recalled['channels']) if self._recalled else set()
        if awaited - set(self._came) and newest - self._begun < RECALLING:
            return False
        if self._gap is None:
            self._gap = self.history.gap = self.aligner.longest_gap()
        self._model.predictor = Predictor(
            self._model.parameters, frozenset(self._came), self._compiled, gap=self._gap)
        names = [(channel, kind) for channel in self._model.predictor.channels for kind in KINDS]
        self._model.alarms = self._restored(names) or Alarms(self.settings, names)
        return True

    def _show(self, said: Prediction) -> None:
        for name, values in said.said.items():
            read = said.read[name]
            places = np.flatnonzero(np.isfinite(values) & np.isfinite(read))
            if len(places):
                k = places[-1]
                self.now[name] = Now(
                    float(said.time[k]), float(read[k]), float(values[k]),
                    self._model.misfit.get(name, math.nan), self._noise.get(name, math.nan))

    def _judge(self, rows: Prediction) -> list[Alarm]:
        for name, left in rows.left.items():
            self._follow(self._noise, name, white_noise(rows.read[name]))
            known = left[np.isfinite(left)]
            if len(known):
                self._follow(self._model.misfit, name, float(np.sqrt(np.mean(known**2))))
        self._rows = len(rows.time)
        block = summary(rows.time, rows.said, rows.left, self.spans)
        assert self._model.alarms is not None
        if not self._model.alarms.promised:
            self._model.learnt = {
                name: max(size, self._model.learnt.get(name, 0.0))
                for name, size in self._model.misfit.items()}
        return [] if block is None else self._model.alarms.note(block)

    def _follow(self, levels: dict[str, float], name: str, new: float) -> None:
        if math.isfinite(new):
            levels[name] = new if name not in levels else math.sqrt(
                (1.0 - REMEMBERED) * levels[name]**2 + REMEMBERED * new**2)

    def silent(self) -> list[str]:
        """Return the readings that no longer come though others do."""
        newest = max(self._came.values(), default=0.0)
        return [name for name in CHANNELS if name in self._came and name not in
                ('control_current', 'set_point') and newest - self._came[name] > SILENT]

    @property
    def health(self) -> Health:
        """Health by NAMUR NE 107."""
        lacking = 'waiting for samples of the valve'
        if self._model.predictor is not None and not self._model.predictor.channels:
            lacking = ('what comes of the valve (' + ', '.join(sorted(self._came))
                       + ') does not drive a model and tell what comes of it')
        elif 0 < self._rows < FEWEST_ROWS:
            lacking = (f'{self._rows} rows have come in a block of {self.settings.block:g} s, and '
                       f'{FEWEST_ROWS} are needed: the parameter block has to be larger')
        elif self._model.alarms is not None:
            lacking = self._model.alarms.lacking
        beyond = [
            f'{name} reads {now.read:.4g}, beyond what this valve can have'
            for name, now in self.now.items() if name in COMPARED
            and not -BEYOND + 1.0 <= now.read / self.spans[name] <= BEYOND]
        learnt = self._model.learnt
        beyond += [
            f'the model misses {name} by {size / learnt[name]:.1f} times the most it did '
            'while the valve was learnt' for name, size in self._model.misfit.items()
            if name in learnt and size > TIMES_LEARNT * learnt[name]
            and name not in {one.channel for one in self.latched}]
        worst = {(one.channel, one.kind): one.sentence for one in self.latched}
        return health(self.silent(), list(worst.values()), beyond, lacking)
