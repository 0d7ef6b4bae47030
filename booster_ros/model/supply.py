# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Supply line: the regulator that feeds the booster."""

import math
from typing import Annotated, NamedTuple

from .quantity import Quantity


class Supply(NamedTuple):
    """A regulator: stiff and steady unless told otherwise."""

    pressure: Annotated[float, Quantity(
        'Pa', 'supply pressure, gauge', 0.0, 2e6, 'paper Table II')] = 400e3
    temperature: Annotated[float, Quantity(
        'K', 'temperature of the supply air and of the surroundings', 200.0, 400.0,
        'assumed: 20 degrees Celsius')] = 293.15
    droop: Annotated[float, Quantity(
        'Pa s/kg', 'supply_droop: pressure lost per mass flow drawn', 0.0, 1e12)] = 0.0
    droop_time_constant: Annotated[float, Quantity(
        's', 'supply_droop: time in which the regulator follows the flow', 1e-4, 100.0,
        'regulators: 0.05 to 1 s')] = 0.1
    ripple: Annotated[float, Quantity(
        'Pa', 'supply_ripple: amplitude (compressor cycling)', 0.0, 1e6)] = 0.0
    ripple_frequency: Annotated[float, Quantity(
        'Hz', 'supply_ripple: frequency', 0.0, 100.0)] = 0.5
    ripple_phase: Annotated[float, Quantity(
        'rad', 'supply_ripple: phase at time zero', -100.0, 100.0)] = 0.0
    ripple_skew: Annotated[float, Quantity(
        '-', 'supply_ripple: 0 a sine, towards 1 a jump up and a slow fall, towards -1 a slow rise '
        'and a jump down', -0.99, 0.99)] = 0.0


HELD_SHARE = 0.05
"""Share of its period over which a ripple is held: what a sine does is then off by 0.4 %."""


def set_pressure(supply: Supply, time: float) -> float:
    """Return the supply pressure at no flow, Pa gauge, at `time` in s."""
    if supply.ripple == 0.0:
        return supply.pressure
    angle = 2.0 * math.pi * supply.ripple_frequency * time + supply.ripple_phase
    return supply.pressure + supply.ripple * swing(angle, supply.ripple_skew)


def swing(angle: float, skew: float) -> float:
    """
    Return a wave between -1 and 1 at `angle` (rad): a sine, with `skew` (-1 to 1) a saw-tooth.

    It is the sum of skew^(n - 1) sin(n angle) / n over all n >= 1 (Gradshteyn and Ryzhik, Table of
    Integrals, Series, and Products, 1.448) over the largest value of that sum.
    """
    if abs(skew) < 1e-6:
        return math.sin(angle)
    return math.atan2(skew * math.sin(angle), 1.0 - skew * math.cos(angle)) / math.asin(skew)


def longest_hold(supply: Supply) -> float:
    """Return how long, s, the pressure at no flow may be held at what it is in the middle."""
    if supply.ripple == 0.0 or supply.ripple_frequency == 0.0:
        return math.inf
    return HELD_SHARE / supply.ripple_frequency


def supply_pressure_rate(supply: Supply, pressure: float, undrawn: float, flow: float) -> float:
    """
    Return d(supply pressure)/dt, Pa/s; `undrawn` is the pressure at no flow, `flow` in kg/s.

    A regulator loses all of its pressure at the most: it does not suck.
    """
    left = max(undrawn - supply.droop * max(flow, 0.0), 0.0)
    return (left - pressure) / supply.droop_time_constant
