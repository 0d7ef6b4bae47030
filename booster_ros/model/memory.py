# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What is remembered from one interval to the next besides the state, and how all of it starts."""

import math
from typing import NamedTuple

from .ep_converter import play
from .sensors import lagged
from .state import CHAMBER, POSITION
from .sticking import sliding_direction
from .system import PositionerParameters

# In this order: the stem's direction of sliding (0: stuck, or no dry friction), the solver's next
# trial step, how often the present slide has been found stiff, the length of a step ahead (0:
# none), how much of it has passed, the current that it is for, where the E/P converter's play
# stands, the lagged pressure and position, where the play of the position reading stands.
(DIRECTION, TRIAL_STEP, STIFFNESS, STEP_AHEAD, PASSED, STANDING, EP_PLAY, LAGGED_PRESSURE,
 LAGGED_POSITION, POSITION_PLAY) = range(10)
MEMORIES = 10


class Departure(NamedTuple):
    """
    How far from settled and centred a positioner starts, which a command alone does not tell.

    `back_pressure` is how far that is above the settled one, Pa. `ep_play` and `position_play` say
    where in its play the part stands that the current moves, or that the position sensor reads: a
    share of half the width, -1 to 1. `temperature` is how much warmer the chamber's air is than
    its wall, K. `past` is how far what a term remembers is above what it would be after a long
    rest, in the unit of that state (PAST_UNIT: 0.1 mA, 1 bar, 10 mm, 0.1 N).
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


def seen_current(p: PositionerParameters, memory, current: float) -> float:
    """Return the current that the E/P converter acts on, A, and remember where its play stands."""
    if p.ep_converter.hysteresis <= 0.0:
        memory[EP_PLAY] = current  # a hysteresis that is set later begins there
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
