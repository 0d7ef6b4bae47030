# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
What a record showed beyond the named effects: a tabulated term in one component.

The table is piecewise linear between its knots. The second knot and the last but one are the ends
of what the record covered; beyond them the term fades to the outermost values, then it is zero.

A term over the place of the booster's force in a play (friction of a relay) contains the play
itself; the table adds to it.
"""

import math
from typing import Annotated, NamedTuple

from .ep_converter import play
from .quantity import Quantity

LOCATIONS = ('none', 'ep_converter', 'booster', 'supply', 'chamber', 'stem', 'pressure_sensor',
             'position_sensor', 'chamber_volume', 'ep_converter_lag')
LOCATION_UNITS = ('-', 'Pa', 'N', 'Pa', 'kg/s', 'N', 'Pa', 'm', 'm^3', '-')
NONE, EP_CONVERTER, BOOSTER, SUPPLY, CHAMBER, STEM, PRESSURE_SENSOR, POSITION_SENSOR, \
    CHAMBER_VOLUME, EP_CONVERTER_LAG = range(10)

# Variables with a past come last: compiled code tells them by number (`remembers`, `forgets`).
VARIABLES = ('time', 'control_current', 'back_pressure', 'supply_pressure', 'chamber_pressure',
             'valve_position', 'stem_velocity', 'booster_force', 'back_pressure_error',
             'control_current_change', 'chamber_pressure_change', 'valve_position_change',
             'booster_force_play')
VARIABLE_UNITS = ('s', 'A', 'Pa', 'Pa', 'Pa', 'm', 'm/s', 'N', 'Pa', 'A', 'Pa', 'm', '-')
TIME, CONTROL_CURRENT, BACK_PRESSURE, SUPPLY_PRESSURE, CHAMBER_PRESSURE, VALVE_POSITION, \
    STEM_VELOCITY, BOOSTER_FORCE, BACK_PRESSURE_ERROR, CURRENT_CHANGE, PRESSURE_CHANGE, \
    POSITION_CHANGE, FORCE_PLAY = range(13)

CHANGE_OF = {CURRENT_CHANGE: CONTROL_CURRENT, PRESSURE_CHANGE: CHAMBER_PRESSURE,
             POSITION_CHANGE: VALVE_POSITION}
"""The variable whose change each of these is."""

KNOTS = 12

PLACES = 200
"""Steps across a play in which the place at rest is looked for."""


class Discrepancy(NamedTuple):
    """A table of `KNOTS` values of a term, and of the variable that it depends on."""

    location: Annotated[int, Quantity('-', 'component that the term enters: ' + ', '.join(
        LOCATIONS))] = NONE
    variable: Annotated[int, Quantity('-', 'what the term depends on: ' + ', '.join(
        VARIABLES))] = TIME
    knots: Annotated[tuple[float, ...], Quantity(
        'unit of the variable', f'the variable where the term has its {KNOTS} values; must rise',
    )] = tuple(map(float, range(KNOTS)))
    values: Annotated[tuple[float, ...], Quantity(
        'Pa (ep_converter, supply, pressure_sensor), N (booster, stem), kg/s (chamber), '
        'm (position_sensor), m^3 (chamber_volume), - (ep_converter_lag: natural logarithm of '
        'how many times as slow)',
        f'the term at {KNOTS} values of the variable',
    )] = (0.0,) * KNOTS
    memory: Annotated[float, Quantity(
        's', 'of a change, else ignored: time in which 63 % of what was is forgotten',
        1e-2, 1e6)] = 10.0
    reach: Annotated[float, Quantity(
        'N', 'of a play of the force, beside the table, else ignored: half its width',
        1e-6, 10.0)] = 0.01


def remembers(table: Discrepancy) -> bool:
    """Tell whether the term depends on the past."""
    return table.location != NONE and table.variable >= CURRENT_CHANGE


def forgets(table: Discrepancy) -> bool:
    """Tell whether the term follows a recent change, whose past is forgotten in time."""
    return remembers(table) and not has_play(table)


def has_play(table: Discrepancy) -> bool:
    """Tell whether the term follows the place of the booster's force in a play."""
    return table.location != NONE and table.variable == FORCE_PLAY


def can_depend(location: int, variable: int) -> bool:
    """
    Tell whether the term of a component can follow a variable.

    A term of the supply can follow time alone, one of the chamber's volume only position or
    pressure, one of the converter's lag only how far the back pressure still has to go, its error,
    which no other term can follow. The booster's force is no input of converter and stem, and has a
    play in the booster only.
    """
    if location == SUPPLY:
        return variable == TIME
    if location == EP_CONVERTER_LAG or variable == BACK_PRESSURE_ERROR:
        return location == EP_CONVERTER_LAG and variable == BACK_PRESSURE_ERROR
    if location == CHAMBER_VOLUME:
        return variable in (CHAMBER_PRESSURE, VALVE_POSITION)
    if variable == FORCE_PLAY:
        return location == BOOSTER
    return variable != BOOSTER_FORCE or location not in (EP_CONVERTER, STEM)


def covered(table: Discrepancy) -> tuple[float, float]:
    """Return the variable at the second value and at the last but one."""
    return table.knots[1], table.knots[-2]


def interpolate(table: Discrepancy, value: float) -> float:
    """Return the term at `value`, in the unit of the table's location; zero outside."""
    if not table.knots[0] <= value <= table.knots[-1]:  # also where the value is no number
        return 0.0
    left = _knot_below(table, value)
    share = (value - table.knots[left]) / (table.knots[left + 1] - table.knots[left])
    return table.values[left] * (1.0 - share) + table.values[left + 1] * share


def slope(table: Discrepancy, value: float) -> float:
    """Return the slope of the term over its variable at `value`; zero outside."""
    if not table.knots[0] <= value <= table.knots[-1]:
        return 0.0
    left = _knot_below(table, value)
    return (table.values[left + 1] - table.values[left]) / (
        table.knots[left + 1] - table.knots[left])


def _knot_below(table: Discrepancy, value: float) -> int:
    """Return the index of the knot at or below a value within the table, the last one excepted."""
    left = KNOTS - 2
    while table.knots[left] > value:
        left -= 1
    return left


def place_in_play(table: Discrepancy, past: float, force: float) -> float:
    """Return the place, -1 to 1, of a force (N) in its play; what it moves stood at `past` (N)."""
    return (force - play(past, force, 2.0 * table.reach)) / table.reach


def behind_play(table: Discrepancy, past: float, force: float) -> float:
    """Return what to add to a force (N) to get what opens the seats, behind its play, N."""
    place = place_in_play(table, past, force)
    return interpolate(table, place) - table.reach * place


def past_at_rest(table: Discrepancy, force: float) -> float:
    """
    Return the position at rest, N, of what a force (N) moves through a play.

    A booster rests with both seats shut, or as nearly shut as the play has room for.
    """
    least, at_rest = math.inf, force
    for k in range(PLACES + 1):
        place = 2.0 * k / PLACES - 1.0
        moved = force - table.reach * place
        opening = abs(moved + interpolate(table, place))
        if opening < least:
            least, at_rest = opening, moved
    return at_rest
