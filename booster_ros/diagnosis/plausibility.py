# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Values that are possible in their unit, and cannot be of the declared valve.

Fitted all the same, they come out as an effect: of a chamber recorded in absolute pressure a
process that pushes on the plug is made.
"""

from collections.abc import Mapping

import numpy as np

from booster_ros.diagnosis.experiment import Experiment
from booster_ros.model.ep_converter import settled_back_pressure
from booster_ros.model.gas import ATMOSPHERE
from booster_ros.model.system import PositionerParameters
from booster_ros.records import RecordError

Array = np.ndarray

MOST = 0.99
BEYOND_TRAVEL = 2.0
"""A position is that of another valve where this share of it goes, or more, beyond so many times
the travel declared."""

BEYOND_SUPPLY = 2.0
"""A current is none for the declared converter where the least of it asks for so many times the
pressure of the supply."""

AN_ATMOSPHERE = 6e3
STEADY = 20e3
"""A chamber is recorded in absolute pressure if it lies an atmosphere above the declared model,
within the first of these, Pa, and four fifths of the rows within the second of each other."""


def check_scales(
    columns: Mapping[str, Array], declared: PositionerParameters, source: str
) -> None:
    """Raise RecordError where position or current cannot be of the declared valve."""
    position = columns.get('valve_position')
    if position is not None and np.isfinite(position).any():
        reached = float(np.nanquantile(np.abs(position), MOST))
        if reached > BEYOND_TRAVEL * declared.actuator.travel:
            raise RecordError(
                f'{source}, column valve_position: reaches {reached:.4g} m where the declared '
                f'travel is {declared.actuator.travel:.4g} m: convert the column to metres, or '
                'correct actuator.travel')
    current = columns.get('control_current')
    if current is not None and np.isfinite(current).any():
        least, most = (settled_back_pressure(declared.ep_converter, float(end), np.inf, 0.0, 0.0)
                       for end in (np.nanmin(current), np.nanmax(current)))
        if least > BEYOND_SUPPLY * declared.supply.pressure:
            raise RecordError(
                f'{source}, column control_current: asks the declared E/P converter for '
                f'{least:.3g} to {most:.3g} Pa in every row, the supply has '
                f'{declared.supply.pressure:.3g}: it is the current of another converter, or '
                'ep_converter.gain and ep_converter.offset are')


def check_gauge(experiment: Experiment, declared: PositionerParameters, source: str) -> None:
    """Raise RecordError where the chamber is an atmosphere above the declared model throughout."""
    measured = experiment.measured.get('chamber_pressure')
    if measured is None:
        return
    above = measured - experiment.predict(declared)['chamber_pressure']
    if not np.isfinite(above).any():
        return
    low, middle, high = np.nanquantile(above, [0.1, 0.5, 0.9])
    if abs(middle - ATMOSPHERE) < AN_ATMOSPHERE and high - low < STEADY:
        raise RecordError(
            f'{source}, column chamber_pressure: lies {middle:.4g} Pa above the declared model '
            'throughout, which looks like absolute pressure: subtract that of the atmosphere')
