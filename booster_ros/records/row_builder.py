# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Make rows of a record from what is sent to a positioner and what comes back from it.

A row is one sample of the positioner: its outputs and their time. Its current is the one in force
when the *next* sample comes, because that is what drove the valve from this sample to the next. A
row is therefore complete one sample later, and the outputs are as they came: neither late by a tick
of the controller, nor smoothed by interpolation.
"""

from math import inf, nan
from typing import NamedTuple

OUTPUTS = ('chamber_pressure', 'valve_position')

_PERIOD_WEIGHT = 0.1


class Row(NamedTuple):
    """One row of a record: s, A, Pa gauge, m."""

    time: float
    control_current: float
    chamber_pressure: float
    valve_position: float


class RowBuilder:
    """Collects commands and outputs in the order in which they were sent and received."""

    def __init__(self) -> None:
        self._current = nan
        self._time = nan
        self._outputs: dict[str, float] = {}
        self._last_time: dict[str, float] = {}
        self._period = inf

    def sent(self, current: float) -> None:
        """Note a command, A."""
        self._current = current

    def received(self, column: str, value: float, time: float) -> Row | None:
        """
        Note an output, and return the row that is complete with it, if one is.

        The outputs of one sample come close together. A new sample begins when the same one comes
        again, or, should one be lost, after more than half a period.
        """
        complete = None
        self._learn_period(column, time)
        if column in self._outputs or time - self._time > self._period / 2.0:
            complete = self.last()
        if not self._outputs:
            self._time = time
        self._outputs[column] = value
        return complete

    def _learn_period(self, column: str, time: float) -> None:
        elapsed = time - self._last_time.get(column, nan)
        self._last_time[column] = time
        if self._period == inf and elapsed > 0.0:
            self._period = elapsed
        elif elapsed > 0.0:
            self._period += _PERIOD_WEIGHT * (elapsed - self._period)

    def last(self) -> Row | None:
        """Return the row that has been begun, if there is one, as it is now."""
        if not self._outputs:
            return None
        row = Row(self._time, self._current, *(self._outputs.get(name, nan) for name in OUTPUTS))
        self._outputs = {}
        return row
