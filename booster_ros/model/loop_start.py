# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The state in which a run starts, driven by a current or by a set point, the process pushing."""

from collections.abc import Mapping

from .holding import holding_current, holding_pressure
from .sensors import position_behind, pressure_behind, pressure_reading
from .start import Start, start_of_readings
from .stream import settled_state
from .system import PositionerParameters


def start_of_run(
    p: PositionerParameters, time: float, command: float, readings: Mapping[str, float]
) -> Start:
    """
    Return what `start_of_readings` does, for a command that may be a set point.

    `readings` may also have the pressure_drop over the process valve, Pa. `command` is the control
    current, A. With the position controller on it does not tell the start: the current is then the
    one that holds the stem, and so is the pressure where only the position is read.
    """
    told = dict(readings)
    drop = told.pop('pressure_drop', 0.0)
    if p.position_controller.enabled:
        command, told = _held(p, time, drop, told)
    state, departure = start_of_readings(_pushed(p, drop), time, command, told)
    return {**state, 'pressure_drop': drop}, departure


def _held(
    p: PositionerParameters, time: float, drop: float, readings: dict[str, float]
) -> tuple[float, dict[str, float]]:
    """Return the current, A, that holds the stem where it is read, and the readings with it."""
    position = None
    if 'valve_position' in readings:
        position = position_behind(p.sensors, readings['valve_position'])
        if 'chamber_pressure' not in readings:
            held = holding_pressure(p, position, drop)
            readings = {**readings, 'chamber_pressure': pressure_reading(p.sensors, held)}
    pressure = 0.0
    if 'chamber_pressure' in readings:
        pressure = pressure_behind(p.sensors, readings['chamber_pressure'])
    state = settled_state(p, 0.0, pressure, position, time, drop)
    return holding_current(p, time, state), readings


def _pushed(p: PositionerParameters, drop: float) -> PositionerParameters:
    """Return the parameters with the force of a standing pressure drop (Pa) as bench set."""
    act = p.actuator
    shift = act.bench_set_shift + act.plug_area * drop / act.effective_area
    return p._replace(actuator=act._replace(bench_set_shift=shift))
