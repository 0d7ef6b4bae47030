# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What holds a stem where it is: the pressure, and the current that a controller sends for it."""

from .actuator import diaphragm_area, process_force, stem_force
from .discrepancy import EP_CONVERTER
from .ep_converter import settled_back_pressure
from .state import BACK, CHAMBER, OUTLET, STATES, SUPPLY, VELOCITY
from .system import PositionerParameters, derivatives, discrepancy_at

BISECTIONS = 50
"""Halvings of the controller's current limits."""


def holding_pressure(p: PositionerParameters, position: float, pressure_drop: float) -> float:
    """
    Return the chamber pressure, Pa gauge, at which the stem stands at `position` (m).

    Friction, stops and a term without a name aside; between 0 and the supply pressure.
    """
    place = min(max(position, 0.0), p.actuator.travel)
    closing = -stem_force(
        p.actuator, 0.0, place, 0.0, process_force(p.actuator, pressure_drop))
    return min(max(closing / diaphragm_area(p.actuator, place), 0.0), p.supply.pressure)


def holding_current(p: PositionerParameters, time: float, state) -> float:
    """
    Return the current, A, at which the chamber neither fills nor empties.

    Within the controller's limits; `state` is that of a stem at rest. Bisection: valves, leaks and
    converter need have no inverse.
    """
    # a tube and heat do nothing to a chamber at rest
    still = p._replace(tubing=p.tubing._replace(restriction_area=0.0),
                       actuator=p.actuator._replace(thermal_resistance=0.0))
    y, rates = list(state), [0.0] * STATES
    y[OUTLET], y[VELOCITY] = y[CHAMBER], 0.0
    low, high = p.position_controller.current_limits
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        extra = 0.0
        if p.discrepancy.location == EP_CONVERTER:
            extra = discrepancy_at(p.discrepancy, time, middle, y, 0.0)
        y[BACK] = settled_back_pressure(p.ep_converter, middle, y[SUPPLY], time, extra)
        derivatives(still, time, middle, 0.0, y, rates)
        if rates[CHAMBER] < 0.0:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)
