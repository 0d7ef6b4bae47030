# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Values that are possible in their unit, but cannot be of the declared valve (see also otherwise).

Fitted all the same, they come out as an effect, or the diagnosis takes minutes and finds nothing.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from booster_ros.diagnosis.data.experiment import UNITS, Array, Experiment
from booster_ros.diagnosis.estimation.parametrisation import BENCH, get
from booster_ros.model.ep_converter import settled_back_pressure
from booster_ros.model.system import PositionerParameters
from booster_ros.records import RecordError
from booster_ros.records.holding import bridged
from booster_ros.records.units import LARGEST_KILOPASCALS

DRIVES = {'control_current', 'set_point', 'back_pressure', 'chamber_pressure'}
"""What can move the valve: a supply alone does not."""

REACHED = 0.99
"""Quantile of the values of a channel that counts as reached."""

LITTLE = 0.05
"""Share of the travel, of the supply, or of the range of a command, that is more than a tolerance,
than a stop yields, or than a command moves on slowly."""

OF_ANOTHER = 2.0
"""Multiple of travel, or of the supply that the least current asks for, that is another valve's."""


def check_declared(declared: PositionerParameters, source: str) -> None:
    """Raise RecordError where a declared pressure is too small to be in pascals."""
    for name, pressure in (('supply.pressure', declared.supply.pressure),
                           ('actuator.bench_set', max(declared.actuator.bench_set))):
        if 0.0 < pressure < LARGEST_KILOPASCALS:
            raise RecordError(f'{source}, {name}: {pressure:g} Pa looks like kPa, bar, MPa or psi: '
                              'give it in Pa, gauge')


def check_scales(columns: Mapping[str, Array], declared: PositionerParameters, source: str) -> None:
    """Raise RecordError where position or current cannot be of the declared valve."""
    position = columns.get('valve_position')
    if position is not None and np.isfinite(position).any():
        reached = float(np.nanquantile(np.abs(position), REACHED))
        if reached > OF_ANOTHER * declared.actuator.travel:
            raise RecordError(
                f'{source}, column valve_position: reaches {reached:.4g} m where the declared '
                f'travel is {declared.actuator.travel:.4g} m: convert the column to metres, or '
                'correct actuator.travel')
    current = columns.get('control_current')
    if current is not None and np.isfinite(current).any():
        least, most = (settled_back_pressure(declared.ep_converter, float(end), np.inf, 0.0, 0.0)
                       for end in (np.nanmin(current), np.nanmax(current)))
        if least > OF_ANOTHER * declared.supply.pressure:
            raise RecordError(
                f'{source}, column control_current: asks the declared E/P converter for '
                f'{least:.3g} to {most:.3g} Pa in every row, the supply has '
                f'{declared.supply.pressure:.3g}: it is the current of another converter, or '
                'ep_converter.gain and ep_converter.offset are')


def out_of_reach(columns: Mapping[str, Array], declared: PositionerParameters) -> tuple[str, ...]:
    """Return a sentence for each channel, SI units, that reaches what the declared valve cannot."""
    notes = []
    supply, travel = declared.supply.pressure, declared.actuator.travel
    for name, unit, full, what in (
            ('chamber_pressure', 'Pa', supply, 'supply'), ('back_pressure', 'Pa', supply, 'supply'),
            ('valve_position', 'm', travel, 'travel')):
        values = known(columns.get(name, np.empty(0)))
        low, high = np.quantile(values, [1.0 - REACHED, REACHED]) if len(values) else (0.0, 0.0)
        below = name == 'valve_position' and low < -LITTLE * full
        if full > 0.0 and (below or high > (1.0 + LITTLE) * full):
            notes.append(f'{name} goes from {low:.4g} to {high:.4g} {unit}, beyond the declared '
                         f'{what} of {full:.4g} {unit}: the declared valve cannot')
    return tuple(notes)


def check_drive(experiment: Experiment, declared: PositionerParameters, source: str) -> None:
    """Raise RecordError where a booster is shut that should not be, or open that nothing drives."""
    shut = [name for name in BENCH if get(declared, name) <= 0.0]
    if experiment.is_flow_bench and shut:
        raise RecordError(
            f'{source}: a flow bench, around a booster without flow: {shut[0]} must be above 0')
    if not shut and not DRIVES & {*experiment.drives}:
        raise RecordError(
            f'{source}: nothing drives the model (control_current is missing, or 0 A in every '
            'row), and the declared booster opens: declare booster.opening_gain: 0.0 if the '
            'chamber was shut off, or leave out a current that did not drive the valve')


def driven(experiment: Experiment) -> Experiment:
    """Return the experiment with the stem driven by the measured pressure, if there is one."""
    pressure = experiment.measured.get('chamber_pressure')
    if pressure is None or not np.isfinite(pressure).any():
        return experiment
    return replace(
        experiment, current=np.zeros_like(experiment.current), command='control_current',
        measured={'valve_position': experiment.measured['valve_position']},
        pinned={**experiment.pinned, 'chamber_pressure': bridged(experiment.time, pressure)})


def without_stuck(experiment: Experiment, declared: PositionerParameters, source: str
                  ) -> Experiment:
    """
    Return the experiment without channels that never change where the declared model moves much.

    Without noise they would outweigh all others. RecordError where no channel is left.
    """
    ranges = {'valve_position': declared.actuator.travel, 'mass_flow': np.inf}
    pressure_stands = stands_still(experiment.measured.get('chamber_pressure', np.array([])))
    stuck = {}
    for name, values in experiment.measured.items():
        if not stands_still(values):
            continue
        alone = name == 'valve_position' and not pressure_stands
        moving = driven(experiment) if alone else experiment
        moves = float(np.ptp(moving.predict(declared)[name][np.isfinite(values)]))
        if moves > LITTLE * ranges.get(name, declared.supply.pressure):
            stuck[name] = (
                f'{name} is not compared: it reads {np.nanmax(values):.6g} {UNITS[name]} in every '
                f'row where the declared model moves by {moves:.3g} {UNITS[name]}, which is a '
                'sensor, or a valve, that sticks fast')
    if not stuck:
        return experiment
    left = {name: values for name, values in experiment.measured.items() if name not in stuck}
    if not any(np.isfinite(values).any() for values in left.values()):
        raise RecordError(f'{source}: {"; ".join(stuck.values())}; no other channel is left')
    return replace(experiment, measured=left, noise={name: experiment.noise[name] for name in left},
                   notes=(*experiment.notes, *stuck.values()))


def stands_still(values: Array) -> bool:
    """Tell whether a channel reads one value in every row in which it reads any."""
    return len(known(values)) > 0 and bool(np.ptp(known(values)) == 0.0)


def known(values: Array) -> Array:
    """Return the values without those that are missing."""
    return values[np.isfinite(values)]
