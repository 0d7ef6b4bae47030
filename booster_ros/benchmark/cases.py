# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The runs on which accuracy and speed are measured."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ..model.parameters import from_values
from ..model.system import PositionerParameters

PAPER_CURRENT = 0.4524e-3
"""Current of the paper's step test, A (section IV.B)."""

ROW = 0.01
"""Distance of the rows of a case, s: the rate at which records are usually made."""


STRIBECK_VELOCITY = 1e-3
"""Velocity at which the stiction of a case has faded to 37 %, m/s."""


CURRENT_NOISE = 1e-7
"""Standard deviation of the noise on a current, A: 0.2 % of what the ramps go through."""


class Case(NamedTuple):
    """A run: parameters, rows of time (s) and current (A), and states at the first row."""

    name: str
    parameters: PositionerParameters
    time: np.ndarray
    control_current: np.ndarray
    initial: Mapping[str, float]


def paper_test(leg: float = 15.0) -> Case:
    """Return the paper's 0 - 0.4524 - 0 - 0.4524 mA from rest, `leg` s for each level."""
    time = np.arange(round((1.0 + 3.0 * leg) / ROW) + 1) * ROW
    since = time - 1.0
    on = (since >= -1e-9) & ((since < leg - 1e-9) | (since >= 2.0 * leg - 1e-9))
    return Case(
        'paper test', from_values({}), time, np.where(on, PAPER_CURRENT, 0.0), {}
    )


def stick_slip(length: float = 40.0) -> Case:
    """Return a current that rises and falls so slowly that a stem with stiction moves in jumps."""
    parameters = from_values({
        'actuator.coulomb_friction': 400.0,
        'actuator.stiction': 300.0,
        'actuator.stribeck_velocity': STRIBECK_VELOCITY,
    })
    time = np.arange(round(length / ROW) + 1) * ROW
    low, high = 0.405e-3, 0.455e-3
    rising = np.where(time < 0.5 * length, time, length - time) / (0.5 * length)
    current = low + (high - low) * rising
    return Case(
        'stick-slip', parameters, time, current, {'chamber_pressure': 160e3}
    )


def yielding_packing(stiction: float) -> PositionerParameters:
    """Return a stem whose packing gives before it slides, with so much stiction, N."""
    return from_values({
        'actuator.coulomb_friction': 400.0,
        'actuator.stiction': stiction,
        'actuator.stribeck_velocity': STRIBECK_VELOCITY,
        'actuator.presliding_stiffness': 2e7,
    })


def yielding_ramps(stiction: float, length: float = 40.0) -> Case:
    """Return the current of `stick_slip` on a packing that yields, with so much stiction, N."""
    return stick_slip(length)._replace(name='ramps', parameters=yielding_packing(stiction))


def noisy_ramps(stiction: float, length: float = 40.0) -> Case:
    """Return `yielding_ramps` with noise on the current, the same in all runs."""
    case = yielding_ramps(stiction, length)
    noise = np.random.default_rng(1).normal(0.0, CURRENT_NOISE, len(case.time))
    return case._replace(name='noisy ramps', control_current=case.control_current + noise)


def yielding_step(stiction: float, length: float = 40.0) -> Case:
    """Return one step that a stem creeps after, in a packing that yields; stiction in N."""
    time = np.arange(round(length / ROW) + 1) * ROW
    return Case(
        'step', yielding_packing(stiction), time,
        np.where(time < 1.0 - 1e-9, 0.40e-3, 0.44e-3), {'chamber_pressure': 160e3})


def moving_command(length: float = 10.0) -> Case:
    """Return a current that changes with every row, as a controller's does: two slow sines."""
    time = np.arange(round(length / ROW) + 1) * ROW
    current = 0.43e-3 + 0.02e-3 * np.sin(1.3 * time) + 0.005e-3 * np.sin(7.1 * time)
    return Case(
        'moving command', from_values({}), time, current, {'chamber_pressure': 225e3}
    )
