# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Values that are possible in their unit, but cannot be of the declared valve.

Fitted all the same, they come out as an effect: a chamber recorded in absolute pressure comes out
as a process that pushes on the plug. Or the search runs for minutes and finds nothing.
"""

from collections.abc import Mapping
from dataclasses import replace
import itertools

import numpy as np

from booster_ros.diagnosis.experiment.experiment import UNITS, Experiment, rmse
from booster_ros.diagnosis.fitting.freedom import BENCH, get
from booster_ros.model.ep_converter import settled_back_pressure
from booster_ros.model.gas import ATMOSPHERE
from booster_ros.model.system import PositionerParameters
from booster_ros.records import RecordError
from booster_ros.records.holding import bridged

Array = np.ndarray

DRIVES = {'control_current', 'back_pressure', 'chamber_pressure'}
"""What can move the valve: a supply alone does not."""

MOST = 0.99
BEYOND_TRAVEL = 2.0
"""Quantile of the magnitude of a position, and multiple of the declared travel beyond which this
quantile shows that the position is that of another valve."""

BEYOND_SUPPLY = 2.0
"""Multiple of the pressure of the supply: a current is none for the declared converter if even its
smallest value asks for more."""

AN_ATMOSPHERE = 6e3
STEADY = 20e3
"""Tolerances, Pa. A pressure is recorded as absolute if it lies an atmosphere above the declared
model, within the first, and four fifths of the rows lie above it by the same, within the second."""

LEAST_ABSOLUTE = ATMOSPHERE - AN_ATMOSPHERE
"""Least absolute pressure in a valve, Pa."""

MOSTLY_EXPLAINED = 0.3
FAR_ABOVE = 50e3
"""Share of an error, and distance in Pa. A pressure that drives the booster is absolute if it is
never below the atmosphere and the declared model, with an atmosphere taken off, leaves less than
this share of its error. A chamber is also recorded in absolute pressure if it is never below the
atmosphere and, driving the stem with an atmosphere taken off, leaves less than this share of the
error of the position. A chamber that is not the drive has to lie so far above the declared model as
well: else the stem is another one. Above a dead band no atmosphere is steady."""

FAR_TOO_SMALL = 0.05
FOLLOWS = 0.9
HUNDRED = 100.0
"""
Share of a size, correlation, and factor from mbar to Pa. A pressure is in another unit if it
follows that of the declared model with more than this correlation, at less than this share of its
size: in mbar it is a hundredth, and no effect leaves so little of it. A pressure that drives the
model is in another unit if it is as small beside the declared supply, and the model follows the
record only with this pressure taken as mbar. A position is reversed if it follows the model as
closely, but in the other direction.
"""

STUCK = 0.05
"""Share of the travel, or of the supply: where the declared model moves by more, a reading that
never changes is that of a sensor, or a valve, that sticks fast."""

SMALLEST = 1e-12

SECONDS = {'nanoseconds': 1e-9, 'microseconds': 1e-6, 'milliseconds': 1e-3, 'minutes': 60.0,
           'hours': 3600.0, 'days': 86400.0}
USUAL_STEP = (1e-3, 1.0)
CLEARLY_BETTER = 0.5
"""Usual distance of rows in seconds, and share of an error. Time is in another unit if rows are
not so far apart, would be in that unit, and the declared model then leaves less than this share of
its error."""


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


def check_bench(experiment: Experiment, declared: PositionerParameters, source: str) -> None:
    """Raise RecordError where a flow bench is to find seats that the declared model keeps shut."""
    if not experiment.is_flow_bench:
        return
    for name in BENCH:
        if get(declared, name) <= 0.0:
            raise RecordError(
                f'{source}: a flow bench, around a booster without flow: {name} must be above 0')


def check_drive(experiment: Experiment, declared: PositionerParameters, source: str) -> None:
    """Raise RecordError where nothing drives the model and the declared booster is not shut."""
    booster = declared.booster
    if booster.opening_gain <= 0.0 or booster.max_area <= 0.0 or DRIVES & {*experiment.drives}:
        return
    raise RecordError(
        f'{source}: nothing drives the model (control_current is missing, or 0 A in every row), '
        'and the declared booster opens: declare booster.opening_gain: 0.0 if the chamber was shut '
        'off, or leave out a current that did not drive the valve')


def check_pressures(
    experiment: Experiment, declared: PositionerParameters, source: str
) -> None:
    """Raise RecordError where a pressure is in another unit, or absolute, as the model shows."""
    _check_unit_of_drives(experiment, declared, source)
    _check_gauge_of_drives(experiment, declared, source)
    predicted = experiment.predict(declared)
    for name in ('back_pressure', 'chamber_pressure'):
        if name in predicted:
            _check_unit(name, experiment.measured[name], predicted[name], source)
            _check_gauge(name, experiment.measured[name] - predicted[name], source)
    if 'chamber_pressure' in predicted:
        _check_chamber_far_above(experiment, declared, predicted['chamber_pressure'], source)
    elif 'chamber_pressure' in experiment.pinned and 'valve_position' in predicted:
        _check_drive_of_stem(experiment, declared, source)


def _check_unit(name: str, measured: Array, predicted: Array, source: str) -> None:
    alike = _alike(measured, predicted)
    share = alike * float(np.nanstd(measured) / max(np.nanstd(predicted), SMALLEST))
    if alike > FOLLOWS and share < FAR_TOO_SMALL:
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
    if _follows(larger, declared) and not _follows(experiment, declared):
        most = max(float(np.max(experiment.pinned[name])) for name in small)
        raise RecordError(
            f'{source}, column {" and ".join(small)}: never exceeds {most:.4g} Pa, and the '
            'declared model moves as the record with a hundred times as much: convert to Pa, '
            'gauge (from mbar: times 100)')


def _follows(experiment: Experiment, declared: PositionerParameters) -> bool:
    """Tell whether the declared model moves as measured, whatever the size."""
    predicted = experiment.predict(declared)
    return all(_alike(measured, predicted[name]) > FOLLOWS
               for name, measured in experiment.measured.items())


def _alike(measured: Array, predicted: Array) -> float:
    """Return the correlation of two channels, 0 where one does not move."""
    both = np.isfinite(measured) & np.isfinite(predicted)
    if not both.any() or np.std(predicted[both]) == 0.0 or np.std(measured[both]) == 0.0:
        return 0.0
    return float(np.corrcoef(measured[both], predicted[both])[0, 1])


def _check_gauge_of_drives(
    experiment: Experiment, declared: PositionerParameters, source: str
) -> None:
    high = [name for name in ('supply_pressure', 'back_pressure')
            if name in experiment.pinned and np.min(experiment.pinned[name]) > LEAST_ABSOLUTE]
    if not high:
        return
    sizes = _sizes(experiment, declared)
    given = _miss(experiment, declared, sizes)
    for names in itertools.chain(*(itertools.combinations(high, n) for n in (1, 2))):
        less = replace(experiment, pinned={
            name: values - ATMOSPHERE * (name in names)
            for name, values in experiment.pinned.items()})
        if _miss(less, declared, sizes) < MOSTLY_EXPLAINED * given:
            raise RecordError(
                f'{source}, column {" and ".join(names)}: the declared model moves as measured '
                'with an atmosphere less, which looks like absolute pressure: subtract that of '
                'the atmosphere')


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
        _check_drive_of_stem(_stem_alone(experiment), declared, source)


def _stem_alone(experiment: Experiment) -> Experiment:
    """Return the experiment with the stem driven by the measured pressure."""
    pressure = bridged(experiment.time, experiment.measured['chamber_pressure'])
    return replace(
        experiment, current=np.zeros_like(experiment.current),
        measured={'valve_position': experiment.measured['valve_position']},
        pinned={**experiment.pinned, 'chamber_pressure': pressure})


def _check_drive_of_stem(
    experiment: Experiment, declared: PositionerParameters, source: str
) -> None:
    pressure = experiment.pinned['chamber_pressure']
    position = experiment.measured['valve_position']
    if np.min(pressure) < LEAST_ABSOLUTE:
        return
    less = replace(experiment, pinned={
        **experiment.pinned, 'chamber_pressure': pressure - ATMOSPHERE})
    every = np.ones(len(position), dtype=bool)
    given, lowered = (rmse(position, one.predict(declared)['valve_position'], every)
                      for one in (experiment, less))
    if lowered < MOSTLY_EXPLAINED * given:
        raise RecordError(
            f'{source}, column chamber_pressure: is never below {np.min(pressure):.4g} Pa, and the '
            'declared stem moves as measured with an atmosphere less, which looks like absolute '
            'pressure: subtract that of the atmosphere')


def check_direction(
    experiment: Experiment, declared: PositionerParameters, source: str
) -> None:
    """Raise RecordError where a position moves against the declared model."""
    position = experiment.measured.get('valve_position')
    if position is None or not np.isfinite(position).any():
        return
    if _alike(position, _driven(experiment).predict(declared)['valve_position']) >= -FOLLOWS:
        return
    if np.nansum(position) < 0.0:
        raise RecordError(
            f'{source}, column valve_position: lies mostly below 0 and falls where the declared '
            'model opens: reverse its sign, positions count from where the vented stem rests')
    raise RecordError(
        f'{source}, column valve_position: falls where the declared model opens: positions count '
        'from where the vented stem rests, which is open for a valve that air closes (subtract '
        'them from the travel)')


def _driven(experiment: Experiment) -> Experiment:
    """Return the experiment with the stem driven by the measured pressure, if there is one."""
    seen = np.isfinite(experiment.measured.get('chamber_pressure', np.nan)).any()
    return _stem_alone(experiment) if seen else experiment


def without_stuck(
    experiment: Experiment, declared: PositionerParameters, source: str
) -> Experiment:
    """
    Return the experiment without channels that never change where the declared model moves much.

    Such a reading has no noise, so it would outweigh all others. RecordError where no channel is
    left.
    """
    ranges = {'valve_position': declared.actuator.travel, 'mass_flow': np.inf}
    pressure_stands = stands_still(experiment.measured.get('chamber_pressure', np.array([])))
    stuck = {}
    for name, values in experiment.measured.items():
        if not stands_still(values):
            continue
        alone = name == 'valve_position' and not pressure_stands
        driven = _driven(experiment) if alone else experiment
        moves = float(np.ptp(driven.predict(declared)[name][np.isfinite(values)]))
        if moves > STUCK * ranges.get(name, declared.supply.pressure):
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
    known = values[np.isfinite(values)]
    return len(known) > 0 and bool(np.ptp(known) == 0.0)


def check_clock(experiment: Experiment, declared: PositionerParameters, source: str) -> None:
    """Raise RecordError where time is in another unit than s, as the declared model shows."""
    step = float(np.median(np.diff(experiment.time)))
    if USUAL_STEP[0] <= step <= USUAL_STEP[1]:
        return
    sizes = _sizes(experiment, declared)
    given = _miss(experiment, declared, sizes)
    for unit, seconds in SECONDS.items():
        other = replace(experiment, time=seconds * experiment.time)
        suits = USUAL_STEP[0] <= seconds * step <= USUAL_STEP[1]
        if suits and _miss(other, declared, sizes) < CLEARLY_BETTER * given:
            raise RecordError(
                f'{source}, column time: rows {step:.3g} s apart do not suit the declared model, '
                f'which moves as measured if they are {step:.3g} {unit} apart: convert the column '
                'to seconds')


def _sizes(experiment: Experiment, declared: PositionerParameters) -> dict[str, float]:
    """Return how much each compared channel moves, as measured or in the model."""
    predicted = experiment.predict(declared)
    # a dead sensor does next to nothing, as a share of which its error would outweigh all else
    return {name: max(float(np.nanstd(measured)), float(np.std(predicted[name])), SMALLEST)
            for name, measured in experiment.measured.items()}


def _miss(experiment: Experiment, declared: PositionerParameters, sizes: Mapping[str, float]
          ) -> float:
    """Return the error of the declared model, summed over channels as shares of their `sizes`."""
    predicted, every = experiment.predict(declared), np.ones(len(experiment.time), dtype=bool)
    return sum(rmse(measured, predicted[name], every) / sizes[name]
               for name, measured in experiment.measured.items())
