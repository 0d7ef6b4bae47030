# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Booster relay: force balance of the diaphragm stack and the two seats it opens."""

import math
from typing import NamedTuple

from numba import njit

from .converter import play


class Booster(NamedTuple):
    """Constants in SI units; everything below the blank line is neutral at its default."""

    s1: float = 13.52e-6  # m²
    s2: float = 9.28e-6  # m²
    s3: float = 3.14e-6  # m²
    opening_gain: float = 2.75e-6  # m²/N
    max_area: float = 1.45e-6  # m²
    critical_ratio: float = 0.5283

    intake_preload: float = 0.0  # N, force before the intake opens
    exhaust_preload: float = 0.0  # N
    exhaust_change: float = 0.0  # relative change of the exhaust's gain and largest area
    supply_leak: float = 0.0  # m², intake seat that never closes
    exhaust_leak: float = 0.0  # m²
    curvature: float = 0.0  # area ~ force^(1 + curvature), unchanged where the seat is fully open
    ripple: float = 0.0  # relative modulation of dS/dF by rows of holes in the spool
    ripple_pitch: float = 0.2  # N, from one row of holes to the next
    jet: float = 0.0  # plug flow force per pressure drop and area
    stick_force: float = 0.0  # N, change of force a sticking spool ignores
    stick_period: float = 23.0  # s, it sticks in the first 60 % of each period
    relay_friction: float = 0.0  # N, sliding friction of the stack


@njit(cache=True)
def diaphragm_force(booster, back_pressure, outlet_pressure, supply_pressure):
    """Return the net force on the stack in N; positive opens the intake. Gauge pressures."""
    return (
        back_pressure * booster.s1
        - outlet_pressure * booster.s3
        - supply_pressure * (booster.s2 - booster.s3)
    )


@njit(cache=True)
def spool_force(booster, previous, force, time):
    """Return the force in N that the spool's position answers to; a stuck one keeps the last."""
    if booster.relay_friction > 0.0:
        return play(previous, force, 2.0 * booster.relay_friction)
    phase = time / booster.stick_period
    sticking = phase - math.floor(phase) < 0.6
    if sticking and abs(force - previous) < booster.stick_force:
        return previous
    return force


@njit(cache=True)
def opening(booster, force, gain, max_area, pressure_drop):
    """Return the area in m² that a seat opens under a force in N; none for a force below zero."""
    if force <= 0.0:
        return 0.0
    full_force = max_area / gain
    area = gain * force
    if booster.curvature != 0.0:
        area = max_area * (force / full_force) ** (1.0 + booster.curvature)
    if booster.ripple != 0.0:
        turn = 2.0 * math.pi / booster.ripple_pitch
        area += gain * booster.ripple / turn * math.sin(turn * force)
    # The jet pushes the plug shut in proportion to what it opens.
    area /= 1.0 + gain * booster.jet * max(pressure_drop, 0.0)
    return min(area, max_area)


@njit(cache=True)
def intake_area(booster, force, pressure_drop):
    """Return the area in m² from supply to outlet, leak excluded."""
    return opening(
        booster,
        force - booster.intake_preload,
        booster.opening_gain,
        booster.max_area,
        pressure_drop,
    )


@njit(cache=True)
def exhaust_area(booster, force, pressure_drop):
    """Return the area in m² from outlet to atmosphere, leak excluded."""
    scale = 1.0 + booster.exhaust_change
    return opening(
        booster,
        -force - booster.exhaust_preload,
        booster.opening_gain * scale,
        booster.max_area * scale,
        pressure_drop,
    )
