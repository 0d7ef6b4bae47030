# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Make rows of a record from what is sent to a positioner and what comes back from it.

A row is one sample of the positioner: its outputs and their time. Its current is the last one that
was sent before the *next* sample, because that is what drove the valve from this sample to the
next. A row is therefore complete one sample later, and the outputs are as they came: neither late
by a tick of the controller, nor smoothed by interpolation.
"""

from collections import deque
from dataclasses import dataclass, field
from math import inf, nan
from typing import NamedTuple

OUTPUTS = ('chamber_pressure', 'valve_position')

_PERIOD_WEIGHT = 0.1
_NEAR = 0.75
"""Share of a period within which outputs are of one sample: they are late more often than lost."""

_LONGEST_WAIT = 4
"""Samples after which a message is taken for lost."""


class Row(NamedTuple):
    """One row of a record: s, A, Pa gauge, m."""

    time: float
    control_current: float
    chamber_pressure: float
    valve_position: float


@dataclass
class _Sample:
    time: float
    outputs: dict[str, float] = field(default_factory=dict)

    @property
    def is_complete(self) -> bool:
        return len(self.outputs) == len(OUTPUTS)


class RowBuilder:
    """Collects commands and outputs with their times; each series comes in order of time."""

    def __init__(self) -> None:
        self._commands: deque[tuple[float, float]] = deque()
        self._current = nan
        self._samples: deque[_Sample] = deque()
        self._last_time: dict[str, float] = {}
        self._period = inf
        self._finished = -inf

    def sent(self, current: float, time: float) -> None:
        """Note a command, A."""
        self._commands.append((time, current))

    def received(self, column: str, value: float, time: float) -> list[Row]:
        """Note an output, and return the rows that are complete now."""
        self._learn_period(column, time)
        if time > self._finished:
            self._sample_of(column, time).outputs[column] = value
        rows = []
        while len(self._samples) > 1 and (
            self._samples[0].is_complete or len(self._samples) > _LONGEST_WAIT
        ):
            rows.append(self._take_row())
        return rows

    def rest(self) -> list[Row]:
        """Return the rows that are still open, as they are now."""
        return [self._take_row() for _ in range(len(self._samples))]

    def _sample_of(self, column: str, time: float) -> _Sample:
        """Return the open sample that an output belongs to: the nearest that lacks it, if near."""
        lacking = [sample for sample in self._samples if column not in sample.outputs]
        if lacking:
            nearest = min(lacking, key=lambda sample: abs(time - sample.time))
            if abs(time - nearest.time) < _NEAR * self._period:
                return nearest
        self._samples.append(_Sample(time))
        return self._samples[-1]

    def _take_row(self) -> Row:
        sample = self._samples.popleft()
        self._finished = sample.time
        end = self._samples[0].time if self._samples else inf
        while self._commands and self._commands[0][0] < end:
            self._current = self._commands.popleft()[1]
        pressure, position = (sample.outputs.get(name, nan) for name in OUTPUTS)
        return Row(sample.time, self._current, pressure, position)

    def _learn_period(self, column: str, time: float) -> None:
        elapsed = time - self._last_time.get(column, nan)
        self._last_time[column] = time
        if self._period == inf and elapsed > 0.0:
            self._period = elapsed
        elif elapsed > 0.0:
            self._period += _PERIOD_WEIGHT * (elapsed - self._period)
