# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A stem that dry friction holds: what holds it, when it breaks away, how it slides."""

import math

from .actuator import breakaway_friction, has_dry_friction, is_rigid, sliding_friction
from .state import POSITION, VELOCITY
from .system import PositionerParameters, net_stem_force


def sticks(p: PositionerParameters) -> bool:
    """Tell whether the stem has dry friction without any yield, so that it sticks exactly."""
    return has_dry_friction(p.actuator) and is_rigid(p.actuator)


def held_force(p: PositionerParameters, time: float, current: float, y) -> float:
    """Return the presliding force, N, that keeps a resting stem where it is, as far as it can."""
    most = breakaway_friction(p.actuator, y[POSITION])
    return min(max(net_stem_force(p, time, current, y), -most), most)


def sliding_direction(p: PositionerParameters, y) -> float:
    """Return the direction in which a stem that can stick slides; 0 if it is exactly still."""
    return math.copysign(1.0, y[VELOCITY]) if sticks(p) and y[VELOCITY] != 0.0 else 0.0


def dry_friction(p: PositionerParameters, time: float, current: float, direction: float, y
                 ) -> float:
    """Return the rigid friction, N, against a stem that slides in `direction`, or is stuck (0)."""
    if direction == 0.0:
        return held_force(p, time, current, y)
    return direction * sliding_friction(p.actuator, y[POSITION], y[VELOCITY])


def slip_direction(p: PositionerParameters, time: float, current: float, y) -> float:
    """Return the direction in which a stem at rest breaks away, 0 if it stays stuck."""
    force = net_stem_force(p, time, current, y)
    if abs(force) <= breakaway_friction(p.actuator, y[POSITION]):
        return 0.0
    return 1.0 if force > 0.0 else -1.0


def breakaway_excess(p: PositionerParameters, time: float, current: float, y) -> float:
    """Return by how much the force on a stem at rest exceeds the break-away friction, N."""
    return abs(net_stem_force(p, time, current, y)) - breakaway_friction(
        p.actuator, y[POSITION])


def friction_time_scale(p: PositionerParameters, y, rates) -> float:
    """
    Return the time, s, until the friction may be one that the present one tells nothing about.

    While stiction fades, that is the time to twice the speed. While the stem slows down, it is the
    time to 2 Stribeck velocities, within which stiction sets in, then to 1 less. An error estimate
    can miss a peak of friction that a longer step jumps over.
    """
    fading = p.actuator.stribeck_velocity
    speed, change = abs(y[VELOCITY]), rates[VELOCITY]
    if p.actuator.stiction == 0.0 or change == 0.0:
        return math.inf
    if y[VELOCITY] * change >= 0.0:
        return max(speed, 0.01 * fading) / abs(change) if speed < 3.0 * fading else math.inf
    return max(speed - 2.0 * fading, fading) / abs(change)
