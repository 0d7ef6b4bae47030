# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The wired positioner: how the components act on each other."""

from typing import NamedTuple

from . import discrepancy as term
from .actuator import (
    VESSEL, Actuator, diaphragm_area, has_dry_friction, is_rigid, presliding_force_rate,
    presliding_friction, process_force, sliding_friction, stem_acceleration, stem_force)
from .booster import (
    NO_BOOSTER, Booster, diaphragm_force, exhaust_area, exhaust_flow, intake_area, intake_flow)
from .chamber import (
    chamber_volume, energy_rates, isothermal_filling, isothermal_pressure_rate, leak_flow)
from .discrepancy import (
    Discrepancy, forgets, has_play, interpolate, past_at_rest, remembers, slope)
from .ep_converter import EpConverter, back_pressure_rate, play, settled_back_pressure
from .gas import ATMOSPHERE, enthalpy_flow
from .position_controller import PositionController
from .present_term import PAST_UNIT, discrepancy_at, settled_past
from .sensors import Sensors
from .state import (
    BACK, CHAMBER, OUTLET, PAST, POSITION, PRESLIDING, PRESSURE_DROP, SUPPLY, TEMPERATURE, VELOCITY)
from .supply import Supply, set_pressure, supply_pressure_rate
from .tubing import Tubing, outlet_pressure_rate, tube_flow

SMALLEST_VOLUME = 0.05
"""Least volume of the chamber, as a share of the dead volume: the space between solid parts."""

LARGEST_YIELD = 0.5
"""Most by which a falling table may stiffen the chamber, as a share of its gas's compliance."""


class PositionerParameters(NamedTuple):
    """All parameters of the positioner, by component."""

    ep_converter: EpConverter = EpConverter()
    booster: Booster = Booster()
    supply: Supply = Supply()
    tubing: Tubing = Tubing()
    actuator: Actuator = Actuator()
    sensors: Sensors = Sensors()
    discrepancy: Discrepancy = Discrepancy()
    position_controller: PositionController = PositionController()


def plant_of(p: PositionerParameters) -> PositionerParameters:
    """
    Return the parameters of all but the controller, whose place is empty.

    The equations need no more, and machine code hands parameters over number by number.
    """
    return p._replace(position_controller=())  # type: ignore[arg-type]


def is_direct(p: PositionerParameters) -> bool:
    """Tell whether nothing is between converter and chamber, so that they have one pressure."""
    return p.booster.kind == NO_BOOSTER and p.tubing.restriction_area <= 0.0


def is_active(p: PositionerParameters, state: int) -> bool:
    """Tell whether a state has dynamics of its own under these parameters."""
    if state == SUPPLY:
        return p.supply.droop > 0.0
    if state == OUTLET:
        return p.tubing.restriction_area > 0.0 and p.booster.kind != NO_BOOSTER
    if state == TEMPERATURE:
        return p.actuator.thermal_resistance > 0.0 and not is_direct(p)
    if state == PAST:
        return forgets(p.discrepancy)
    if state == PRESLIDING:
        return has_dry_friction(p.actuator) and not is_rigid(p.actuator)
    if state in (POSITION, VELOCITY):
        return p.actuator.kind != VESSEL
    return state != PRESSURE_DROP


def hold_inactive_states(p: PositionerParameters, time: float, y, pinned) -> None:
    """Set states that have no dynamics of their own, and are not pinned, to what they follow."""
    if p.supply.droop <= 0.0 and SUPPLY not in pinned:
        y[SUPPLY] = undrawn_supply(p, time)
    if is_direct(p) and CHAMBER not in pinned:
        y[CHAMBER] = y[BACK]
    if not is_active(p, OUTLET):
        y[OUTLET] = outlet_pressure(p, y)
    if not is_active(p, TEMPERATURE):
        y[TEMPERATURE] = p.supply.temperature
    if p.actuator.kind == VESSEL:
        y[POSITION] = y[VELOCITY] = 0.0
    if not remembers(p.discrepancy):
        y[PAST] = 0.0
    if not is_active(p, PRESLIDING):
        y[PRESLIDING] = 0.0


def undrawn_supply(p: PositionerParameters, time: float) -> float:
    """Return the supply pressure at no flow, Pa gauge."""
    pressure = set_pressure(p.supply, time)
    if p.discrepancy.location == term.SUPPLY and p.discrepancy.variable == term.TIME:
        pressure += interpolate(p.discrepancy, time)
    return pressure


def rest_in_play(p: PositionerParameters, y) -> None:
    """Put what the booster's force moves through a play, if there is one, where it is at rest."""
    if has_play(p.discrepancy):
        y[PAST] = past_at_rest(
            p.discrepancy, undisturbed_force(p, y)) / PAST_UNIT[term.FORCE_PLAY]


def follow_play(p: PositionerParameters, y) -> None:
    """Let what the booster's force moves through a play, if there is one, follow the force."""
    table = p.discrepancy
    if has_play(table):
        unit = PAST_UNIT[term.FORCE_PLAY]
        y[PAST] = play(unit * y[PAST], undisturbed_force(p, y), 2.0 * table.reach) / unit


def outlet_pressure(p: PositionerParameters, y) -> float:
    """Return the gauge pressure where the tube begins, Pa: that of the chamber without a tube."""
    if p.booster.kind == NO_BOOSTER:
        return y[BACK]
    return y[OUTLET] if p.tubing.restriction_area > 0.0 else y[CHAMBER]


def undisturbed_force(p: PositionerParameters, y) -> float:
    """Return the force on the booster's stack of diaphragms, N, without a term."""
    return diaphragm_force(p.booster, y[BACK], outlet_pressure(p, y), y[SUPPLY])


def booster_force(p: PositionerParameters, time: float, current: float, y) -> float:
    """Return the force that opens the booster's seats, N; 0 without a booster."""
    if p.booster.kind == NO_BOOSTER:
        return 0.0
    force = undisturbed_force(p, y)
    if p.discrepancy.location == term.BOOSTER:
        force += discrepancy_at(p.discrepancy, time, current, y, force)
    return force


def seat_flows(p: PositionerParameters, force: float, y, gas_temperature: float
               ) -> tuple[float, float, float, float]:
    """
    Return what the booster's seats do while `force` (N) opens them.

    The open areas of intake and exhaust, m², and the mass flows through them, kg/s: from the supply
    to the outlet, and from there to the atmosphere. `gas_temperature` is that of the chamber, K.
    Without a booster the converter gives or takes what flows through the tube.
    """
    ambient, outlet = p.supply.temperature, outlet_pressure(p, y)
    if p.booster.kind == NO_BOOSTER:
        flow = tube_flow(p.tubing, outlet, y[CHAMBER], ambient, gas_temperature)
        return 0.0, 0.0, max(flow, 0.0), max(-flow, 0.0)
    # the small volume before a tube is isothermal
    temperature = ambient if p.tubing.restriction_area > 0.0 else gas_temperature
    opened_in = intake_area(p.booster, force, y[SUPPLY], outlet)
    opened_out = exhaust_area(p.booster, force, outlet)
    into = intake_flow(p.booster, opened_in, y[SUPPLY], outlet, ambient, temperature)
    out = exhaust_flow(p.booster, opened_out, outlet, temperature, ambient)
    return opened_in, opened_out, into, out


def chamber_space(p: PositionerParameters, pressure: float, position: float
                  ) -> tuple[float, float, float]:
    """Return the chamber's volume V, m³, dV/dx, m², and its compliance dV/dp, m³/Pa."""
    volume, area = chamber_volume(p.actuator, position), diaphragm_area(p.actuator, position)
    compliance = 0.0
    table = p.discrepancy
    if table.location == term.CHAMBER_VOLUME:
        by_stem = table.variable == term.VALVE_POSITION
        value = position if by_stem else pressure
        volume += interpolate(table, value)
        if by_stem:
            area += slope(table, value)
        else:
            # a table that falls must not let the pressure run away
            most = LARGEST_YIELD * volume / (pressure + ATMOSPHERE)
            compliance = max(slope(table, value), -most)
    least = SMALLEST_VOLUME * p.actuator.dead_volume
    if volume < least:  # it stays at that whatever moves, or gas would be made or lost
        return least, 0.0, 0.0
    return volume, area, compliance


def net_stem_force(p: PositionerParameters, time: float, current: float, y) -> float:
    """Return the force on the stem except dry friction, N, positive towards open."""
    extra = 0.0
    if p.discrepancy.location == term.STEM:
        extra = discrepancy_at(p.discrepancy, time, current, y, 0.0)
    if p.actuator.plug_area != 0.0:
        extra += process_force(p.actuator, y[PRESSURE_DROP])
    return stem_force(p.actuator, y[CHAMBER], y[POSITION], y[VELOCITY], extra)


def converter_rate(p: PositionerParameters, time: float, current: float, y) -> float:
    """Return d(back pressure)/dt, Pa/s, at the control current (A) that the converter sees."""
    extra = 0.0
    if p.discrepancy.location == term.EP_CONVERTER:
        extra = discrepancy_at(p.discrepancy, time, current, y, 0.0)
    settled = settled_back_pressure(p.ep_converter, current, y[SUPPLY], time, extra)
    extra = 0.0
    if p.discrepancy.location == term.EP_CONVERTER_LAG:
        extra = interpolate(p.discrepancy, settled - y[BACK])
    return back_pressure_rate(p.ep_converter, y[BACK], settled, extra)


def direct_flow(p: PositionerParameters, time: float, current: float, y) -> float:
    """Return the mass flow converter → chamber, kg/s, where both have one pressure."""
    chamber, ambient = y[CHAMBER], p.supply.temperature
    volume, area, compliance = chamber_space(p, chamber, y[POSITION])
    filling = isothermal_filling(
        p.actuator, chamber, volume, area * y[VELOCITY], compliance,
        converter_rate(p, time, current, y), ambient)
    return filling + leak_flow(p.actuator, chamber, ambient, ambient, 0.0)


def derivatives(
    p: PositionerParameters, time: float, current: float, direction: float, y, rates
) -> None:
    """
    Write the time derivatives of the state `y` into `rates`.

    `current` is the control current in A that the E/P converter sees, `direction` the sign of the
    stem's sliding (0: no dry friction acts). All rates are from the equations of the components.
    """
    ambient = p.supply.temperature
    chamber = y[CHAMBER]
    gas_temperature = y[TEMPERATURE] if p.actuator.thermal_resistance > 0.0 else ambient

    rates[BACK] = converter_rate(p, time, current, y)

    force = booster_force(p, time, current, y)
    _, _, into, out = seat_flows(p, force, y, gas_temperature)
    if is_direct(p):
        into = max(direct_flow(p, time, current, y), 0.0)

    rates[SUPPLY] = 0.0
    if p.supply.droop > 0.0:
        rates[SUPPLY] = supply_pressure_rate(
            p.supply, y[SUPPLY], undrawn_supply(p, time), into)

    rates[OUTLET] = 0.0
    delivered = into - out
    restricted = is_active(p, OUTLET)
    if restricted:
        delivered = tube_flow(p.tubing, y[OUTLET], chamber, ambient, gas_temperature)
        rates[OUTLET] = outlet_pressure_rate(p.tubing, into - out, delivered, ambient)

    extra = 0.0
    if p.discrepancy.location == term.CHAMBER:
        extra = discrepancy_at(p.discrepancy, time, current, y, force)
    leaked = leak_flow(p.actuator, chamber, gas_temperature, ambient, extra)
    volume, area, compliance = chamber_space(p, chamber, y[POSITION])
    swept = area * y[VELOCITY]
    rates[TEMPERATURE] = 0.0
    if is_direct(p):
        rates[CHAMBER] = rates[BACK]
    elif p.actuator.thermal_resistance > 0.0:
        # without a tube both seats open into the chamber, and one may leak while the other flows
        enthalpy = enthalpy_flow(delivered, ambient, gas_temperature) if restricted else (
            enthalpy_flow(into, ambient, gas_temperature)
            - enthalpy_flow(out, gas_temperature, ambient))
        enthalpy -= enthalpy_flow(leaked, gas_temperature, ambient)
        rates[CHAMBER], rates[TEMPERATURE] = energy_rates(
            p.actuator, chamber, gas_temperature, volume, swept, compliance, enthalpy,
            delivered - leaked, ambient)
    else:
        rates[CHAMBER] = isothermal_pressure_rate(
            p.actuator, chamber, volume, swept, compliance, delivered - leaked, ambient)

    rates[PRESSURE_DROP] = 0.0
    rates[PAST] = 0.0
    if forgets(p.discrepancy):
        settled_at = settled_past(p.discrepancy, current, y)
        rates[PAST] = (settled_at - y[PAST]) / p.discrepancy.memory

    friction = 0.0
    if direction != 0.0:
        friction = -direction * sliding_friction(p.actuator, y[POSITION], y[VELOCITY])
    rates[PRESLIDING] = 0.0
    if is_active(p, PRESLIDING):
        rates[PRESLIDING] = presliding_force_rate(
            p.actuator, y[PRESLIDING], y[POSITION], y[VELOCITY])
        friction = -presliding_friction(p.actuator, y[PRESLIDING], rates[PRESLIDING])
    rates[POSITION] = y[VELOCITY]
    rates[VELOCITY] = stem_acceleration(
        p.actuator, net_stem_force(p, time, current, y), friction)


def depends_on_time(p: PositionerParameters) -> bool:
    """Tell whether the equations change with time though the current stands."""
    return (p.supply.ripple != 0.0 or p.ep_converter.drift != 0.0
            or (p.discrepancy.location != term.NONE and p.discrepancy.variable == term.TIME))
