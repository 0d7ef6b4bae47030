# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The wired positioner: which state belongs to which component, and how they act on each other.

The state is a sequence of floats in the order of the indices below. States whose effect is
switched off stand still and cost nothing: the solver integrates the `active_states` only.
"""

import math
from typing import NamedTuple

from . import discrepancy as term
from .actuator import (
    Actuator, breakaway_friction, chamber_volume, diaphragm_area, energy_rates, has_dry_friction,
    is_rigid, isothermal_pressure_rate, leak_flow, presliding_force_rate, presliding_friction,
    sliding_friction, stem_acceleration, stem_force)
from .booster import (
    Booster, diaphragm_force, exhaust_area, exhaust_flow, intake_area, intake_flow)
from .discrepancy import (
    Discrepancy, behind_play, forgets, has_play, interpolate, past_at_rest, remembers, slope)
from .ep_converter import EpConverter, back_pressure_rate, play, settled_back_pressure
from .gas import ATMOSPHERE, carried
from .sensors import Sensors, lagged, position_reading, pressure_reading
from .supply import Supply, set_pressure, supply_pressure_rate
from .tubing import Tubing, outlet_pressure_rate, tube_flow

BACK, SUPPLY, OUTLET, CHAMBER, TEMPERATURE, PAST, POSITION, VELOCITY, PRESLIDING = range(9)
STATES = 9
STATE_NAMES = ('back_pressure', 'supply_pressure', 'outlet_pressure', 'chamber_pressure',
               'gas_temperature', 'past', 'valve_position', 'stem_velocity', 'presliding_force')

# What is remembered from one interval to the next besides the state: the stem's direction of
# sliding (0 stuck or no dry friction), the solver's next trial step, how often the present slide
# has been found stiff, the length of a step that reaches beyond the interval (0 for none) and how
# much of it has passed, the current that it is for, the plays and the sensors.
(DIRECTION, TRIAL_STEP, STIFFNESS, STEP_AHEAD, PASSED, STANDING, EP_PLAY, LAGGED_PRESSURE,
 LAGGED_POSITION, POSITION_PLAY) = range(10)
MEMORIES = 10


# By the variables of a term: the state that each is, or is a change of, -1 where it is none; and
# the unit of the state `past` in which that is of order one, 0 for no past.
STATE_OF_VARIABLE = (
    -1, -1, BACK, SUPPLY, CHAMBER, POSITION, VELOCITY, -1, -1, CHAMBER, POSITION, -1)
PAST_UNIT = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1e-4, 1e5, 1e-2, 0.1)

SMALLEST_VOLUME = 0.05
"""Share of the dead volume that is left whatever is taken off it: a space between solid parts."""

LARGEST_YIELD = 0.5
"""Share of what the gas in it gives way that a chamber may give way less, by a table that falls."""


class PositionerParameters(NamedTuple):
    """All parameters of the positioner, by component."""

    ep_converter: EpConverter = EpConverter()
    booster: Booster = Booster()
    supply: Supply = Supply()
    tubing: Tubing = Tubing()
    actuator: Actuator = Actuator()
    sensors: Sensors = Sensors()
    discrepancy: Discrepancy = Discrepancy()


class Outputs(NamedTuple):
    """What can be seen of the positioner at one moment; units in `OUTPUT_UNITS`."""

    time: float
    control_current: float
    back_pressure: float
    supply_pressure: float
    booster_force: float
    intake_area: float
    exhaust_area: float
    mass_flow: float
    outlet_pressure: float
    chamber_pressure: float
    gas_temperature: float
    valve_position: float
    stem_velocity: float
    measured_chamber_pressure: float
    measured_valve_position: float


OUTPUT_UNITS = dict(zip(Outputs._fields, (
    's', 'A', 'Pa', 'Pa', 'N', 'm^2', 'm^2', 'kg/s', 'Pa', 'Pa', 'K', 'm', 'm/s', 'Pa', 'm')))
"""Units of the outputs; pressures are gauge, mass flow counts from the booster to the chamber."""


def is_active(p: PositionerParameters, state: int) -> bool:
    """Tell whether a state has dynamics of its own under these parameters."""
    if state == SUPPLY:
        return p.supply.droop > 0.0
    if state == OUTLET:
        return p.tubing.restriction_area > 0.0
    if state == TEMPERATURE:
        return p.actuator.thermal_resistance > 0.0
    if state == PAST:
        return forgets(p.discrepancy)
    if state == PRESLIDING:
        return has_dry_friction(p.actuator) and not is_rigid(p.actuator)
    return True


def hold_inactive_states(p: PositionerParameters, time: float, y, pinned) -> None:
    """Put the states that have no dynamics of their own, and are not given, where they belong."""
    if p.supply.droop <= 0.0 and SUPPLY not in pinned:
        y[SUPPLY] = undrawn_supply(p, time)
    if p.tubing.restriction_area <= 0.0:
        y[OUTLET] = y[CHAMBER]
    if p.actuator.thermal_resistance <= 0.0:
        y[TEMPERATURE] = p.supply.temperature
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


def present(table: Discrepancy, time: float, current: float, y, force: float) -> float:
    """Return the variable of a term, of a change what it is one of, as it is now, SI."""
    if table.variable == term.TIME:
        return time
    if table.variable == term.BOOSTER_FORCE:
        return force
    state = STATE_OF_VARIABLE[table.variable]
    return current if state < 0 else y[state]


def settled_past(table: Discrepancy, current: float, y) -> float:
    """Return the state `past` of a term whose variable has been what it is for long."""
    if not forgets(table):
        return 0.0
    return present(table, 0.0, current, y, 0.0) / PAST_UNIT[table.variable]


def discrepancy_at(table: Discrepancy, time: float, current: float, y, force: float) -> float:
    """
    Return the tabulated term, in the unit of the component that it is in (see discrepancy).

    Callers ask first whether it is in theirs: handing the table over costs more than the question,
    and nearly always there is none.
    """
    past = PAST_UNIT[table.variable] * y[PAST]
    if table.variable == term.FORCE_PLAY:
        return behind_play(table, past, force)
    return interpolate(table, present(table, time, current, y, force) - past)


def rest_in_play(p: PositionerParameters, y) -> None:
    """Put what the booster's force moves through a play to where it is at rest, if there is one."""
    if has_play(p.discrepancy):
        y[PAST] = past_at_rest(
            p.discrepancy, undisturbed_force(p, y)) / PAST_UNIT[term.FORCE_PLAY]


def follow_play(p: PositionerParameters, y) -> None:
    """Let what the booster's force moves through a play come along to where it is now."""
    table = p.discrepancy
    if has_play(table):
        unit = PAST_UNIT[term.FORCE_PLAY]
        y[PAST] = play(unit * y[PAST], undisturbed_force(p, y), 2.0 * table.reach) / unit


def undisturbed_force(p: PositionerParameters, y) -> float:
    """Return the force on the booster's stack of diaphragms, N."""
    outlet = y[OUTLET] if p.tubing.restriction_area > 0.0 else y[CHAMBER]
    return diaphragm_force(p.booster, y[BACK], outlet, y[SUPPLY])


def booster_force(p: PositionerParameters, time: float, current: float, y) -> float:
    """Return the force that opens the booster's seats, N."""
    force = undisturbed_force(p, y)
    if p.discrepancy.location == term.BOOSTER:
        force += discrepancy_at(p.discrepancy, time, current, y, force)
    return force


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
            # a table that falls is no chamber that bursts
            most = LARGEST_YIELD * volume / (pressure + ATMOSPHERE)
            compliance = max(slope(table, value), -most)
    least = SMALLEST_VOLUME * p.actuator.dead_volume
    if volume < least:  # it stays so small whatever moves: neither makes nor takes gas
        return least, 0.0, 0.0
    return volume, area, compliance


def net_stem_force(p: PositionerParameters, time: float, current: float, y) -> float:
    """Return the force on the stem except dry friction, N, positive towards open."""
    extra = 0.0
    if p.discrepancy.location == term.STEM:
        extra = discrepancy_at(p.discrepancy, time, current, y, 0.0)
    return stem_force(p.actuator, y[CHAMBER], y[POSITION], y[VELOCITY], extra)


def derivatives(
    p: PositionerParameters, time: float, current: float, direction: float, y, rates
) -> None:
    """
    Write the time derivatives of the state `y` into `rates`.

    `current` is the control current in A that the E/P converter sees, `direction` the sign of the
    stem's sliding (0: no dry friction acts). All from the equations of the components.
    """
    ambient = p.supply.temperature
    chamber = y[CHAMBER]
    gas_temperature = y[TEMPERATURE] if p.actuator.thermal_resistance > 0.0 else ambient

    extra = 0.0
    if p.discrepancy.location == term.EP_CONVERTER:
        extra = discrepancy_at(p.discrepancy, time, current, y, 0.0)
    settled = settled_back_pressure(p.ep_converter, current, y[SUPPLY], time, extra)
    rates[BACK] = back_pressure_rate(p.ep_converter, y[BACK], settled)

    restricted = p.tubing.restriction_area > 0.0
    outlet = y[OUTLET] if restricted else chamber
    outlet_temperature = ambient if restricted else gas_temperature
    force = booster_force(p, time, current, y)
    into = intake_flow(
        p.booster, intake_area(p.booster, force, y[SUPPLY], outlet), y[SUPPLY], outlet,
        ambient, outlet_temperature)
    out = exhaust_flow(
        p.booster, exhaust_area(p.booster, force, outlet), outlet, outlet_temperature, ambient)

    rates[SUPPLY] = 0.0
    if p.supply.droop > 0.0:
        rates[SUPPLY] = supply_pressure_rate(
            p.supply, y[SUPPLY], undrawn_supply(p, time), into)

    rates[OUTLET] = 0.0
    delivered = into - out
    if restricted:
        delivered = tube_flow(p.tubing, outlet, chamber, ambient, gas_temperature)
        rates[OUTLET] = outlet_pressure_rate(p.tubing, into - out, delivered, ambient)

    extra = 0.0
    if p.discrepancy.location == term.CHAMBER:
        extra = discrepancy_at(p.discrepancy, time, current, y, force)
    leaked = leak_flow(p.actuator, chamber, gas_temperature, ambient, extra)
    volume, area, compliance = chamber_space(p, chamber, y[POSITION])
    swept = area * y[VELOCITY]
    rates[TEMPERATURE] = 0.0
    if p.actuator.thermal_resistance > 0.0:
        # without a tube both seats open into the chamber, and one may leak while the other flows
        enthalpy = carried(delivered, ambient, gas_temperature) if restricted else (
            carried(into, ambient, gas_temperature) - carried(out, gas_temperature, ambient))
        enthalpy -= carried(leaked, gas_temperature, ambient)
        rates[CHAMBER], rates[TEMPERATURE] = energy_rates(
            p.actuator, chamber, gas_temperature, volume, swept, compliance, enthalpy,
            delivered - leaked, ambient)
    else:
        rates[CHAMBER] = isothermal_pressure_rate(
            p.actuator, chamber, volume, swept, compliance, delivered - leaked, ambient)

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


def sticks(p: PositionerParameters) -> bool:
    """Tell whether the stem has dry friction without any yield, so that it sticks exactly."""
    return has_dry_friction(p.actuator) and is_rigid(p.actuator)


def held_force(p: PositionerParameters, time: float, current: float, y) -> float:
    """Return the presliding force, N, that keeps a resting stem where it is, as far as it can."""
    most = breakaway_friction(p.actuator, y[POSITION])
    return min(max(net_stem_force(p, time, current, y), -most), most)


def sliding_direction(p: PositionerParameters, y) -> float:
    """Return the direction in which a stem slides that can stick; 0: it is exactly still."""
    return math.copysign(1.0, y[VELOCITY]) if sticks(p) and y[VELOCITY] != 0.0 else 0.0


def dry_friction(p: PositionerParameters, time: float, current: float, direction: float, y
                 ) -> float:
    """Return the force, N, with which rigid friction opposes a stem that slides so or is stuck."""
    if direction == 0.0:
        return held_force(p, time, current, y)
    return direction * sliding_friction(p.actuator, y[POSITION], y[VELOCITY])


def slip_direction(p: PositionerParameters, time: float, current: float, y) -> float:
    """Return the direction in which a stem at rest breaks away, 0 if it stays stuck."""
    force = net_stem_force(p, time, current, y)
    if abs(force) <= breakaway_friction(p.actuator, y[POSITION]):
        return 0.0
    return 1.0 if force > 0.0 else -1.0


def friction_time_scale(p: PositionerParameters, y, rates) -> float:
    """
    Return how long the stem takes, s, to a friction that its present one tells nothing about.

    While stiction fades: to twice the speed. While the stem slows down: to where stiction sets in,
    which is within 2 Stribeck velocities, then to 1 less. An error estimate can miss a peak of
    friction that a longer step jumps over.
    """
    fading = p.actuator.stribeck_velocity
    speed, change = abs(y[VELOCITY]), rates[VELOCITY]
    if p.actuator.stiction == 0.0 or change == 0.0:
        return math.inf
    if y[VELOCITY] * change >= 0.0:
        return max(speed, 0.01 * fading) / abs(change) if speed < 3.0 * fading else math.inf
    return max(speed - 2.0 * fading, fading) / abs(change)


def breakaway_excess(p: PositionerParameters, time: float, current: float, y) -> float:
    """Return by how much the force on a stem at rest exceeds the break-away friction, N."""
    return abs(net_stem_force(p, time, current, y)) - breakaway_friction(
        p.actuator, y[POSITION])


def seen_current(p: PositionerParameters, memory, current: float) -> float:
    """Return the current that the E/P converter acts on, A, and remember its hysteresis."""
    if p.ep_converter.hysteresis <= 0.0:
        memory[EP_PLAY] = current  # from there it goes on once there is one
    else:
        memory[EP_PLAY] = play(memory[EP_PLAY], current, p.ep_converter.hysteresis)
    return memory[EP_PLAY]


def measure(
    p: PositionerParameters, memory, before: tuple[float, float], y, step: float
) -> None:
    """
    Let the sensors follow over an interval of `step` s.

    `before` is (chamber pressure, valve position) at its start, `y` the state at its end.
    """
    memory[LAGGED_PRESSURE] = lagged(
        memory[LAGGED_PRESSURE], before[0], y[CHAMBER], p.sensors.pressure_lag, step)
    start = memory[POSITION_PLAY]
    memory[POSITION_PLAY] = play(start, y[POSITION], p.sensors.position_backlash)
    memory[LAGGED_POSITION] = lagged(
        memory[LAGGED_POSITION], start, memory[POSITION_PLAY], p.sensors.position_lag, step)


class Departure(NamedTuple):
    """
    How far from settled and centred a positioner starts, of which a command alone tells nothing.

    `back_pressure` in Pa; `ep_play` and `position_play` say where in its play the current's and the
    position reading's part stands: share of half the width, -1 to 1; `temperature` in K, by which
    the chamber's air is warmer than its wall; `past` by how much what a term remembers is above
    what is, in the unit of that state (PAST_UNIT: 0.1 mA, 1 bar, 10 mm, 0.1 N).
    """

    back_pressure: float = 0.0
    ep_play: float = 0.0
    position_play: float = 0.0
    temperature: float = 0.0
    past: float = 0.0


CENTRED = Departure()


def start_current(p: PositionerParameters, current: float, departure: Departure) -> float:
    """Return the current that the E/P converter acts on at the start, A."""
    return current + 0.5 * p.ep_converter.hysteresis * departure.ep_play


def start_memory(p: PositionerParameters, current: float, y, first_step: float, memory,
                 departure: Departure = CENTRED) -> None:
    """Fill the memory for a positioner that has been in state `y` for long."""
    memory[DIRECTION] = sliding_direction(p, y)
    memory[TRIAL_STEP] = first_step
    memory[STIFFNESS] = 0.0
    memory[STEP_AHEAD] = 0.0
    memory[PASSED] = 0.0
    memory[STANDING] = math.nan
    memory[EP_PLAY] = start_current(p, current, departure)
    memory[LAGGED_PRESSURE] = y[CHAMBER]
    memory[POSITION_PLAY] = y[POSITION] + (
        0.5 * p.sensors.position_backlash * departure.position_play)
    memory[LAGGED_POSITION] = memory[POSITION_PLAY]


def readings(
    p: PositionerParameters, time: float, seen: float, y, memory, force: float
) -> tuple[float, float]:
    """Return what the sensors read: Pa gauge, m; `force` is the booster's, N."""
    pressure = pressure_reading(p.sensors, memory[LAGGED_PRESSURE])
    position = position_reading(p.sensors, memory[LAGGED_POSITION])
    if p.discrepancy.location == term.PRESSURE_SENSOR:
        pressure += discrepancy_at(p.discrepancy, time, seen, y, force)
    if p.discrepancy.location == term.POSITION_SENSOR:
        position += discrepancy_at(p.discrepancy, time, seen, y, force)
    return pressure, position


def observe(
    p: PositionerParameters, time: float, current: float, seen: float, y, memory
) -> Outputs:
    """
    Return everything that can be seen of the state `y` at `time`.

    `current` is the commanded, `seen` the current that the E/P converter acts on, A.
    """
    ambient = p.supply.temperature
    chamber = y[CHAMBER]
    restricted = p.tubing.restriction_area > 0.0
    outlet = y[OUTLET] if restricted else chamber
    outlet_temperature = ambient if restricted else y[TEMPERATURE]
    force = booster_force(p, time, seen, y)
    opened_in = intake_area(p.booster, force, y[SUPPLY], outlet)
    opened_out = exhaust_area(p.booster, force, outlet)
    flow = intake_flow(
        p.booster, opened_in, y[SUPPLY], outlet, ambient, outlet_temperature
    ) - exhaust_flow(p.booster, opened_out, outlet, outlet_temperature, ambient)
    pressure, position = readings(p, time, seen, y, memory, force)
    return Outputs(
        time, current, y[BACK], y[SUPPLY], force, opened_in, opened_out, flow, outlet, chamber,
        y[TEMPERATURE], y[POSITION], y[VELOCITY], pressure, position)
