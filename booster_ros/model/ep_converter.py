# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""E/P converter: control current to back pressure."""

import math
from typing import Annotated, NamedTuple

from .quantity import Quantity


class EpConverter(NamedTuple):
    """Torque motor and nozzle-flapper, seen from outside: a gain, an offset and a lag."""

    gain: Annotated[float, Quantity(
        'Pa/A', 'settled back pressure per control current', 1e6, 1e11,
        'makes 0.4524 mA settle at the 270.3 kPa of paper Table III')] = 244.45e3 / 0.4524e-3
    offset: Annotated[float, Quantity(
        'Pa', 'back pressure at zero current', -1e6, 1e6, 'assumed: calibrated zero')] = 0.0
    time_constant: Annotated[float, Quantity(
        's', 'lag of the back pressure', 1e-4, 60.0, 'fitted to paper Table III')] = 0.034
    hysteresis: Annotated[float, Quantity(
        'A', 'ep_hysteresis: width of the current loop (magnetic, flapper)', 0.0, 1e-2)] = 0.0
    drift: Annotated[float, Quantity(
        'Pa', 'ep_drift: shift of the back pressure that time brings in the end', -1e6, 1e6)] = 0.0
    drift_time_constant: Annotated[float, Quantity(
        's', 'ep_drift: time in which 63 % of the drift has come', 1e-3, 1e9)] = 100.0
    nonlinearity_even: Annotated[float, Quantity(
        'Pa', 'ep_nonlinearity: bend, back pressure added one span away from the centre',
        -1e6, 1e6)] = 0.0
    nonlinearity_odd: Annotated[float, Quantity(
        'Pa', 'ep_nonlinearity: S-curve, cubic term one span away from the centre',
        -1e6, 1e6)] = 0.0
    nonlinearity_centre: Annotated[float, Quantity(
        'Pa', 'ep_nonlinearity: back pressure about which the curve bends', 0.0, 1e7,
        'settled back pressure at mid travel')] = 234e3
    nonlinearity_span: Annotated[float, Quantity(
        'Pa', 'ep_nonlinearity: back pressure span that the terms are given for', 1.0, 1e7,
        'the back pressures that move the stem')] = 30e3
    dead_time: Annotated[float, Quantity(
        's', 'dead_time: delay of the control current', 0.0, 10.0)] = 0.0
    gain_loss: Annotated[float, Quantity(
        '-', 'ep_gain_loss: share of the control current that does nothing, below zero one that '
        'does too much', -10.0, 1.0)] = 0.0


def play(previous: float, target: float, width: float) -> float:
    """Return where a part driven through a play of this width stands (same unit throughout)."""
    return min(max(previous, target - 0.5 * width), target + 0.5 * width)


def settled_back_pressure(
    ep: EpConverter, current: float, supply: float, time: float, discrepancy: float
) -> float:
    """
    Return the back pressure, Pa gauge, that `current` (A) settles at.

    `supply` limits it (Pa gauge), `time` (s) is what drift counts from, `discrepancy` (Pa) is
    what a record showed beyond these equations.
    """
    linear = ep.offset + ep.gain * current * (1.0 - ep.gain_loss)
    if ep.nonlinearity_even != 0.0 or ep.nonlinearity_odd != 0.0:
        u = (linear - ep.nonlinearity_centre) / ep.nonlinearity_span
        linear += ep.nonlinearity_even * u * u + ep.nonlinearity_odd * u * u * u
    if ep.drift != 0.0:
        linear += ep.drift * (1.0 - math.exp(-max(time, 0.0) / ep.drift_time_constant))
    return min(max(linear + discrepancy, 0.0), max(supply, 0.0))


QUICKEST, SLOWEST = -2.3, 10.0
"""Ends of the natural logarithm of how many times as slow as its time constant a converter is."""


def times_as_slow(discrepancy: float) -> float:
    """
    Return how many times as slow as its time constant a converter is.

    `discrepancy` is the natural logarithm of what a record showed, within QUICKEST and SLOWEST.
    """
    return math.exp(min(max(discrepancy, QUICKEST), SLOWEST))


def back_pressure_rate(
    ep: EpConverter, back_pressure: float, settled: float, discrepancy: float
) -> float:
    """Return d(back pressure)/dt, Pa/s; `discrepancy` as in `times_as_slow`."""
    lag = ep.time_constant
    if discrepancy != 0.0:
        lag *= times_as_slow(discrepancy)
    return (settled - back_pressure) / lag
