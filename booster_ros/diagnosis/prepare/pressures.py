# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Pressures that cannot be gauge pressures of the declared valve in Pa.

Fitted all the same, they come out as an effect: a chamber recorded in absolute pressure comes out
as a process that pushes on the plug, a supply as a dead band.
"""

from collections.abc import Collection
from dataclasses import replace
import itertools

import numpy as np

from booster_ros.diagnosis.data.experiment import Experiment
from booster_ros.diagnosis.prepare.fit_metrics import (
    FOLLOWS, SMALLEST, alike, follows, is_otherwise, stem_alone)
from booster_ros.model.gas import ATMOSPHERE
from booster_ros.model.system import PositionerParameters
from booster_ros.records import RecordError

Array = np.ndarray

AN_ATMOSPHERE = 6e3
STEADY = 20e3
"""Tolerances, Pa. A pressure is recorded as absolute if it lies an atmosphere above the declared
model, within the first, and four fifths of the rows lie above it by the same, within the second."""

LEAST_ABSOLUTE = ATMOSPHERE - AN_ATMOSPHERE
"""Least absolute pressure in a valve, Pa."""

FAR_ABOVE = 50e3
"""Distance in Pa. A pressure that drives the booster is absolute if it is
never below the atmosphere and the declared model, with an atmosphere taken off, leaves less than
EXPLAINED of its error. A chamber is also recorded in absolute pressure if it is never below the
atmosphere and, driving the stem with an atmosphere taken off, leaves less than EXPLAINED of the
error of the position. A chamber that is not the drive has to lie so far above the declared model as
well: else the stem is another one. Above a dead band no atmosphere is steady."""

FILLED_BEYOND = 0.05
"""Share of the declared supply by which a chamber may rise above the largest pressure of the
recorded one: a sensor that is off. Trapped air may be above any supply, but it does not rise."""

FAR_TOO_SMALL = 0.05
HUNDRED = 100.0
"""
Share of a size, and factor from mbar to Pa. A pressure is in another unit if it follows that of
the declared model at less than this share of its size: in mbar
it is a hundredth, and no effect leaves so little of it. A pressure that drives the model is in
another unit if it is as small beside the declared supply, and the model follows the record only
with this pressure taken as mbar.
"""


def check_pressures(
    experiment: Experiment, declared: PositionerParameters, source: str
) -> None:
    """Raise RecordError where a pressure is in another unit, or absolute, or none of this valve."""
    _check_unit_of_drives(experiment, declared, source)
    predicted = experiment.predict(declared)
    _check_gauge_of_drives(experiment, declared, source)
    for name in ('back_pressure', 'chamber_pressure'):
        if name in predicted:
            _check_unit(name, experiment.measured[name], predicted[name], source)
            _check_gauge(name, experiment.measured[name] - predicted[name], source)
    if 'chamber_pressure' in predicted:
        _check_chamber_far_above(experiment, declared, predicted['chamber_pressure'], source)
    elif 'chamber_pressure' in experiment.pinned and 'valve_position' in predicted:
        alone = replace(experiment, measured={
            'valve_position': experiment.measured['valve_position']})
        _check_drive_of_stem(alone, declared, source)
    _check_supply(experiment, declared, source)


def _check_supply(
    experiment: Experiment, declared: PositionerParameters, source: str
) -> None:
    supply = experiment.pinned.get('supply_pressure')
    chamber = experiment.measured.get('chamber_pressure', np.empty(0))  # not what a bench sets
    chamber = chamber[np.isfinite(chamber)]
    if supply is None or not len(chamber) or experiment.quasi_static:
        return
    most = float(np.max(supply))
    above = np.maximum(chamber, most)
    rise = float(np.max(above - np.minimum.accumulate(above)))
    if rise > FILLED_BEYOND * declared.supply.pressure:
        raise RecordError(
            f'{source}, column supply_pressure: never exceeds {most:.4g} Pa, and the chamber fills '
            f'from there to {np.max(chamber):.4g} Pa: it is not what fed the booster; correct the '
            'column, or leave it out')


def _check_unit(name: str, measured: Array, predicted: Array, source: str) -> None:
    likeness = alike(measured, predicted)
    share = likeness * float(np.nanstd(measured) / max(np.nanstd(predicted), SMALLEST))
    if likeness > FOLLOWS and share < FAR_TOO_SMALL:
        raise RecordError(
            f'{source}, column {name}: moves as the declared model does, at {share:.2g} of its '
            'size: convert the column to Pa, gauge (from mbar: times 100)')


def _check_unit_of_drives(
    experiment: Experiment, declared: PositionerParameters, source: str
) -> None:
    small = {name: HUNDRED * values for name, values in experiment.pinned.items()
             if 0.0 < np.max(values) < FAR_TOO_SMALL * declared.supply.pressure}
    if not small:
        return
    larger = replace(experiment, pinned={**experiment.pinned, **small})
    if follows(larger, declared) and not follows(experiment, declared):
        most = max(float(np.max(experiment.pinned[name])) for name in small)
        raise RecordError(
            f'{source}, column {" and ".join(small)}: never exceeds {most:.4g} Pa, and the '
            'declared model moves as the record with a hundred times as much: convert to Pa, '
            'gauge (from mbar: times 100)')


def _check_gauge_of_drives(
    experiment: Experiment, declared: PositionerParameters, source: str
) -> None:
    high = [name for name in ('supply_pressure', 'back_pressure')
            if name in experiment.pinned and np.min(experiment.pinned[name]) > LEAST_ABSOLUTE]
    for names in itertools.chain(*(itertools.combinations(high, n) for n in (1, 2))):
        if is_otherwise(experiment, _with_an_atmosphere_less(experiment, names), declared):
            raise RecordError(
                f'{source}, column {" and ".join(names)}: the declared model moves as measured '
                'with an atmosphere less, which looks like absolute pressure: subtract that of '
                'the atmosphere')


def _with_an_atmosphere_less(experiment: Experiment, names: Collection[str]) -> Experiment:
    """Return the experiment with an atmosphere taken off these pressures, which drive it."""
    return replace(experiment, pinned={
        name: values - ATMOSPHERE if name in names else values
        for name, values in experiment.pinned.items()})


def _check_gauge(name: str, above: Array, source: str) -> None:
    if not np.isfinite(above).any():
        return
    low, middle, high = np.nanquantile(above, [0.1, 0.5, 0.9])
    if abs(middle - ATMOSPHERE) < AN_ATMOSPHERE and high - low < STEADY:
        raise RecordError(
            f'{source}, column {name}: lies {middle:.4g} Pa above the declared model '
            'throughout, which looks like absolute pressure: subtract that of the atmosphere')


def _check_chamber_far_above(
    experiment: Experiment, declared: PositionerParameters, predicted: Array, source: str
) -> None:
    above = experiment.measured['chamber_pressure'] - predicted
    if not np.isfinite(above).any() or 'valve_position' not in experiment.measured:
        return
    if np.nanmedian(above) > FAR_ABOVE:
        _check_drive_of_stem(stem_alone(experiment), declared, source)


def _check_drive_of_stem(
    experiment: Experiment, declared: PositionerParameters, source: str
) -> None:
    pressure = experiment.pinned['chamber_pressure']
    if np.min(pressure) < LEAST_ABSOLUTE:
        return
    less = _with_an_atmosphere_less(experiment, ['chamber_pressure'])
    if is_otherwise(experiment, less, declared):
        raise RecordError(
            f'{source}, column chamber_pressure: is never below {np.min(pressure):.4g} Pa, and the '
            'declared stem moves as measured with an atmosphere less, which looks like absolute '
            'pressure: subtract that of the atmosphere')
