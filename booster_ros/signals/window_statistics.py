# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Means and strengths of what moves in windows of a second, for residuals of a model.

They say how much friction there is and how far slips go, where single readings say little.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from booster_ros.signals.innovations import Whitening

Array = np.ndarray

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
    `count` which is the first row of each and how many it has. A `share` of the noise carries over
    from row to row, by 1/e after so many `seconds`.
    """

    time: Array
    readings: Array
    window: Array
    first: Array
    count: Array
    share: float = 0.0
    seconds: float = 1.0

    @classmethod
    def of(cls, time: Array, readings: Array, share: float = 0.0, seconds: float = 1.0
           ) -> 'Windows':
        """Return the windows of these rows."""
        _, first, window, count = np.unique(
            np.floor(time / WINDOW), return_index=True, return_inverse=True, return_counts=True)
        return cls(time, readings, window, first, count, share, seconds)

    def white(self, residuals: Array) -> Array:
        """Return the residuals of rows as white noise of variance 1, where they are noise."""
        return self._whitening.innovations(residuals) if self.share else residuals

    @cached_property
    def _whitening(self) -> Whitening:
        return Whitening.of(self.time, self.share, self.seconds)

    def means(self, residuals: Array) -> Array:
        """Return the mean of each window in standard deviations of its noise, shape (windows,)."""
        variance = 1.0 + self.share * (self.count - 1.0)  # it hardly changes within one
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
