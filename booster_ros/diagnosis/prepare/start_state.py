# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where a record starts: chamber pressure, stem position and back pressure in its first rows."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from scipy.optimize import minimize_scalar

from booster_ros.diagnosis.data.experiment import FEWEST, Array, Experiment, Initial
from booster_ros.diagnosis.prepare.otherwise import is_otherwise, moves
from booster_ros.diagnosis.prepare.plausibility import LITTLE
from booster_ros.model.ep_converter import settled_back_pressure
from booster_ros.model.memory import Departure
from booster_ros.model.system import PositionerParameters

_FIRST_ROWS = 5
"""Number of first rows, which are averaged if they stand still."""

FIRST_SECONDS = 3.0
"""Time from the first row on, s, that tells where the record starts."""


def start_state(columns: Mapping[str, Array], declared: PositionerParameters,
                noise: Mapping[str, float]) -> Initial:
    """Return the start in SI units; what was not measured follows from the declared parameters."""
    pressure, position = (first_value(columns[name], noise[name]) if name in columns else None
                          for name in ('chamber_pressure', 'valve_position'))
    if pressure is None:
        pressure = _unmeasured_pressure(columns, declared, position)
    return Initial(pressure, valve_position=position)


def first_value(values: Array, noise: float) -> float | None:
    """Return the mean of the first rows, or the first alone where they move; None if missing."""
    first = values[:_FIRST_ROWS]
    first = first[np.isfinite(first)]
    if not len(first) or not np.isfinite(values[0]):
        return None
    moved = abs(first[-1] - first[0]) > 3.0 * np.sqrt(2.0) * noise
    return float(first[0] if moved else np.mean(first))


def with_start_of_converter(experiment: Experiment, declared: PositionerParameters) -> Experiment:
    """
    Return the experiment with the E/P converter starting away from settled where it evidently did.

    A record may begin with its first command while the converter is still at an earlier one. Where
    the chamber is not at the pressure at which that command holds it, nothing says otherwise.
    """
    first = experiment.until(float(experiment.time[0]) + FIRST_SECONDS)
    if len(first.time) < FEWEST:  # then it is taken as settled
        return experiment

    def started(departure: float) -> Experiment:
        return replace(first, initial=replace(
            experiment.initial, departure=Departure(float(departure))))

    def missed(departure: float) -> float:
        predicted = started(departure).predict(declared)
        return float(sum(np.nansum(((values - predicted[name]) / first.noise[name])**2)
                         for name, values in first.measured.items()))

    supply = declared.supply.pressure
    settled = settled_back_pressure(declared.ep_converter, first.current[0], supply, 0.0, 0.0)
    found = minimize_scalar(missed, bounds=(-settled, supply - settled), method='bounded')
    taken = started(found.x)
    held = _settled_pressure({**first.pinned, 'control_current': first.current}, declared)
    unsettled = abs(held - first.initial.chamber_pressure) > LITTLE * supply
    if not (unsettled or is_otherwise(moves(first, declared), moves(taken, declared))):
        return experiment
    return replace(
        experiment, initial=replace(taken.initial, unsettled=unsettled), notes=(
            *experiment.notes, 'the E/P converter had not settled at the first command: it is '
            f'taken to start at {settled + found.x:.0f} Pa'))


def _unmeasured_pressure(columns: Mapping[str, Array], declared: PositionerParameters,
                         position: float | None) -> float:
    """Return the first chamber pressure, Pa gauge: the spring tells it, at a stop the booster."""
    act, drop = declared.actuator, float(columns.get('pressure_drop', np.zeros(1))[0])
    opens, opened = (end + act.plug_area * drop / act.effective_area for end in act.bench_set)
    settled = _settled_pressure(columns, declared)
    if position is None:
        return settled
    stroke = position / act.travel
    if stroke < LITTLE:
        return min(settled, opens)
    if stroke > 1.0 - LITTLE:
        return max(settled, opened)
    return opens + stroke * (opened - opens)


def _settled_pressure(columns: Mapping[str, Array], declared: PositionerParameters) -> float:
    """Return the pressure at which the three diaphragms balance in the first row."""
    supply, back, current = (float(columns.get(name, [otherwise])[0]) for name, otherwise in (
        ('supply_pressure', declared.supply.pressure), ('back_pressure', np.nan),
        ('control_current', 0.0)))
    if not np.isfinite(back):  # compared channels may begin later
        back = settled_back_pressure(declared.ep_converter, current, supply, 0.0, 0.0)
    b = declared.booster
    return min(max((back * b.s1 - supply * (b.s2 - b.s3)) / b.s3, 0.0), supply)
