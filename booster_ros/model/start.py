# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The state in which a positioner starts, seen through its sensors.

Readings are not the state where a sensor is biased or has a term, its linkage has play, or the E/P
converter has hysteresis. What they leave open is chosen so that nothing moves, or as little as can
be.
"""

from collections.abc import Callable, Mapping

from .actuator import (
    balance_position, breakaway_friction, has_dry_friction, is_in_a_stop, lower_stop,
    process_force, stem_force, upper_stop)
from .booster import NO_BOOSTER
from .discrepancy import POSITION_SENSOR, PRESSURE_SENSOR
from .memory import Departure, start_current
from .sensors import position_behind, pressure_behind
from .state import CHAMBER, POSITION, STATES
from .sticking import breakaway_excess
from .stream import settled_state
from .system import PositionerParameters, booster_force, derivatives, discrepancy_at

Start = tuple[dict[str, float], Departure]
"""An initial state, by name, and how far from settled and centred it is."""

READING_WITH_TERM = {PRESSURE_SENSOR: 'chamber_pressure', POSITION_SENSOR: 'valve_position'}
"""The reading that contains a term, by the location of the term."""

BISECTIONS = 30
"""Halvings in the search for a place in a play or a term: to a billionth of its width."""

UNSURE = 0.01
"""Share of the travel by which readings of pressure and position may miss the stem's balance."""


def start_of_readings(
    p: PositionerParameters, time: float, current: float, readings: Mapping[str, float]
) -> Start:
    """
    Return the initial state and the departure from settled for `Stream` to start from.

    `readings` may have chamber_pressure (Pa gauge) and valve_position (m) at `time` (s), when the
    control current is `current` (A).

    1. Bias, span error and term of the sensors are taken off.
    2. Of all positions at which a linkage with play may show this reading, the stem has the one
       nearest to where the forces on it balance.
    3. A stem that rests on a stop (`rests_on_a_stop`) stands where the stop holds it. Where
       friction would hold it within `UNSURE` of where it is read, it is held: it has the nearest
       position at which friction holds it. A stem further off moves.
    4. In its hysteresis the E/P converter has the place nearest to the middle at which the chamber
       neither fills nor empties: after a rise of the current it is at the lower end.
    """
    return _start_without_term(p, time, current, _term_taken_off(p, time, current, readings))


def rests_on_a_stop(
    p: PositionerParameters, pressure: float, read: float, pressure_drop: float = 0.0
) -> bool:
    """
    Tell whether a stem that is read here (m), at this pressure (Pa), rests on a stop.

    `pressure_drop` is that over the process valve, Pa.

    Friction alone could not hold it off the stop then, and within the stop no reading tells what
    friction holds: a micrometre is hundreds of newtons. It is taken to hold nothing. Noise in a
    reading would load a packing that yields to its limit, one way or the other, and the stem would
    next break away as it does only after it has turned or gone on.
    """
    act = p.actuator
    pushed = process_force(act, pressure_drop)
    balance = balance_position(act, pressure, lambda position: pushed)
    if not is_in_a_stop(act, balance) or abs(balance - read) > UNSURE * act.travel:
        return False
    edge = lower_stop(act) if balance < lower_stop(act) else upper_stop(act)
    return abs(stem_force(act, pressure, edge, 0.0, pushed)) > breakaway_friction(act, edge)


def friction_holds(
    p: PositionerParameters, pressure: float, read: float, pressure_drop: float = 0.0
) -> bool:
    """Tell whether it is dry friction, and no stop, that holds a stem which is read here (m)."""
    return has_dry_friction(p.actuator) and not rests_on_a_stop(p, pressure, read, pressure_drop)


def _term_taken_off(
    p: PositionerParameters, time: float, current: float, readings: Mapping[str, float]
) -> dict[str, float]:
    """Return the readings without the term, which may itself depend on the state behind them."""
    name = READING_WITH_TERM.get(p.discrepancy.location, '')
    if name not in readings:
        return dict(readings)
    read = readings[name]

    def term(reading: float) -> float:
        state, departure = _start_without_term(p, time, current, {**readings, name: reading})
        seen = start_current(p, current, departure)
        y = settled_state(
            p, seen, state.get('chamber_pressure', 0.0), state.get('valve_position'), time)
        return discrepancy_at(p.discrepancy, time, seen, y, booster_force(p, time, seen, y))

    least, most = min(*p.discrepancy.values, 0.0), max(*p.discrepancy.values, 0.0)
    nearly = _nearest(lambda reading: reading + term(reading) < read, read - most, read - least)
    return {**readings, name: read - term(nearly)}  # a constant term is taken off to the last bit


def _start_without_term(
    p: PositionerParameters, time: float, current: float, readings: Mapping[str, float]
) -> Start:
    """Return the start that readings without a term tell."""
    sensors = p.sensors
    state: dict[str, float] = {}
    position_play = ep_play = 0.0
    if 'valve_position' in readings:
        state['valve_position'] = position_behind(sensors, readings['valve_position'])
    if 'chamber_pressure' in readings:
        pressure = pressure_behind(sensors, readings['chamber_pressure'])
        state['chamber_pressure'] = pressure
        if 'valve_position' in state and sensors.position_backlash > 0.0:
            half, shown = 0.5 * sensors.position_backlash, state['valve_position']
            balance = _balance(p, time, current, pressure)
            stem = state['valve_position'] = min(max(balance, shown - half), shown + half)
            position_play = (shown - stem) / half
        if 'valve_position' in state:
            state['valve_position'] = _held_position(p, time, current, state)
        if p.ep_converter.hysteresis > 0.0:
            ep_play = _place_at_rest(_filling(p, time, current, state))
    return state, Departure(ep_play=ep_play, position_play=position_play)


def _balance(
    p: PositionerParameters, time: float, current: float, pressure: float,
    pressure_drop: float = 0.0,
) -> float:
    """Return the position, m, at which the forces on the stem balance, friction aside."""
    seen = start_current(p, current, Departure())
    return settled_state(p, seen, pressure, None, time, pressure_drop)[POSITION]


def held_by_friction(
    p: PositionerParameters, time: float, current: float, state: Mapping[str, float]
) -> float | None:
    """
    Return the position, m, nearest to that which is read at which friction holds the stem.

    It is the one that is read where friction holds it nowhere near, and None where a stop holds it
    or nothing rubs. `state` has chamber_pressure (Pa gauge), valve_position (m) and, where it is
    known, pressure_drop (Pa) at `time` (s), when the control current is `current` (A).
    """
    pressure, read = state['chamber_pressure'], state['valve_position']
    drop = state.get('pressure_drop', 0.0)
    if not friction_holds(p, pressure, read, drop):
        return None
    seen = start_current(p, current, Departure())

    def breaks_away(position: float) -> bool:
        y = settled_state(p, seen, pressure, position, time, drop)
        y[CHAMBER] = pressure  # where nothing is between it and the converter, which may move
        return breakaway_excess(p, time, seen, y) > 0.0

    near = UNSURE * p.actuator.travel
    rests = min(max(_balance(p, time, current, pressure, drop), read - near), read + near)
    held = breaks_away(read) and not breaks_away(rests)
    return _nearest(breaks_away, read, rests) if held else read


def _held_position(
    p: PositionerParameters, time: float, current: float, state: Mapping[str, float]
) -> float:
    """Return the position, m, at which the stem is held, or that which is read if none is near."""
    held, read = held_by_friction(p, time, current, state), state['valve_position']
    if held is not None:
        return held
    balance = _balance(p, time, current, state['chamber_pressure'])
    at_stop = not lower_stop(p.actuator) < balance < upper_stop(p.actuator)
    return balance if at_stop and abs(balance - read) <= UNSURE * p.actuator.travel else read


def _filling(p: PositionerParameters, time: float, current: float, state: Mapping[str, float]
             ) -> Callable[[float], float]:
    """Return the chamber's rate of filling, Pa/s, by the place in the E/P converter's play."""
    # a tube and heat do nothing to a chamber at rest
    still = p._replace(actuator=p.actuator._replace(thermal_resistance=0.0))
    if p.booster.kind != NO_BOOSTER:
        still = still._replace(tubing=p.tubing._replace(restriction_area=0.0))

    def filling(place: float) -> float:
        seen = start_current(p, current, Departure(ep_play=place))
        y = settled_state(still, seen, state['chamber_pressure'], state.get('valve_position'), time)
        rates = [0.0] * STATES
        derivatives(still, time, seen, 0.0, y, rates)
        return rates[CHAMBER]

    return filling


def _place_at_rest(filling: Callable[[float], float]) -> float:
    """Return the place from -1 to 1, nearest to the middle, at which `filling` is nearest to 0."""
    middle = filling(0.0)
    if middle == 0.0:
        return 0.0
    rests = -1.0 if middle > 0.0 else 1.0
    if filling(rests) * middle > 0.0:
        return rests
    return _nearest(lambda place: filling(place) * middle > 0.0, 0.0, rests)


def _nearest(moving: Callable[[float], bool], moves: float, rests: float) -> float:
    """Return the place nearest to `moves`, on the way to `rests`, where `moving` is false."""
    for _ in range(BISECTIONS):
        half = 0.5 * (moves + rests)
        if moving(half):
            moves = half
        else:
            rests = half
    return rests
