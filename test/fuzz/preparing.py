# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Odd records: an experiment is made of each, or it is refused in one sentence."""

from __future__ import annotations

from contextlib import suppress
import functools
import random

import numpy as np

from booster_ros.diagnosis.prepare.preparation import prepare
from booster_ros.model.simulation import simulate
from booster_ros.model.system import PositionerParameters
from booster_ros.records import RecordError
from booster_ros.records.cleaning import clean

ROWS = 300
DECLARED = PositionerParameters()


@functools.cache
def _columns() -> dict[str, np.ndarray]:
    time = 0.1 * np.arange(ROWS)
    current = np.where(time < 10.0, 0.43e-3, 0.45e-3)
    run = simulate(DECLARED, time, current, {'chamber_pressure': 215e3})
    noise = np.random.default_rng(1).standard_normal(ROWS)
    return {'time': time, 'control_current': current,
            'back_pressure': run['back_pressure'] + 100.0 * noise,
            'chamber_pressure': run['chamber_pressure'] + 150.0 * noise,
            'valve_position': run['valve_position'] + 8e-6 * noise}


def run(rng: random.Random) -> None:
    """Prepare a record of which columns are missing, cut, scaled, stuck, holed or with gaps."""
    columns = {name: values.copy() for name, values in _columns().items() if rng.random() < 0.8}
    rows = rng.choice((1, 2, 11, 12, 50, ROWS))
    columns = {name: values[:rows] for name, values in columns.items()}
    for name in columns:
        if rng.random() < 0.4:
            columns[name] = rng.choice(CHANGES)(columns[name], rng)
    if not columns:
        return
    with suppress(RecordError):
        prepare(clean(columns, np.arange(2, rows + 2), 'record.csv'), DECLARED,
                rng.choice((None, None, 1e-3, 1e4)))


def _scaled(values: np.ndarray, rng: random.Random) -> np.ndarray:
    return values * 10.0 ** rng.choice((-11, -9, -6, -3, -1, 1, 3, 6))


def _stuck(values: np.ndarray, rng: random.Random) -> np.ndarray:
    return np.full_like(values, values[rng.randrange(len(values))])


def _holed(values: np.ndarray, rng: random.Random) -> np.ndarray:
    lost = np.random.default_rng(rng.randrange(2**32)).random(len(values)) < rng.random()
    return np.where(lost, np.nan, values)


def _jumped(values: np.ndarray, rng: random.Random) -> np.ndarray:
    far = rng.choice((1e-9, 1.0, 60.0, 86_400.0, -5.0)) * rng.choice((1.0, np.ptp(values) or 1.0))
    return np.where(np.arange(len(values)) < rng.randrange(len(values) + 1), values, values + far)


def _reversed(values: np.ndarray, rng: random.Random) -> np.ndarray:
    return values[::-1].copy()


CHANGES = (_scaled, _stuck, _holed, _jumped, _reversed)
