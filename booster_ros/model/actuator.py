# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Actuator: diaphragm, spring-opposed stem and end stops; its gas is in `chamber`."""

from collections.abc import Callable
import math
from typing import Annotated, NamedTuple

from .quantity import Quantity


STEM, VESSEL = 0, 1


class Actuator(NamedTuple):
    """Chamber, diaphragm, spring, stem and stops."""

    effective_area: Annotated[float, Quantity(
        'm^2', 'diaphragm area at closed stem, A', 1e-6, 10.0,
        'fitted to paper Table III with dead_volume; only ratios are identifiable')] = 0.0796
    dead_volume: Annotated[float, Quantity(
        'm^3', 'chamber volume at closed stem, V0', 1e-9, 10.0,
        'fitted to paper Table III')] = 0.185e-3
    polytropic_index: Annotated[float, Quantity(
        '-', 'n: 1 isothermal, 1.4 adiabatic', 1.0, 1.4, 'assumed: isothermal')] = 1.0
    moving_mass: Annotated[float, Quantity(
        'kg', 'stem, plug and diaphragm plate', 1e-3, 1e4, 'assumed')] = 4.0
    bench_set: Annotated[tuple[float, float], Quantity(
        'Pa', 'gauge pressures at which the stem leaves 0 and reaches the travel',
        -1e6, 1e7, 'paper Table II')] = (150e3, 300e3)
    travel: Annotated[float, Quantity('m', 'stroke L', 1e-5, 2.0, 'paper Table II')] = 0.016
    viscous_friction: Annotated[float, Quantity(
        'N s/m', 'force per stem velocity, c', 0.0, 1e9, 'assumed')] = 3000.0
    stop_stiffness: Annotated[float, Quantity(
        'N/m', 'stiffness of the end stops', 1e5, 1e11, 'assumed: yields micrometres')] = 5e8
    stop_damping: Annotated[float, Quantity(
        'N s/m', 'damping of the end stops', 0.0, 1e9, 'assumed: no rebound')] = 1e5
    kind: Annotated[int, Quantity(
        '-', 'stem, which a spring closes, or vessel: the dead volume is all there is, nothing '
        'moves, the position is 0', source='paper Fig. 1')] = STEM
    leak_area: Annotated[float, Quantity(
        'm^2', 'chamber_leak: effective area, chamber to atmosphere', 0.0, 1e-2)] = 0.0
    thermal_resistance: Annotated[float, Quantity(
        'K/W', 'heat_transfer: air to wall, 0 = isothermal (polytropic_index rules)',
        0.0, 1e4)] = 0.0
    added_volume: Annotated[float, Quantity(
        'm^3', 'dead_volume_change: volume added to the declared dead volume', -10.0, 10.0)] = 0.0
    area_change: Annotated[float, Quantity(
        '-', 'effective_area_change: relative loss of area over the travel', -0.9, 0.9)] = 0.0
    upper_travel_lost: Annotated[float, Quantity(
        '-', 'travel_limit: share of the travel that the upper stop takes away', 0.0, 0.99)] = 0.0
    lower_travel_lost: Annotated[float, Quantity(
        '-', 'travel_limit: share of the travel that the lower stop takes away', 0.0, 0.99)] = 0.0
    added_damping: Annotated[float, Quantity(
        'N s/m', 'stem_damping: force per stem velocity beside viscous_friction',
        0.0, 1e12)] = 0.0
    coulomb_friction: Annotated[float, Quantity(
        'N', 'stem_friction: sliding friction', 0.0, 1e6)] = 0.0
    stiction: Annotated[float, Quantity(
        'N', 'stem_friction: break-away force beyond sliding friction', 0.0, 1e6)] = 0.0
    stribeck_velocity: Annotated[float, Quantity(
        'm/s', 'stem_friction: velocity at which stiction has faded to 37 %', 1e-6, 1.0,
        'packings: 0.1 to 5 mm/s')] = 1e-3
    presliding_stiffness: Annotated[float, Quantity(
        'N/m', 'stem_friction: stiffness of the packing before it slides, 0 = rigid, it sticks '
        'exactly', 0.0, 1e12, 'packings: 1e7 to 1e9 N/m')] = 0.0
    presliding_damping: Annotated[float, Quantity(
        '-', 'stem_friction: damping of the packing before it slides, 1 = critical with the moving '
        'mass', 0.0, 100.0, 'assumed: no ringing')] = 1.0
    friction_gradient: Annotated[float, Quantity(
        'N', 'position_dependent_friction: sliding friction added from closed to full travel',
        -1e6, 1e6)] = 0.0
    friction_peak: Annotated[float, Quantity(
        'N', 'position_dependent_friction: sliding friction added where the stem has galled',
        0.0, 1e6)] = 0.0
    friction_peak_position: Annotated[float, Quantity(
        'm', 'position_dependent_friction: position at which that is most', 0.0, 2.0)] = 8e-3
    friction_peak_width: Annotated[float, Quantity(
        'm', 'position_dependent_friction: distance from there at which it has fallen to 37 %',
        1e-6, 2.0)] = 2e-3
    bench_set_shift: Annotated[float, Quantity(
        'Pa', 'bench_set_shift: moves both ends of the bench set', -1e6, 1e6)] = 0.0
    spring_loss: Annotated[float, Quantity(
        '-', 'spring_rate_change: share of the spring force that is missing, preload included, '
        'below zero one that is too much', -10.0, 0.99)] = 0.0
    spring_bend: Annotated[float, Quantity(
        'N', 'spring_nonlinearity: extra spring force at mid travel, none at both ends',
        -1e6, 1e6)] = 0.0
    spring_s_curve: Annotated[float, Quantity(
        'N', 'spring_nonlinearity: odd part, at a quarter of the travel', -1e6, 1e6)] = 0.0
    spring_excess: Annotated[float, Quantity(
        'N', 'spring_nonlinearity: spring force at full travel beyond that of the bench set',
        -1e6, 1e6)] = 0.0
    seat_load: Annotated[float, Quantity(
        'N', 'seat_load: force of the soft seat on the closed stem (opening)', -1e6, 1e6)] = 0.0
    seat_depth: Annotated[float, Quantity(
        'm', 'seat_load: travel over which the seat lets go', 1e-6, 0.1)] = 1e-3
    seat_stiffness: Annotated[float, Quantity(
        'N/m', 'seat_load: stiffness of a soft seat before the lower stop, 0 = hard',
        0.0, 1e12)] = 0.0
    flow_force: Annotated[float, Quantity(
        'N', 'flow_force: closing force of the process on the plug at closed stem',
        -1e6, 1e6)] = 0.0
    flow_force_decay: Annotated[float, Quantity(
        '-', 'flow_force: travel fraction over which it falls to 37 %', 0.01, 10.0)] = 0.3
    plug_area: Annotated[float, Quantity(
        'm^2', 'process_force: area on which the pressure drop over the process valve pushes the '
        'stem towards where it rests vented; negative: away from there; 0: a balanced plug',
        -10.0, 10.0)] = 0.0


def diaphragm_area(act: Actuator, position: float) -> float:
    """Return A(x), m²."""
    return act.effective_area * (1.0 - act.area_change * position / act.travel)


def spring_force(act: Actuator, position: float) -> float:
    """Return the force that closes the stem, N: preload, spring, seat and process."""
    low = act.bench_set[0] + act.bench_set_shift
    span = act.bench_set[1] - act.bench_set[0]
    xi = position / act.travel
    force = act.effective_area * (low + span * xi)
    if act.spring_bend != 0.0 or act.spring_s_curve != 0.0 or act.spring_excess != 0.0:
        inside = min(max(xi, 0.0), 1.0)
        force += act.spring_excess * inside
        bow = inside * (1.0 - inside)
        force += 4.0 * act.spring_bend * bow
        force += 32.0 / 3.0 * act.spring_s_curve * bow * (1.0 - 2.0 * inside)
    force *= 1.0 - act.spring_loss
    if act.seat_load != 0.0:
        force -= act.seat_load * min(max(1.0 - position / act.seat_depth, 0.0), 1.0)
    if act.flow_force != 0.0:
        force += act.flow_force * math.exp(-max(xi, 0.0) / act.flow_force_decay)
    return force


def lower_stop(act: Actuator) -> float:
    """Return the position of the lower stop, m."""
    return act.travel * act.lower_travel_lost


def upper_stop(act: Actuator) -> float:
    """Return the position of the upper stop, m."""
    return act.travel * (1.0 - act.upper_travel_lost)


def is_in_a_stop(act: Actuator, position: float) -> bool:
    """Tell whether an end stop yields to a stem that stands here (m)."""
    return position < lower_stop(act) or position > upper_stop(act)


def stop_force(act: Actuator, position: float, velocity: float) -> float:
    """Return the force of the end stops on the stem, N, positive towards open; never pulls."""
    within = position - lower_stop(act)
    if within < 0.0:
        stiffness = act.stop_stiffness
        if act.seat_stiffness > 0.0:  # seat and stop are springs in series
            stiffness *= act.seat_stiffness / (act.seat_stiffness + stiffness)
        return max(-stiffness * within - act.stop_damping * velocity, 0.0)
    beyond = position - upper_stop(act)
    if beyond > 0.0:
        return min(-act.stop_stiffness * beyond - act.stop_damping * velocity, 0.0)
    return 0.0


def stem_force(act: Actuator, pressure: float, position: float, velocity: float,
               discrepancy: float) -> float:
    """Return the force on the stem except dry friction, N, positive towards open."""
    return (
        diaphragm_area(act, position) * pressure
        - spring_force(act, position)
        - (act.viscous_friction + act.added_damping) * velocity
        + stop_force(act, position, velocity)
        + discrepancy
    )


def process_force(act: Actuator, pressure_drop: float) -> float:
    """Return the force of the process on the stem, N, from the drop over its valve, Pa."""
    return -act.plug_area * pressure_drop


def has_dry_friction(act: Actuator) -> bool:
    """Tell whether the stem can stick."""
    return act.kind == STEM and (
        act.coulomb_friction > 0.0 or act.stiction > 0.0 or act.friction_gradient != 0.0
        or act.friction_peak > 0.0)


def friction_along_travel(act: Actuator, position: float) -> float:
    """Return how much dry friction is added here by a bent or galled stem, N."""
    bent = act.friction_gradient * position / act.travel
    if act.friction_peak == 0.0:
        return bent
    off = (position - act.friction_peak_position) / act.friction_peak_width
    return bent + act.friction_peak * math.exp(-off * off)


def sliding_friction(act: Actuator, position: float, velocity: float) -> float:
    """Return the magnitude of dry friction while sliding, N (Coulomb and Stribeck)."""
    level = max(act.coulomb_friction + friction_along_travel(act, position), 0.0)
    if act.stiction == 0.0:
        return level
    v = velocity / act.stribeck_velocity
    return level + act.stiction * math.exp(-v * v)


LEAST_SHARE = 0.02
"""Least friction of the bristles, as a share of the largest that they can have."""


def is_rigid(act: Actuator) -> bool:
    """Tell whether a stem that sticks does not yield at all."""
    return act.presliding_stiffness <= 0.0


def presliding_force_rate(act: Actuator, force: float, position: float, velocity: float) -> float:
    """
    Return the rate in N/s of the force that the packing's bristles hold against the stem.

    LuGre model, C. Canudas de Wit et al., IEEE Trans. Automatic Control 40 (1995) 419, eq. 2, with
    the force in place of the deflection: the force grows as the stem moves and saturates at the
    sliding friction. Where a bent stem rubs less and less, `LEAST_SHARE` of the largest friction
    stays: bristles that hold nothing have no law.
    """
    least = LEAST_SHARE * (act.coulomb_friction + abs(act.friction_gradient) + act.friction_peak
                           + act.stiction)
    sliding = max(sliding_friction(act, position, velocity), least)
    return act.presliding_stiffness * (velocity - abs(velocity) * force / sliding)


def presliding_friction(act: Actuator, force: float, rate: float) -> float:
    """
    Return the friction, N, of bristles that hold this force (N), which changes at this rate (N/s).

    Eq. 3 of the source in `presliding_force_rate`.
    """
    damping = act.presliding_damping * 2.0 * math.sqrt(act.presliding_stiffness * act.moving_mass)
    return force + damping / act.presliding_stiffness * rate


def presliding_time(act: Actuator) -> float:
    """Return 1/ω of the moving mass on a packing that yields, s."""
    return math.sqrt(act.moving_mass / act.presliding_stiffness)


def breakaway_friction(act: Actuator, position: float) -> float:
    """Return the force that a stem at rest withstands, N."""
    return sliding_friction(act, position, 0.0)


def stem_acceleration(act: Actuator, force: float, friction: float) -> float:
    """Return d²x/dt², m/s²; `friction` is signed, positive towards open."""
    return (force + friction) / act.moving_mass


DOUBLINGS = 40
"""Doublings of a tenth of the travel that lead further than any stop yields."""


def balance_position(act: Actuator, pressure: float,
                     extra: Callable[[float], float] = lambda position: 0.0) -> float:
    """
    Return the position, m, at which spring, stops and pressure (gauge, Pa) balance.

    `extra` is a further force, N, positive towards open, as a function of the position. Bisection:
    the balance has no closed form once the spring is bent or the area changes. 0 for a vessel.
    """
    if act.kind == VESSEL:
        return 0.0

    def net_force(position: float) -> float:
        return stem_force(act, pressure, position, 0.0, extra(position))

    low, high = -0.1 * act.travel, 1.1 * act.travel
    for doublings in range(DOUBLINGS):
        beyond = 0.1 * act.travel * 2.0**doublings
        if net_force(low) < 0.0:  # the stem is pressed further into its stop, or seat
            low, high = low - beyond, low
        elif net_force(high) > 0.0:
            low, high = high, high + beyond
        else:
            break
    else:  # no balance: in the stop a changing area adds more than the stop pushes back
        return lower_stop(act) if net_force(low) < 0.0 else upper_stop(act)
    for _ in range(60):
        middle = 0.5 * (low + high)
        if net_force(middle) > 0.0:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)
