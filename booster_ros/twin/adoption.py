# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
A found model on trial: it runs beside the one before over the next minutes, and has to be better.

What decides is set before the trial begins. Over the rows in which both models say something, the
mean squares of what each leaves, in squares of the noise, are compared. The new model is kept if

    mean over all channels <= LESS * that of the old one   and
    in no channel more than MORE * that of the old one, and the noise's own mean square.

What a model gets worse by less than the noise nobody reads from one sample; a refit moves the
declared parameters of a channel whose part has not changed by about as much.

The trial is over when there have been `length` s of such rows. They are data that neither model has
been fitted to (validation on fresh data; L. Ljung, System Identification, 1999, section 16.5).
"""

from collections.abc import Mapping
import math
from typing import NamedTuple

import numpy as np

from .aligning import LONGEST_GAP
from .predictor import Prediction

Array = np.ndarray

LESS = 0.9
"""Largest mean square of the new model over all channels, relative to the old one's."""

MORE = 1.1
"""Largest mean square of the new model in any one channel, relative to the old one's, beside the
noise's."""


class Outcome(NamedTuple):
    """What a trial has shown: whether the new model is kept, and why, in a sentence."""

    is_kept: bool
    sentence: str


class Trial:
    """Compares two models over `length` s of rows; without a known noise channels count alike."""

    def __init__(self, length: float, gap: float = LONGEST_GAP) -> None:
        self.length, self._gap = length, gap
        self.seconds = 0.0
        """Time in which both models have said something."""
        self._squares: dict[str, list[float]] = {}
        self._last = math.nan

    @property
    def is_over(self) -> bool:
        """Whether enough has been compared."""
        return self.seconds >= self.length

    def note(self, old: Prediction, new: Prediction) -> None:
        """Take what both models leave of the same rows; one may have begun some rows earlier."""
        count = min(len(old.time), len(new.time))
        if not count:
            return
        said = np.zeros(count, dtype=bool)
        for name in new.left:
            after = new.left[name][-count:]
            before = old.left[name][-count:] if name in old.left else np.full(count, math.nan)
            both = np.isfinite(after) & np.isfinite(before)
            said |= both
            total = self._squares.setdefault(name, [0.0, 0.0, 0.0])
            total[0] += float(np.count_nonzero(both))
            total[1] += float(np.sum(before[both]**2))
            total[2] += float(np.sum(after[both]**2))
        for moment in new.time[-count:][said].tolist():
            step = moment - self._last
            self.seconds += step if 0.0 < step <= self._gap else 0.0
            self._last = moment

    def outcome(self, noise: Mapping[str, float]) -> Outcome:
        """Return what the trial has shown; `noise` are standard deviations by channel, SI."""
        compared = {name: (old / count, new / count)
                    for name, (count, old, new) in self._squares.items() if count}
        if not self.is_over or not compared:
            return Outcome(False, f'only {self.seconds:.0f} of {self.length:g} s could be compared')
        weights = {name: 1.0 / noise[name]**2 if noise.get(name, 0.0) > 0.0 else 1.0 / max(
            old, 1e-300) for name, (old, _) in compared.items()}
        before, after = (sum(weights[name] * one[k] for name, one in compared.items())
                         for k in (0, 1))
        worse = [name for name, (old, new) in compared.items()
                 if new > MORE * old + noise.get(name, 0.0)**2]
        told = ', '.join(f'{name} {_shown(name, old)} to {_shown(name, new)}'
                         for name, (old, new) in compared.items())
        if after > LESS * before:
            return Outcome(False, f'it predicted the next {self.length:g} s no better '
                           f'(root mean square of what was missed: {told})')
        if worse:
            return Outcome(False, f'it predicted {" and ".join(worse)} worse over the next '
                           f'{self.length:g} s (root mean square of what was missed: {told})')
        return Outcome(True, f'it predicted the next {self.length:g} s better (root mean square of '
                       f'what was missed: {told})')


def _shown(channel: str, square: float) -> str:
    """Return a root mean square in the unit in which people read the channel."""
    scale, unit = (1e3, 'kPa') if channel.endswith('pressure') else (1e-6, 'µm')
    return f'{math.sqrt(square) / scale:.3g} {unit}'
