# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where a record starts: chamber pressure and stem position in its first rows."""

from collections.abc import Mapping

import numpy as np

from booster_ros.diagnosis.experiment import Initial
from booster_ros.model.ep_converter import settled_back_pressure
from booster_ros.model.system import PositionerParameters

Array = np.ndarray

_FIRST_ROWS = 5
"""Rows that are averaged if the signal stands still in them."""

_AT_STOP = 0.02
"""Share of the travel within which a stem may rest against its stop."""


def start_state(
    columns: Mapping[str, Array], declared: PositionerParameters, noise: Mapping[str, float]
) -> Initial:
    """Return the start in SI units; what was not measured follows from the declared parameters."""
    position = None
    if 'valve_position' in columns:
        position = first_value(columns['valve_position'], noise['valve_position'])
    if 'chamber_pressure' in columns:
        pressure = first_value(columns['chamber_pressure'], noise['chamber_pressure'])
        if pressure is not None:
            return Initial(pressure, valve_position=position)
    return Initial(_unmeasured_pressure(columns, declared, position), valve_position=position)


def first_value(values: Array, noise: float) -> float | None:
    """Return the mean of the first rows, or the first alone where they move; None if missing."""
    first = values[:_FIRST_ROWS]
    first = first[np.isfinite(first)]
    if not len(first) or not np.isfinite(values[0]):
        return None
    moved = abs(first[-1] - first[0]) > 3.0 * np.sqrt(2.0) * noise
    return float(first[0] if moved else np.mean(first))


def _unmeasured_pressure(
    columns: Mapping[str, Array], declared: PositionerParameters, position: float | None
) -> float:
    """
    Return the chamber pressure, Pa gauge, that a pressureless record must have started from.

    Off the stops the spring tells it; elsewhere it is where the booster settles.
    """
    opens, opened = declared.actuator.bench_set
    settled = _settled_pressure(columns, declared)
    if position is None:
        return settled
    stroke = position / declared.actuator.travel
    if stroke < _AT_STOP:
        return min(settled, opens)
    if stroke > 1.0 - _AT_STOP:
        return max(settled, opened)
    return opens + stroke * (opened - opens)


def _settled_pressure(columns: Mapping[str, Array], declared: PositionerParameters) -> float:
    """Return the pressure at which the three diaphragms balance in the first row."""
    supply = declared.supply.pressure
    if 'supply_pressure' in columns:
        supply = float(columns['supply_pressure'][0])
    if 'back_pressure' in columns:
        back = float(columns['back_pressure'][0])
    else:
        current = float(columns['control_current'][0]) if 'control_current' in columns else 0.0
        back = settled_back_pressure(declared.ep_converter, current, supply, 0.0, 0.0)
    b = declared.booster
    return min(max((back * b.s1 - supply * (b.s2 - b.s3)) / b.s3, 0.0), supply)
