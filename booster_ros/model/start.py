# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The state in which a positioner starts, seen through its sensors.

Readings are not the state where a sensor is biased, its linkage has play, or the E/P converter
has hysteresis: what they leave open is taken so that nothing moves, or as little as can be.
"""

from collections.abc import Callable, Mapping

from .actuator import balance_position
from .sensors import position_behind, pressure_behind
from .stream import settled_state
from .system import CHAMBER, STATES, Departure, PositionerParameters, derivatives, start_current

BISECTIONS = 30
"""Halvings of a play in search of a place in it: to a billionth of its width."""


def start_of_readings(
    p: PositionerParameters, time: float, current: float, readings: Mapping[str, float]
) -> tuple[dict[str, float], Departure]:
    """
    Return the initial state and the departure from settled for `Stream` to start from.

    `readings` may have chamber_pressure (Pa gauge) and valve_position (m) at `time` (s), when the
    control current is `current` (A).

    1. Bias and span error of the sensors are taken off.
    2. Of all positions in which a linkage with play may show this reading the stem has that nearest
       to where spring and pressure balance.
    3. In its hysteresis the E/P converter has the place nearest to the middle at which the chamber
       neither fills nor empties: after a rise of the current it is at the lower end.
    """
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
            balance = balance_position(p.actuator, pressure)
            stem = state['valve_position'] = min(max(balance, shown - half), shown + half)
            position_play = (shown - stem) / half
        if p.ep_converter.hysteresis > 0.0:
            ep_play = _place_at_rest(_filling(p, time, current, state))
    return state, Departure(ep_play=ep_play, position_play=position_play)


def _filling(p: PositionerParameters, time: float, current: float, state: Mapping[str, float]
             ) -> Callable[[float], float]:
    """Return how fast the chamber fills, Pa/s, by the place in the E/P converter's play."""
    # what a tube and heat do to a chamber at rest is nothing
    still = p._replace(tubing=p.tubing._replace(restriction_area=0.0),
                       actuator=p.actuator._replace(thermal_resistance=0.0))

    def filling(place: float) -> float:
        seen = start_current(p, current, Departure(ep_play=place))
        y = settled_state(still, seen, state['chamber_pressure'], state.get('valve_position'), time)
        rates = [0.0] * STATES
        derivatives(still, time, seen, 0.0, y, rates)
        return rates[CHAMBER]

    return filling


def _place_at_rest(filling: Callable[[float], float]) -> float:
    """Return the place from -1 to 1, nearest to the middle, at which `filling` is least."""
    middle = filling(0.0)
    if middle == 0.0:
        return 0.0
    moves, rests = 0.0, -1.0 if middle > 0.0 else 1.0
    if filling(rests) * middle > 0.0:
        return rests
    for _ in range(BISECTIONS):
        half = 0.5 * (moves + rests)
        if filling(half) * middle > 0.0:
            moves = half
        else:
            rests = half
    return rests
