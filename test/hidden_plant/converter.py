# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""E/P converter: control current to back pressure."""

import math
from typing import NamedTuple

from numba import njit


class Converter(NamedTuple):
    """Constants in SI units; everything below the blank line is neutral at its default."""

    gain: float = 244.45e3 / 0.4524e-3  # Pa/A
    offset: float = 0.0  # Pa
    time_constant: float = 0.034  # s

    hysteresis: float = 0.0  # A, full width of the magnetic play
    dead_time: float = 0.0  # s
    drift: float = 0.0  # Pa/s, of the zero, from the start of the record
    warm_up: float = 0.0  # Pa, final zero shift as the coil heats
    warm_up_time: float = 30.0  # s
    compression: float = 0.0  # 1/Pa, inverse of the pressure at which the S-curve levels off
    bow: float = 0.0  # Pa at 50 µA from mid-range, parabolic
    ambient_swing: float = 0.0  # relative swing of the gain with the room's temperature
    ambient_period: float = 60.0  # s
    creep: float = 0.0  # share of the response that comes late
    creep_time: float = 15.0  # s
    slow_venting: float = 0.0  # relative excess of the time constant where the pressure falls


MID_CURRENT = 0.415e-3  # A, middle of the range that moves the valve


@njit(cache=True)
def play(previous, value, width):
    """Follow a value with lost motion of the given full width."""
    half = 0.5 * width
    return min(max(previous, value - half), value + half)


@njit(cache=True)
def shaped(converter, current):
    """Return gain × current in Pa, bent by what the converter has of S-curve and bow."""
    centre = converter.gain * MID_CURRENT
    distance = converter.gain * current - centre
    if converter.compression != 0.0:
        distance = math.tanh(converter.compression * distance) / converter.compression
    arm = (current - MID_CURRENT) / 50e-6
    return centre + distance + converter.bow * arm * arm


@njit(cache=True)
def settled_back_pressure(converter, current, late_current, time, supply_pressure):
    """Return the back pressure (Pa gauge) a current ends at; late_current is the crept current."""
    since_start = max(time, 0.0)
    effective = (1.0 - converter.creep) * current + converter.creep * late_current
    gain_change = converter.ambient_swing * math.sin(
        2.0 * math.pi * time / converter.ambient_period
    )
    zero = converter.offset + converter.drift * since_start
    zero += converter.warm_up * (1.0 - math.exp(-since_start / converter.warm_up_time))
    pressure = zero + (1.0 + gain_change) * shaped(converter, effective)
    return min(max(pressure, 0.0), supply_pressure)
