# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What comes out of a sensor that has noise, steps and faults."""

from collections.abc import Iterable
from random import Random
from typing import NamedTuple

from .injection import Injection
from .kinds import CHANCES, DEAD, DROPOUT, NOISE, RESOLUTION, SIZES, SPIKE, STUCK

Acting = Iterable[tuple[Injection, float]]


class Imperfection(NamedTuple):
    """Standard deviation of a sensor's white noise and its smallest step, Pa or m; 0 for none."""

    noise: float = 0.0
    resolution: float = 0.0


class Sensor:
    """
    Makes readings of one quantity out of ideal ones, sample by sample.

    All chance comes from the seed: the same samples and faults give the same readings. Each kind
    of fault has a chance of its own, so that one does not change what another one does.
    """

    def __init__(self, quantity: str, seed: int) -> None:
        """Begin anew; `quantity` is `pressure` or `position`."""
        self.quantity = quantity
        self._chance = {
            kind: Random(f'{seed} {quantity} {kind}') for kind in ('own', NOISE, DROPOUT, SPIKE)}
        self._last: float | None = None
        self._stuck: float | None = None

    def read(self, ideal: float, imperfection: Imperfection, acting: Acting) -> float:
        """Return the reading for an ideal one, with the faults (and shares) of this sensor."""
        value = ideal
        step = imperfection.resolution
        if imperfection.noise > 0.0:
            value += imperfection.noise * self._chance['own'].gauss(0.0, 1.0)
        holds = stuck = dead = False
        for injection, share in acting:
            kind = injection.fault.kind
            size = self._size(injection, share)
            if kind == NOISE:
                value += size * self._chance[NOISE].gauss(0.0, 1.0)
            elif kind == SPIKE:
                chance = self._chance[SPIKE]
                hit, sign = chance.random() < CHANCES[SPIKE], chance.choice((-1.0, 1.0))
                value += size * sign if hit else 0.0
            elif kind == DROPOUT:
                lost = CHANCES[DROPOUT] * injection.strength * share
                holds |= self._chance[DROPOUT].random() < lost
            elif kind == RESOLUTION:
                step = max(step, size)
            stuck |= kind == STUCK
            dead |= kind == DEAD
        if step > 0.0:
            value = step * round(value / step)
        if holds and self._last is not None:
            value = self._last
        value = self._held(value) if stuck else self._free(value)
        value = 0.0 if dead else value
        self._last = value
        return value

    def _size(self, injection: Injection, share: float) -> float:
        if injection.size is not None:
            return injection.size * share
        unit = SIZES.get((self.quantity, injection.fault.kind), 0.0)
        return unit * injection.strength * share

    def _held(self, value: float) -> float:
        """Return what a stuck sensor shows: what it showed last before it stuck."""
        if self._stuck is None:
            self._stuck = value if self._last is None else self._last
        return self._stuck

    def _free(self, value: float) -> float:
        self._stuck = None
        return value
