# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameter sets drawn within their documented ranges, and the plant stepped with each."""

from __future__ import annotations

import math
import random

from booster_ros.model.parameters import DESCRIPTIONS, ParameterError, from_values
from booster_ros.model.simulation import Plant

MOST_PARAMETERS = 12
STEPS = 30
CURRENTS = (0.0, 2e-4, 4.5e-4, 2e-3, -1.0, 1.0)
FINITE = ('chamber_pressure', 'valve_position', 'stem_velocity', 'back_pressure')


def run(rng: random.Random) -> None:
    """Step a plant of parameters drawn at random; what it shows is finite or lost for good."""
    values = drawn(rng)
    try:
        parameters = from_values(values)
    except ParameterError:
        return
    plant = Plant(parameters, rng.choice((1e-4, 1e-3, 1e-2)))
    lost = False
    for _ in range(STEPS // 10):
        plant.advance(rng.choice(CURRENTS), rng.choice((1, 3, 10)))
        plant.outputs()
        readings = plant.readings()
        now = not all(map(math.isfinite, readings))
        assert now or not lost, f'a state came back that was lost: {values}'
        lost = now


def drawn(rng: random.Random) -> dict[str, object]:
    """Return some parameters, each within its range, at its ends as often as not."""
    names = rng.sample(sorted(DESCRIPTIONS), rng.randint(1, MOST_PARAMETERS))
    return {name: _value(rng, name) for name in names}


def _value(rng: random.Random, name: str) -> object:
    description = DESCRIPTIONS[name]
    if description.choices:
        return rng.choice(description.choices)
    if isinstance(description.default, tuple):
        numbers = [_number(rng, description.low, description.high) for _ in description.default]
        return sorted(numbers) if rng.random() < 0.9 else numbers
    return _number(rng, description.low, description.high)


def _number(rng: random.Random, low: float, high: float) -> float:
    """Return a number of a range: an end, evenly drawn, or evenly over its orders of magnitude."""
    way = rng.random()
    if way < 0.25:
        return rng.choice((low, high))
    if way < 0.5:
        return rng.uniform(low, high)
    size = max(abs(low), abs(high))
    number = size * 10.0 ** -rng.uniform(0.0, 14.0)
    return min(max(-number if low < 0.0 and rng.random() < 0.5 else number, low), high)
