# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The whole valve, stepped through time."""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from . import booster as relay
from . import chamber as gas_space
from . import converter as nozzle
from . import positioner as electronics
from . import stem as spindle
from .gas import ATMOSPHERE, mass_flow
from .supply import Supply, regulated_pressure

SAMPLE_TIME = 0.01  # s, of records
STEP = 20e-6  # s
STEPS_PER_SAMPLE = round(SAMPLE_TIME / STEP)
OTHER_ORIFICES = 0.5283  # critical pressure ratio of line and leaks, whatever the seats have
SLIP_STEPS = 10  # of a stem that sticks, in a STEP: it breaks away within 10 µs
COLUMNS = (
    'back_pressure',  # Pa gauge
    'supply_pressure',
    'outlet_pressure',
    'chamber_pressure',
    'gas_temperature',  # K
    'valve_position',  # m
    'stem_velocity',  # m/s
    'stored_mass',  # kg, in chamber and line
    'supplied_mass',  # kg, since the beginning of the run
    'released_mass',
)


class Valve(NamedTuple):
    """A complete plant; sensors are apart, because nothing in the valve depends on them."""

    converter: nozzle.Converter = nozzle.Converter()
    booster: relay.Booster = relay.Booster()
    supply: Supply = Supply()
    line: gas_space.Line = gas_space.Line()
    chamber: gas_space.Chamber = gas_space.Chamber()
    stem: spindle.Stem = spindle.Stem()
    positioner: electronics.Positioner = electronics.Positioner()


@njit(cache=True)
def balance(valve, current):
    """Return back pressure, chamber pressure and position at which the undisturbed valve rests."""
    booster, stem = valve.booster, valve.stem
    supply = valve.supply.pressure
    back = nozzle.settled_back_pressure(valve.converter, current, current, 0.0, supply)
    bias = relay.diaphragm_force(booster, back, 0.0, supply)
    pressure = min(max(bias / booster.s3, 0.0), supply)
    lift = (valve.chamber.area * pressure - stem.preload) / stem.spring_rate
    return back, pressure, min(max(lift, 0.0), stem.travel)


@njit(cache=True)
def run(valve, currents, start_time):
    """
    Step the plant through currents (A, one per sample) from the balance at the first of them.

    With a positioner they are set points (m), and it begins at the balance at its middle current.

    Returns an array with one row per sample, taken as its current is applied, and COLUMNS. The
    effects' clock reads start_time (s) at the first sample.
    """
    converter, booster, supply = valve.converter, valve.booster, valve.supply
    line, chamber, stem = valve.line, valve.chamber, valve.stem
    has_line = line.resistance > 0.0 or line.laminar_resistance > 0.0
    isothermal = chamber.wall_resistance == 0.0
    wall = supply.temperature
    critical = booster.critical_ratio
    yields = stem.coulomb > 0.0 and stem.packing_stiffness > 0.0
    stem_steps = SLIP_STEPS if stem.stiction > 0.0 or yields else 1

    positioner = valve.positioner
    is_loop = positioner.kind != electronics.NONE
    flapper = positioner.middle if is_loop else currents[0]
    late_flapper = flapper
    back, gauge, x = balance(valve, flapper)
    v = 0.0
    deflection = 0.0
    relaxed_x = x
    supply_pressure = supply.pressure
    spool = 0.0
    temperature = wall
    volume = gas_space.gas_volume(chamber, x)
    mass = gas_space.ambient_mass(volume, wall) * (gauge + ATMOSPHERE) / ATMOSPHERE
    line_mass = gas_space.ambient_mass(line.volume, wall) * (gauge + ATMOSPHERE) / ATMOSPHERE
    supplied = 0.0
    released = 0.0

    filling_share = -math.expm1(-STEP / converter.time_constant)
    venting_share = -math.expm1(-STEP / converter.time_constant / (1.0 + converter.slow_venting))
    late_share = -math.expm1(-STEP / converter.creep_time)
    regulator_share = -math.expm1(-STEP / supply.regulator_time)
    relax_share = -math.expm1(-STEP / stem.creep_time)
    delay = round(converter.dead_time / STEP)
    memory = electronics.begun(positioner, currents[0], x)
    sent, slope, lasts = flapper, 0.0, 0.0

    rows = np.empty((currents.size, len(COLUMNS)))
    for step in range((currents.size - 1) * STEPS_PER_SAMPLE + 1):
        time = start_time + step * STEP
        pressure = gas_space.absolute_pressure(mass, temperature, volume)
        outlet = gas_space.absolute_pressure(line_mass, wall, line.volume) if has_line else pressure
        outlet_temperature = wall if has_line else temperature
        gauge = pressure - ATMOSPHERE
        if step % STEPS_PER_SAMPLE == 0:
            row = rows[step // STEPS_PER_SAMPLE]
            row[0], row[1], row[2], row[3] = back, supply_pressure, outlet - ATMOSPHERE, gauge
            row[4], row[5], row[6] = temperature, x, v
            row[7] = mass + (line_mass if has_line else 0.0)
            row[8], row[9] = supplied, released

        # E/P converter
        current = currents[max(step - delay, 0) // STEPS_PER_SAMPLE]
        if is_loop:
            if step % STEPS_PER_SAMPLE == 0:
                memory, sent, slope, lasts = electronics.decide(
                    positioner, memory, sent, currents[step // STEPS_PER_SAMPLE], x, stem.travel)
            if lasts > 0.0:
                sent = min(max(sent + slope * min(STEP, lasts), 0.0), positioner.highest)
                lasts -= STEP
            current = sent
        flapper = nozzle.play(flapper, current, converter.hysteresis)
        late_flapper += late_share * (flapper - late_flapper)
        back_target = nozzle.settled_back_pressure(
            converter, flapper, late_flapper, time, supply_pressure
        )

        # booster
        force = relay.diaphragm_force(booster, back, outlet - ATMOSPHERE, supply_pressure)
        spool = relay.spool_force(booster, spool, force, time)
        supply_absolute = supply_pressure + ATMOSPHERE
        intake = relay.intake_area(booster, spool, supply_absolute - outlet)
        exhaust = relay.exhaust_area(booster, spool, outlet - ATMOSPHERE)
        inflow = mass_flow(
            intake + booster.supply_leak,
            supply_absolute, supply.temperature, outlet, outlet_temperature, critical,
        )  # fmt: skip
        exhausted = mass_flow(
            exhaust + booster.exhaust_leak,
            outlet, outlet_temperature, ATMOSPHERE, supply.temperature, critical,
        )  # fmt: skip

        # line and chamber
        leaked = mass_flow(
            gas_space.leak_area(chamber, gauge, x, time),
            pressure, temperature, ATMOSPHERE, supply.temperature, OTHER_ORIFICES,
        )  # fmt: skip
        through = inflow - exhausted
        if has_line:
            through = gas_space.line_flow(
                line, outlet, wall, pressure, temperature, OTHER_ORIFICES
            )
            line_mass += STEP * (inflow - exhausted - through)
        entering = max(through, 0.0)
        leaving = max(-through, 0.0) + leaked

        # stem
        for _ in range(stem_steps):
            pull = (
                gas_space.diaphragm_area(chamber, x) * gauge
                - spindle.spring_force(stem, x, relaxed_x)
                - spindle.fluid_force(stem, x)
                + spindle.stop_force(stem, x, v)
            )
            if yields:
                v, deflection = spindle.next_velocity_yielding(
                    stem, x, v, deflection, pull, gauge, STEP / stem_steps
                )
            else:
                v = spindle.next_velocity(stem, x, v, pull, gauge, STEP / stem_steps)
            x += STEP / stem_steps * v
        relaxed_x += relax_share * (x - relaxed_x)

        volume_before, volume = volume, gas_space.gas_volume(chamber, x)
        if not isothermal:
            temperature += STEP * gas_space.warming(
                chamber, mass, temperature, wall, entering, supply.temperature, leaving,
                pressure * (volume - volume_before) / STEP,
            )  # fmt: skip
        mass += STEP * (entering - leaving)
        supplied += STEP * inflow
        released += STEP * (exhausted + leaked)
        supply_pressure += regulator_share * (
            regulated_pressure(supply, inflow, time) - supply_pressure
        )
        back += (filling_share if back_target > back else venting_share) * (back_target - back)
    return rows
