# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Sensors: what is measured of the chamber pressure and of the valve position."""

import math
from typing import Annotated, NamedTuple

from .quantity import Quantity


class Sensors(NamedTuple):
    """Biases, lags and a play of the sensors: ideal unless told otherwise."""

    pressure_bias: Annotated[float, Quantity(
        'Pa', 'pressure_sensor_bias: added to the chamber pressure', -1e6, 1e6)] = 0.0
    pressure_span_error: Annotated[float, Quantity(
        '-', 'pressure_sensor_bias: relative error of the pressure span', -0.9, 10.0)] = 0.0
    pressure_lag: Annotated[float, Quantity(
        's', 'pressure_sensor_lag: time constant', 0.0, 60.0)] = 0.0
    position_bias: Annotated[float, Quantity(
        'm', 'position_sensor_bias: added to the position', -1.0, 1.0)] = 0.0
    position_span_error: Annotated[float, Quantity(
        '-', 'position_sensor_bias: relative error of the position span', -0.9, 10.0)] = 0.0
    position_lag: Annotated[float, Quantity(
        's', 'position_sensor_lag: time constant', 0.0, 60.0)] = 0.0
    position_backlash: Annotated[float, Quantity(
        'm', 'position_backlash: lost motion of the feedback linkage', 0.0, 1.0)] = 0.0


def lagged(value: float, before: float, after: float, time_constant: float, step: float) -> float:
    """
    Return a first-order lag's output after `step` (s).

    Before the step its output was `value`. During it, its input ran on a straight line from
    `before` to `after`, for which the result is exact.
    """
    if time_constant <= 0.0:
        return after
    slope_lag = (after - before) / step * time_constant
    return after - slope_lag + (value - before + slope_lag) * math.exp(-step / time_constant)


def pressure_reading(sensors: Sensors, pressure: float) -> float:
    """Return the reading, Pa gauge, of a pressure that has passed the lag."""
    return pressure * (1.0 + sensors.pressure_span_error) + sensors.pressure_bias


def pressure_behind(sensors: Sensors, reading: float) -> float:
    """Return the pressure, Pa gauge, behind a reading: the inverse of `pressure_reading`."""
    return (reading - sensors.pressure_bias) / (1.0 + sensors.pressure_span_error)


def position_behind(sensors: Sensors, reading: float) -> float:
    """Return the position, m, behind a reading: the inverse of `position_reading`."""
    return (reading - sensors.position_bias) / (1.0 + sensors.position_span_error)


def position_reading(sensors: Sensors, position: float) -> float:
    """Return the reading, m, of a position that has passed backlash and lag."""
    return position * (1.0 + sensors.position_span_error) + sensors.position_bias
