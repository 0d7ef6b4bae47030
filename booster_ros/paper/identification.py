# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The paper's two identification steps (section III), as an optimisation on records.

1. 0 → 1.16 mA drives the booster fully open: the filling tells the largest area S_max (Max).
2. 0 → 0.4292 mA leaves it partly closed at the end: the tail tells the opening gain k.

The paper turned both by hand until the curves of valve position matched. Neither experiment tells
an area by itself: only ratios to the actuator's volume count, which `scaling_sensitivities` shows.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import least_squares

from ..model.simulation import Simulation, simulate
from ..model.system import PositionerParameters

FULL_CURRENT = 1.16e-3
PARTIAL_CURRENT = 0.4292e-3
"""Currents of the two steps, A (section III)."""

ROW = 0.01
LEAD = 1.0
LENGTH = 25.0
"""Rows of the records, rest before the step and length of a record, s."""

PRESSURE_NOISE = 150.0
POSITION_NOISE = 8e-6
"""Noise of the simulated sensors, Pa and m RMS: good industrial transmitters."""

EXACT = 0.01
"""Tolerance of the solver here: derivatives are taken of what it returns."""

CHANNELS = (('chamber_pressure', PRESSURE_NOISE), ('valve_position', POSITION_NOISE))


class StepRecord(NamedTuple):
    """A step of the current and what was measured of it: s, A, gauge Pa, m."""

    time: np.ndarray
    control_current: np.ndarray
    chamber_pressure: np.ndarray
    valve_position: np.ndarray


class Identified(NamedTuple):
    """A parameter found on a record, and its standard deviation by the noise of that record."""

    value: float
    deviation: float


def step_record(
    p: PositionerParameters, current: float, random: np.random.Generator
) -> StepRecord:
    """Return a simulated record of a step from 0 to `current` (A), with noise."""
    time = np.arange(round(LENGTH / ROW) + 1) * ROW
    command = np.where(time < LEAD, 0.0, current)
    run = simulate(p, time, command)
    pressure, position = (
        run[f'measured_{name}'] + random.normal(0.0, noise, len(time)) for name, noise in CHANNELS)
    return StepRecord(time, command, pressure, position)


def identify(record: StepRecord, p: PositionerParameters, name: str) -> Identified:
    """
    Return the booster's parameter `name` that fits the record best.

    `p` holds the other parameters and the first guess, which must be positive.
    """
    guess = float(getattr(p.booster, name))

    def residual(scale: np.ndarray) -> np.ndarray:
        changed: dict[str, Any] = {name: guess * float(np.exp(scale[0]))}
        booster = p.booster._replace(**changed)
        run = simulate(
            p._replace(booster=booster), record.time, record.control_current, tolerance=EXACT)
        return np.concatenate([
            (run[f'measured_{channel}'] - getattr(record, channel)) / noise
            for channel, noise in CHANNELS
        ])

    found = least_squares(residual, [0.0], diff_step=1e-3, bounds=(-4.0, 4.0))
    value = guess * float(np.exp(found.x[0]))
    information = float(found.jac[:, 0] @ found.jac[:, 0])
    return Identified(value, value / np.sqrt(information))


class Scaling(NamedTuple):
    """Parameters to multiply by factors: what area, volume and openings have in common."""

    effective_area: float = 1.0
    dead_volume: float = 1.0
    opening_gain: float = 1.0
    max_area: float = 1.0


def scaled(p: PositionerParameters, factors: Scaling) -> PositionerParameters:
    """Return the positioner with these scaled; mass and friction go with the area, as forces do."""
    a, b = p.actuator, p.booster
    area = factors.effective_area
    actuator = a._replace(
        effective_area=a.effective_area * area,
        dead_volume=a.dead_volume * factors.dead_volume,
        moving_mass=a.moving_mass * area,
        viscous_friction=a.viscous_friction * area,
        stop_stiffness=a.stop_stiffness * area,
        stop_damping=a.stop_damping * area,
    )
    booster = b._replace(
        opening_gain=b.opening_gain * factors.opening_gain,
        max_area=b.max_area * factors.max_area,
    )
    return p._replace(actuator=actuator, booster=booster)


class Sensitivities(NamedTuple):
    """What both experiments tell about the factors of `Scaling`, noise taken as the measure."""

    deviations: np.ndarray
    """Standard deviation of the logarithm of the best to the worst known combination."""
    directions: np.ndarray
    """The combinations: rows of factors' exponents, of length 1."""


def scaling_sensitivities(p: PositionerParameters) -> Sensitivities:
    """Return which combinations of the four factors the two step experiments determine."""
    step = 1e-4
    columns = []
    for place in range(len(Scaling())):
        up, down = (
            _both_experiments(scaled(p, _one_factor(place, np.exp(sign * step))))
            for sign in (1.0, -1.0))
        columns.append((up - down) / (2.0 * step))
    _, size, directions = np.linalg.svd(np.column_stack(columns), full_matrices=False)
    return Sensitivities(1.0 / size, directions)


def _one_factor(place: int, factor: float) -> Scaling:
    return Scaling(*(factor if k == place else 1.0 for k in range(len(Scaling()))))


def _both_experiments(p: PositionerParameters) -> np.ndarray:
    """Return pressures and positions of both steps, in units of their noise."""
    runs = [_noiseless(p, current) for current in (FULL_CURRENT, PARTIAL_CURRENT)]
    return np.concatenate([run[name] / noise for run in runs for name, noise in CHANNELS])


def _noiseless(p: PositionerParameters, current: float) -> Simulation:
    time = np.arange(round(LENGTH / ROW) + 1) * ROW
    return simulate(p, time, np.where(time < LEAD, 0.0, current), tolerance=EXACT)


def largest_change(p: PositionerParameters, factor: float) -> tuple[float, float]:
    """Return by how much one factor on all four moves pressure (Pa) and position (m) at most."""
    together = scaled(p, Scaling(factor, factor, factor, factor))
    changes = [
        (np.abs(one[name] - other[name]).max() for name, _ in CHANNELS)
        for current in (FULL_CURRENT, PARTIAL_CURRENT)
        for one, other in [(_noiseless(p, current), _noiseless(together, current))]
    ]
    pressure, position = np.max([list(change) for change in changes], axis=0)
    return float(pressure), float(position)
