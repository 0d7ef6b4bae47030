# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Air supply: regulator and compressor."""

import math
from typing import NamedTuple

from numba import njit


class Supply(NamedTuple):
    """Constants in SI units; everything below the blank line is neutral at its default."""

    pressure: float = 400e3  # Pa gauge
    temperature: float = 293.15  # K

    droop: float = 0.0  # Pa s/kg, fall of the regulated pressure with the flow drawn
    regulator_time: float = 0.15  # s
    ripple: float = 0.0  # Pa, amplitude
    ripple_frequency: float = 0.25  # Hz
    sag: float = 0.0  # Pa, lost before the compressor cuts in again
    sag_period: float = 31.0  # s
    fall: float = 0.0  # Pa, lost for good at fall_time
    fall_time: float = 20.0  # s


@njit(cache=True)
def regulated_pressure(supply, flow, time):
    """Return the gauge pressure in Pa the regulator would settle at under a flow in kg/s."""
    cycle = time / supply.sag_period
    return (
        supply.pressure
        - supply.droop * max(flow, 0.0)
        + supply.ripple * math.sin(2.0 * math.pi * supply.ripple_frequency * time)
        - (supply.fall if time >= supply.fall_time else 0.0)
        - supply.sag * (cycle - math.floor(cycle))
    )
