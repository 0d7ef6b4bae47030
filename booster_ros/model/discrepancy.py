# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
What a record showed beyond the named effects: a tabulated term in one component.

The table is piecewise linear over one variable and zero outside the range that the record covered.
"""

from typing import Annotated, NamedTuple

from .quantity import Quantity

LOCATIONS = ('none', 'ep_converter', 'booster', 'supply', 'chamber', 'stem', 'pressure_sensor',
             'position_sensor')
LOCATION_UNITS = ('-', 'Pa', 'N', 'Pa', 'kg/s', 'N', 'Pa', 'm')
NONE, EP_CONVERTER, BOOSTER, SUPPLY, CHAMBER, STEM, PRESSURE_SENSOR, POSITION_SENSOR = range(8)

VARIABLES = ('time', 'control_current', 'back_pressure', 'supply_pressure', 'chamber_pressure',
             'valve_position', 'stem_velocity', 'booster_force')
VARIABLE_UNITS = ('s', 'A', 'Pa', 'Pa', 'Pa', 'm', 'm/s', 'N')
TIME, CONTROL_CURRENT, BACK_PRESSURE, SUPPLY_PRESSURE, CHAMBER_PRESSURE, VALVE_POSITION, \
    STEM_VELOCITY, BOOSTER_FORCE = range(8)

KNOTS = 12


class Discrepancy(NamedTuple):
    """A table of `KNOTS` values at equal distances from `low` to `high`."""

    location: Annotated[int, Quantity('-', 'component that the term enters: ' + ', '.join(
        LOCATIONS))] = NONE
    variable: Annotated[int, Quantity('-', 'what the term depends on: ' + ', '.join(
        VARIABLES))] = TIME
    low: Annotated[float, Quantity(
        'unit of the variable', 'variable at the first value')] = 0.0
    high: Annotated[float, Quantity(
        'unit of the variable', 'variable at the last value')] = 1.0
    values: Annotated[tuple[float, ...], Quantity(
        'Pa (ep_converter, supply, pressure_sensor), N (booster, stem), kg/s (chamber), '
        'm (position_sensor)', f'the term at {KNOTS} equidistant values of the variable',
    )] = (0.0,) * KNOTS


def can_depend(location: int, variable: int) -> bool:
    """
    Tell whether the term of a component can follow a variable.

    The supply knows the time alone; the booster's force is no input of converter and stem.
    """
    if location == SUPPLY:
        return variable == TIME
    return variable != BOOSTER_FORCE or location not in (EP_CONVERTER, STEM)


def interpolate(table: Discrepancy, value: float) -> float:
    """Return the term at `value`, in the unit of the table's location; zero outside."""
    place = (value - table.low) / (table.high - table.low) * (KNOTS - 1)
    if not 0.0 <= place <= KNOTS - 1:  # also where the value is no number
        return 0.0
    left = min(int(place), KNOTS - 2)
    share = place - left
    return table.values[left] * (1.0 - share) + table.values[left + 1] * share
