# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Observation models: what of a record a fit is made to meet.

`ROWS` is every reading. `WINDOWS` are statistics of windows of a second: the mean of each, and the
logarithm of the variance of what moves within it. When a stem slips hangs on the last digits of its
friction: single readings say little of it, and roughly; the statistics say how much friction there
is and how far slips go (a synthetic likelihood: S. N. Wood, Nature 466 (2010) 1102).

Both take what the model leaves of the readings, in standard deviations of the noise, channel by
channel, and return what a fit minimises the squares of.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from booster_ros.diagnosis.data.experiment import NO_CHANCE, Array, Chance
from booster_ros.signals.innovations import Whitening

WINDOW = 1.0
"""Length of a window, s: many slips of a stem come in it, and few moves of the valve."""

SCATTER = 0.25
"""What one slip more or less in a window changes in its strength, in natural logarithms."""

LEAST = 0.1
"""Smallest variance that readings are taken to have, in squares of the noise."""

_CUBIC = 4


@dataclass(frozen=True, eq=False)
class Windows:
    """
    Rows of a channel in windows: time in s and readings in standard deviations of the noise.

    Both have the shape (rows,); `window` says to which window each row belongs, `first` and
    `count` which is the first row of each and how many it has.
    """

    time: Array
    readings: Array
    window: Array
    first: Array
    count: Array
    chance: Chance = NO_CHANCE

    @classmethod
    def of(cls, time: Array, readings: Array, chance: Chance = NO_CHANCE) -> 'Windows':
        """Return the windows of these rows."""
        _, first, window, count = np.unique(
            np.floor(time / WINDOW), return_index=True, return_inverse=True, return_counts=True)
        return cls(time, readings, window, first, count, chance)

    def white(self, residuals: Array) -> Array:
        """Return the residuals of rows as white noise of variance 1, where they are noise."""
        return self._whitening.innovations(residuals) if self.chance.share else residuals

    @cached_property
    def _whitening(self) -> Whitening:
        return Whitening.of(self.time, self.chance.share, self.chance.seconds)

    def means(self, residuals: Array) -> Array:
        """Return the mean of each window in standard deviations of its noise, shape (windows,)."""
        variance = 1.0 + self.chance.share * (self.count - 1.0)  # chance hardly changes within one
        return np.bincount(self.window, residuals) / np.sqrt(self.count * variance)

    def strengths(self, residuals: Array) -> Array:
        """
        Return by how much the model moves more or less than the valve within each window, scaled.

        It is the logarithm of a ratio of variances: that of the model, with the noise that
        readings have, to that of the readings.
        """
        moves = self._variance(self.readings - residuals) + 1.0
        spread = np.sqrt(2.0 / self._freedom + SCATTER**2)
        return np.log(moves / self._moved) / spread

    def _variance(self, values: Array) -> Array:
        """Return the variance of what a cubic leaves in each window that is long enough."""
        left = np.bincount(self.window, values**2)
        for curve in self._curves.T:
            left -= np.bincount(self.window, curve * values)**2
        return np.maximum(left[self.told], 0.0) / self._freedom

    @cached_property
    def _moved(self) -> Array:
        """Return the variance of the readings in each window that is long enough."""
        return np.maximum(self._variance(self.readings), LEAST)

    @cached_property
    def told(self) -> Array:
        """Which windows are long enough for their strength to be told, shape (windows,)."""
        return self.count >= 2 * _CUBIC

    @cached_property
    def _freedom(self) -> Array:
        return self.count[self.told] - float(_CUBIC)

    @cached_property
    def _curves(self) -> Array:
        """Return orthonormal cubics of each window that is long enough, shape (rows, 4)."""
        curves = np.zeros((len(self.time), _CUBIC))
        for first, count in zip(self.first[self.told], self.count[self.told]):
            part = slice(first, first + count)
            within = (self.time[part] - self.time[first]) / WINDOW - 0.5
            curves[part] = np.linalg.qr(np.vander(within, _CUBIC))[0]
        return curves


class Steps(NamedTuple):
    """Length of differences in z: they change residuals by `change` (norm), or are `most`."""

    change: float
    most: float


@dataclass(frozen=True, eq=False)
class Observation:
    """
    What of the readings of a channel counts.

    `of` makes its residuals of the scaled residuals of its rows, in series, of which `first_rows`
    are the counted rows each begins with. `steps` are those of a fit's differences, `last` those
    along the axes at its end; a fit to the very end goes on by `finer` ones. A `summary` of the
    readings says as much on thinned rows as on all, and bends too much for slopes to lead far.
    """

    name: str
    of: Callable[[Windows, Array], Array] = field(repr=False)
    first_rows: Callable[[Windows], list[Array]] = field(repr=False)
    steps: Steps
    last: Steps
    finer: tuple[Steps, ...] = ()
    summary: bool = False


ROWS = Observation('rows', lambda windows, scaled: windows.white(scaled),
                   lambda windows: [np.arange(len(windows.time))], Steps(1.0, 0.1), Steps(1.0, 0.1))
"""Every reading counts, by itself where none of its noise is chance."""

WINDOWS = Observation(
    'windows', lambda windows, scaled: np.append(windows.means(scaled), windows.strengths(scaled)),
    lambda windows: [windows.first, windows.first[windows.told]], Steps(100.0, 0.1),
    Steps(300.0, 0.3), finer=(Steps(30.0, 0.1), Steps(10.0, 0.1)), summary=True)
"""Means and logarithms of variances of windows count; slips make them rough on short ways: one slip
in another window is hundreds, and the next minimum over stiction some 0.1 away. Slopes that tell
how sure a fit is are over several of both, else they are those of the minimum that it ended in."""
