# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What can be seen of a positioner at one moment."""

from typing import NamedTuple

from . import discrepancy as term
from .memory import LAGGED_POSITION, LAGGED_PRESSURE
from .sensors import position_reading, pressure_reading
from .state import BACK, CHAMBER, POSITION, SUPPLY, TEMPERATURE, VELOCITY
from .system import (
    PositionerParameters, booster_force, direct_flow, discrepancy_at, is_direct, outlet_pressure,
    seat_flows)


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
    force = booster_force(p, time, seen, y)
    opened_in, opened_out, into, out = seat_flows(p, force, y, y[TEMPERATURE])
    if is_direct(p):
        into = direct_flow(p, time, seen, y)
    pressure, position = readings(p, time, seen, y, memory, force)
    return Outputs(
        time, current, y[BACK], y[SUPPLY], force, opened_in, opened_out, into - out,
        outlet_pressure(p, y), y[CHAMBER], y[TEMPERATURE], y[POSITION], y[VELOCITY], pressure,
        position)
