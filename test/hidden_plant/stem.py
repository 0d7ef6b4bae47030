# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Stem: spring, seat, stops and friction that truly sticks."""

import math
from typing import NamedTuple

from numba import njit


class Stem(NamedTuple):
    """Constants in SI units; everything below the blank line is neutral at its default."""

    mass: float = 4.0  # kg
    preload: float = 0.0796 * 150e3  # N
    spring_rate: float = 0.0796 * 150e3 / 0.016  # N/m
    viscous_friction: float = 3000.0  # N s/m
    travel: float = 0.016  # m
    stop_stiffness: float = 5e8  # N/m
    stop_damping: float = 4e4  # N s/m

    coulomb: float = 0.0  # N
    stiction: float = 0.0  # relative excess of break-away over sliding friction
    stribeck_speed: float = 1e-3  # m/s
    packing_stiffness: float = 0.0  # N/m, of a packing that yields before it slides, 0: it sticks
    packing_damping: float = 0.3  # share of critical, of the stem held by such a packing
    one_sided: float = 0.0  # N, by which friction is more while it opens, less while it closes
    coulomb_rise: float = 0.0  # N, added at full travel, in proportion to travel
    galling: float = 0.0  # N, added where the stem is scored, most in the middle of that
    galled_at: float = 0.006  # m
    galled_over: float = 0.005  # m, from end to end
    drag: float = 0.0  # m², sliding friction per chamber pressure
    hardening: float = 0.0  # relative excess of spring force at full travel, parabolic
    knee: float = 0.0  # relative change of spring rate beyond knee_position
    knee_position: float = 0.007  # m
    shift: float = 0.0  # N, added to the preload
    seat_softness: float = 0.0  # m/N, inverse stiffness of a soft seat
    seat_jam: float = 0.0  # N, to pull the plug out of the seat
    flow_force: float = 0.0  # N, of the process fluid, shuts, near the seat
    flow_force_reach: float = 0.003  # m
    creep: float = 0.0  # share of the spring rate that relaxes
    creep_time: float = 20.0  # s


@njit(cache=True)
def spring_force(stem, position, relaxed_position):
    """Return the force in N that pushes the stem towards the seat."""
    rate = stem.spring_rate
    force = stem.preload + stem.shift + rate * position
    force += rate * stem.hardening * position * position / stem.travel
    force += rate * stem.knee * max(position - stem.knee_position, 0.0)
    return force + rate * stem.creep * (position - relaxed_position)


@njit(cache=True)
def fluid_force(stem, position):
    """Return the force in N with which the process fluid shuts the valve."""
    return stem.flow_force * math.exp(-max(position, 0.0) / stem.flow_force_reach)


@njit(cache=True)
def contact(depth, speed_inwards, stiffness, damping):
    """Return the force in N of an end stop; a stop pushes and never pulls."""
    if depth <= 0.0:
        return 0.0
    return max(stiffness * depth + damping * speed_inwards, 0.0)


@njit(cache=True)
def stop_force(stem, position, velocity):
    """Return the force in N of seat and upper stop, positive where it opens the valve."""
    seat_stiffness = stem.stop_stiffness / (1.0 + stem.stop_stiffness * stem.seat_softness)
    seat = contact(-position, -velocity, seat_stiffness, stem.stop_damping)
    top = contact(position - stem.travel, velocity, stem.stop_stiffness, stem.stop_damping)
    return seat - top


@njit(cache=True)
def sliding_friction(stem, position, chamber_pressure):
    """Return the sliding friction in N."""
    rise = stem.coulomb_rise * min(max(position / stem.travel, 0.0), 1.0)
    scored = max(1.0 - (2.0 * (position - stem.galled_at) / stem.galled_over) ** 2, 0.0)
    rise += stem.galling * scored * scored
    return stem.coulomb + rise + stem.drag * max(chamber_pressure, 0.0)


@njit(cache=True)
def next_velocity(stem, position, velocity, force, chamber_pressure, step):
    """
    Return the velocity in m/s one step later under all forces but friction; the packing sticks.

    A stem at rest stays at exactly 0 until the force exceeds the break-away friction; a moving one
    comes to rest in the step in which its velocity would change sign.
    """
    sliding = sliding_friction(stem, position, chamber_pressure)
    if stem.one_sided != 0.0:
        sliding += math.copysign(stem.one_sided, velocity if velocity != 0.0 else force)
    break_away = sliding * (1.0 + stem.stiction)
    jam = stem.seat_jam if position <= 0.0 and force > 0.0 else 0.0
    inertia = stem.mass + step * stem.viscous_friction  # viscous drag taken at the step's end
    if velocity == 0.0:
        if abs(force) <= break_away + jam:
            return 0.0
        return step * (force - math.copysign(break_away, force)) / inertia
    stribeck = math.exp(-((velocity / stem.stribeck_speed) ** 2)) if stem.stiction != 0.0 else 0.0
    friction = math.copysign(sliding + (break_away - sliding) * stribeck, velocity)
    velocity_next = (stem.mass * velocity + step * (force - friction)) / inertia
    if break_away + jam > 0.0 and velocity_next * velocity <= 0.0:
        return 0.0
    return velocity_next


@njit(cache=True)
def next_velocity_yielding(
    stem, position, velocity, deflection, force, chamber_pressure, step
):
    """
    Return velocity (m/s) and deflection of the packing (m) one step later; the packing yields.

    It is a spring with a dashpot that takes the stem's way up to where it begins to slide, which is
    at less force the faster the stem moves.
    """
    sliding = sliding_friction(stem, position, chamber_pressure)
    stribeck = math.exp(-((velocity / stem.stribeck_speed) ** 2))
    most = sliding * (1.0 + stem.stiction * stribeck) / stem.packing_stiffness
    yielding = velocity - abs(velocity) * deflection / most
    dashpot = stem.packing_damping * 2.0 * math.sqrt(stem.packing_stiffness * stem.mass)
    friction = stem.packing_stiffness * deflection + dashpot * yielding
    inertia = stem.mass + step * stem.viscous_friction
    velocity = (stem.mass * velocity + step * (force - friction)) / inertia
    return velocity, deflection + step * yielding
