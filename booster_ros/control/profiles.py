# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Profiles: a command as a function of the time since its start.

A profile is a function of time and not of a count of ticks, so that late or lost ticks do not
stretch it. Values are A, or m where a profile is the set point of the position loop.
"""

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
import math


class ProfileError(ValueError):
    """A profile cannot be made; the message names the parameter."""


@dataclass(frozen=True)
class Profile:
    """A command over time (s), defined from 0 to `duration`."""

    value: Callable[[float], float]
    duration: float

    def repeated(self) -> 'Profile':
        """Return the profile played again and again."""
        return Profile(lambda time: self.value(time % self.duration), math.inf)


def steps(levels: Sequence[float], dwell: float) -> Profile:
    """
    Hold each level for `dwell` seconds.

    >>> steps([0.0, 1.0], 2.0).value(1.9), steps([0.0, 1.0], 2.0).value(2.0)
    (0.0, 1.0)
    """
    if not levels:
        raise ProfileError('levels must name at least one value')
    times = [number * dwell for number in range(len(levels))]
    return held(times, levels, len(levels) * dwell)


def staircase(low: float, high: float, stairs: int, dwell: float) -> Profile:
    """Climb from low to high in equal stairs and go down again, holding each for `dwell` s."""
    up = [_between(low, high, stair / stairs) for stair in range(stairs + 1)]
    return steps(up + up[-2::-1], dwell)


def _between(low: float, high: float, share: float) -> float:
    """Return the value at a share of the way, low and high themselves at 0 and 1."""
    return low * (1.0 - share) + high * share


def triangle(low: float, high: float, period: float, cycles: int) -> Profile:
    """Ramp from low to high and back within `period` s, `cycles` times."""
    def value(time: float) -> float:
        phase = time / period % 1.0
        return _between(low, high, 1.0 - abs(1.0 - 2.0 * phase))

    return Profile(value, cycles * period)


def sines(low: float, high: float, frequencies: Sequence[float], cycles: int) -> Profile:
    """
    Add sines of equal amplitude around the middle of low and high, never beyond them.

    It lasts `cycles` periods of the lowest frequency (Hz). Schroeder's phases keep the sum of
    several frequencies from peaking all at once.
    """
    if not frequencies or min(frequencies) <= 0.0:
        raise ProfileError('frequencies must name at least one frequency above 0 Hz')
    count = len(frequencies)
    amplitude = (high - low) / 2.0 / count
    phases = [-math.pi * number * (number - 1) / count for number in range(1, count + 1)]

    def value(time: float) -> float:
        return (low + high) / 2.0 + amplitude * sum(
            math.sin(2.0 * math.pi * frequency * time + phase)
            for frequency, phase in zip(frequencies, phases, strict=True)
        )

    return Profile(value, cycles / min(frequencies))


def held(times: Sequence[float], values: Sequence[float], duration: float) -> Profile:
    """Hold each value from its time (s, ascending) to the next one; the last to `duration`."""
    def value(time: float) -> float:
        return values[max(0, bisect_right(times, time) - 1)]

    return Profile(value, duration)
