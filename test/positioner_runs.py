# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Runs of the positioner that several tests look at: parameters, currents, orifices by hand."""

from __future__ import annotations

import numpy as np

from booster_ros.model.parameters import from_values
from booster_ros.model.simulation import Simulation, simulate
from booster_ros.model.system import PositionerParameters

DT = 0.01
GAIN = 244.45e3 / 0.4524e-3
PAPER_CURRENT = 0.4524e-3


def positioner(values: dict[str, object] | None = None) -> PositionerParameters:
    """Return the declared positioner with some values (dotted names) changed."""
    return from_values(values or {})


def current_for(pressure: float | np.ndarray) -> float | np.ndarray:
    """Return the current, A, at which the declared positioner settles at a gauge pressure, Pa."""
    s1, s2, s3 = 13.52e-6, 9.28e-6, 3.14e-6
    return (pressure * s3 + 400e3 * (s2 - s3)) / s1 / GAIN


def rows(length: float, dt: float = DT) -> np.ndarray:
    """Return stamps from 0 to `length` s."""
    return np.arange(round(length / dt) + 1) * dt


def triangle(time: np.ndarray, low: float, high: float, leg: float) -> np.ndarray:
    """Return a triangle from `low` up to `high` and back, `leg` s for each way."""
    phase = np.mod(time / leg, 2.0)
    return low + (high - low) * np.where(phase < 1.0, phase, 2.0 - phase)


def settled_at(pressure: float) -> dict[str, float]:
    """Return the initial state of a declared positioner that rests at this pressure."""
    return {
        'back_pressure': GAIN * float(current_for(pressure)),
        'chamber_pressure': pressure,
    }


def paper_test(dt: float = DT) -> tuple[np.ndarray, np.ndarray]:
    """Return time and current of the paper's 0.4524 - 0 - 0.4524 mA, 15 s each, from rest."""
    time = rows(45.0, dt)
    return time, np.where((time < 15.0) | (time >= 30.0), PAPER_CURRENT, 0.0)


def follow_pressure(
    values: dict[str, object] | None, time: np.ndarray, pressure: np.ndarray
) -> Simulation:
    """Return the stem's answer where the chamber pressure is given, Pa."""
    return simulate(
        positioner(values), time, np.zeros_like(time), pinned={'chamber_pressure': pressure}
    )


def cut_off(values: dict[str, object] | None, pressure: float, time: np.ndarray) -> Simulation:
    """Return a rest at `pressure` with both seats of the booster shut for good."""
    shut = {'booster.max_area': 0.0, **(values or {})}
    return simulate(
        positioner(shut), time, np.full_like(time, current_for(pressure)), settled_at(pressure)
    )


def legs(time: np.ndarray, leg: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the rows of the second way up and of the second way down of a triangle."""
    up = (time >= 2.0 * leg) & (time < 3.0 * leg)
    down = (time >= 3.0 * leg) & (time < 4.0 * leg)
    return up, down


def loop_width(
    time: np.ndarray, leg: float, over: np.ndarray, of: np.ndarray, at: float | np.ndarray
) -> float | np.ndarray:
    """Return how much higher `of` is on the way up than on the way down, where `over` is `at`."""
    up, down = legs(time, leg)
    return np.interp(at, over[up], of[up]) - np.interp(at, over[down][::-1], of[down][::-1])


def slow_triangle(
    values: dict[str, object] | None, low: float, high: float, leg: float = 60.0
) -> Simulation:
    """Return two cycles of a current that would settle between two chamber pressures, Pa."""
    time = rows(4.0 * leg)
    current = triangle(time, current_for(low), current_for(high), leg)
    return simulate(positioner(values), time, current, settled_at(low))
