# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the recorder sees of the plant: sensors, noise, resolution."""

from typing import NamedTuple

import numpy as np
from numba import njit

from .converter import play
from .plant import COLUMNS, SAMPLE_TIME
from .stem import Stem

PRESSURE_NOISE = 150.0  # Pa RMS
PRESSURE_RESOLUTION = 25.0  # Pa
POSITION_NOISE = 8e-6  # m RMS
POSITION_RESOLUTION = 2e-6  # m


class Sensors(NamedTuple):
    """Faults of the two sensors in SI units, all neutral at their defaults."""

    position_backlash: float = 0.0  # m, full width of lost motion in the linkage
    position_lag: float = 0.0  # s
    position_bias: float = 0.0  # m
    position_arm: float = 0.0  # m, what the turn of the linkage's arm adds on its way, an S
    pressure_lag: float = 0.0  # s
    pressure_bias: float = 0.0  # Pa
    pressure_lateness: float = 0.0  # s, by which the pressure channel's clock is late


@njit(cache=True)
def _linkage(position, width):
    followed = np.empty_like(position)
    followed[0] = position[0]
    for i in range(1, position.size):
        followed[i] = play(followed[i - 1], position[i], width)
    return followed


@njit(cache=True)
def _lagged(signal, time_constant):
    """Apply a first-order lag, exact for a signal that is straight between samples."""
    if time_constant <= 0.0:
        return signal
    decay = np.exp(-SAMPLE_TIME / time_constant)
    slope_part = time_constant / SAMPLE_TIME * (1.0 - decay)
    lagged = np.empty_like(signal)
    lagged[0] = signal[0]
    for i in range(1, signal.size):
        step = signal[i] - signal[i - 1]
        lagged[i] = (
            decay * lagged[i - 1] + (1.0 - decay) * signal[i - 1] + (1.0 - slope_part) * step
        )
    return lagged


def sensed(sensors: Sensors, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return chamber pressure (Pa gauge) and position (m) as noiseless sensors report them."""
    pressure = np.ascontiguousarray(rows[:, COLUMNS.index('chamber_pressure')])
    position = np.ascontiguousarray(rows[:, COLUMNS.index('valve_position')])
    pressure = _lagged(pressure, sensors.pressure_lag)
    time = np.arange(pressure.size) * SAMPLE_TIME
    pressure = np.interp(time - sensors.pressure_lateness, time, pressure)
    position = position + sensors.position_arm * np.sin(2.0 * np.pi * position / Stem().travel)
    position = _lagged(_linkage(position, sensors.position_backlash), sensors.position_lag)
    return pressure + sensors.pressure_bias, position + sensors.position_bias


def recorded(
    pressure: np.ndarray, position: np.ndarray, generator: np.random.Generator, noise: float = 1.0,
    resolution: float = 1.0,
) -> tuple[np.ndarray, np.ndarray]:
    """
    Return what the recorder writes: values with `noise` times the usual, at its resolution.

    That is `resolution` times the usual; with 0 all digits are there.
    """
    noisy_pressure = pressure + noise * PRESSURE_NOISE * generator.standard_normal(pressure.size)
    noisy_position = position + noise * POSITION_NOISE * generator.standard_normal(position.size)
    return (
        _rounded(noisy_pressure, resolution * PRESSURE_RESOLUTION),
        _rounded(noisy_position, resolution * POSITION_RESOLUTION),
    )


def _rounded(values: np.ndarray, step: float) -> np.ndarray:
    return np.round(values / step) * step if step > 0.0 else values
