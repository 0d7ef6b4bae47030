# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""From a cleaned record to an experiment."""

from collections.abc import Mapping
from dataclasses import replace
from math import sqrt

import numpy as np
from scipy.ndimage import uniform_filter1d

from booster_ros.signals.stationary_segments import calm_pieces
from booster_ros.diagnosis.data.experiment import (
    AVERAGED, FEWEST, THINNED_TOLERANCE, Array, DriveNoise, Experiment)
from booster_ros.signals.noise_level import white_noise
from booster_ros.signals.noise_autocorrelation import noise_of
from booster_ros.diagnosis.data.roles import Roles
from booster_ros.diagnosis.prepare.feedback import with_noise_of_feedback
from booster_ros.diagnosis.prepare.gaps import caught_up, gaps_that_hide
from booster_ros.diagnosis.prepare.otherwise import check_taken_otherwise
from booster_ros.diagnosis.prepare.plausibility import (
    check_drive, out_of_reach, stands_still, without_stuck)
from booster_ros.diagnosis.prepare.rows import Rows, aligned
from booster_ros.diagnosis.prepare.start_state import start_state, with_start_of_converter
from booster_ros.diagnosis.prepare.timing import (
    commands_may_be_late, with_noise_of_timing, with_sampled_commands)
from booster_ros.model.system import PositionerParameters
from booster_ros.records import Record, RecordError
from booster_ros.records.holding import between_samples, bridged, last_known

_WHITE = (
    'what drives the valve hardly rests, nor moves smoothly for long: noise is taken as white, as '
    'its colour shows there alone; where a sensor is damped there is more of it, up to several '
    'times, and what seems to be missed may be noise')

_CLOUDED = (
    'the noise of {} is taken as white: where the drives are calm, the valve still moves (slips, '
    'hunting, a supply that ripples), which hides how noise carries over from row to row; where a '
    'sensor is damped there is more of it than is said here')

LEAST_NOISE = {'back_pressure': 5.0, 'supply_pressure': 5.0, 'chamber_pressure': 5.0,
               'valve_position': 1e-7, 'mass_flow': 1e-9, 'pressure_drop': 5.0}
"""Smallest noise of a channel, in its unit: above what the solver leaves on thinned rows, 2 Pa and
0.03 um. Sensors resolve far less."""

TRANSMITTER = 5e-4
"""Largest noise of a position in a slow loop, as a share of the travel, a transmitter's: there a
valve that moves looks like noise."""

SLOW_PERIOD = 0.04
"""Shortest period of a controller in a slow loop, s; what it changes counts as noise."""


def prepare(record: Record, declared: PositionerParameters, dwell: float | None = None
            ) -> Experiment:
    """
    Return the experiment that is made of a record.

    The most upstream channels drive, the others are compared; rows in and shortly after gaps of
    the drive do not count. A record without time is a quasi-static sweep whose rows last `dwell`
    seconds each. RecordError where nothing can be compared, or values cannot be of this valve.
    """
    rows = aligned(record, declared, dwell)
    experiment = _experiment(rows, declared)
    experiment = replace(
        experiment, notes=(*out_of_reach(rows.columns, declared), *experiment.notes),
        # held values show no noise, and the channel was anywhere within the limit of storing
        noise={name: max(level, record.held.get(name, 0.0) / sqrt(3.0))
               for name, level in experiment.noise.items()})
    if experiment.is_slow:
        experiment = _seen_slowly(experiment, declared)
    if not rows.quasi_static:
        experiment = _without_gaps(experiment, rows, declared)
    check_drive(experiment, declared, rows.source)
    check_taken_otherwise(experiment, declared, rows.source)
    experiment = without_stuck(experiment, declared, rows.source)
    experiment = replace(experiment, notes=(*experiment.notes, *(
        f'{name} stands still: every row has the same value'
        for name, values in experiment.measured.items() if stands_still(values))))
    if rows.quasi_static:
        return experiment
    experiment = _with_doubt_of_timing(experiment, declared, rows.source)
    if 'control_current' in rows.role.drives and 'back_pressure' not in rows.columns:
        experiment = with_start_of_converter(experiment, declared)
    return _with_noise_of_drives(with_noise_of_feedback(experiment, declared), declared)


def _experiment(rows: Rows, declared: PositionerParameters) -> Experiment:
    """Return the experiment of these rows, with the noise and the start that they show."""
    columns, role, time = rows.columns, rows.role, rows.time
    compared = {name: np.where(rows.usable, columns[name], np.nan) for name in role.compared}
    _check_enough(compared, rows.source, *rows.left_out)
    current = _current(columns, role, rows.quasi_static)
    pinned = {name: bridged(time, columns[name]) for name in role.pinned}
    calm = [] if rows.quasi_static else calm_pieces(time, [current, *pinned.values()])
    told = {name: noise_of(values, calm) for name, values in columns.items() if name != 'time'}
    # coloured noise is more than its differences show
    noise = {name: max(each.level, LEAST_NOISE.get(name, 0.0)) for name, each in told.items()}
    clouded = ' and '.join(name for name in role.compared if told[name].clouded
                           and told[name].level > LEAST_NOISE[name])
    return Experiment(
        time=time,
        current=current,
        measured=compared,
        noise={name: noise[name] for name in role.compared},
        pinned=pinned,
        initial=start_state({name: values if np.isfinite(values[0]) else between_samples(
            columns.get('time'), values) for name, values in columns.items()}, declared, noise),
        drive_noise={} if rows.quasi_static else {
            name: _drive_noise(name, values, calm) for name, values in rows.sampled.items()},
        quasi_static=rows.quasi_static,
        begins=rows.begins,
        command=role.command,
        notes=(*rows.notes, *([] if rows.quasi_static or calm else [_WHITE]),
               *([_CLOUDED.format(clouded)] if clouded else [])),
    )


def _seen_slowly(experiment: Experiment, declared: PositionerParameters) -> Experiment:
    """Return a slow experiment with the noise of a transmitter, and what rows so far apart hide."""
    most = TRANSMITTER * declared.actuator.travel
    apart = float(np.median(np.diff(experiment.time)))
    quick = replace(experiment, tolerance=THINNED_TOLERANCE, least_period=SLOW_PERIOD)
    fine, rough = (one.predict(declared) for one in (experiment, quick))
    noise = {name: min(level, most) if name == 'valve_position' else level
             for name, level in experiment.noise.items()}
    return replace(
        quick,
        noise={name: float(np.hypot(level, np.std(fine[name] - rough[name])))
               for name, level in noise.items()},
        notes=(*experiment.notes, f'rows {apart:.3g} s apart, and set point and position alone, '
               'tell how fast the valve follows, what it loses in a reversal, its gain and zero; '
               'not where below the controller: lost motion may be a dead zone of the positioner, '
               'backlash, or friction of the stem, a slow stroke may be a rate limit, the supply, '
               'the booster or a leak, and the actuator is taken as declared'))


def _without_gaps(experiment: Experiment, rows: Rows, declared: PositionerParameters
                  ) -> Experiment:
    """Return the experiment without the rows that show what went on in gaps of its drives."""
    gaps = gaps_that_hide(rows.time, rows.columns, rows.role.drives)
    usable = rows.usable & caught_up(experiment, declared, gaps)
    compared = {name: np.where(usable, values, np.nan)
                for name, values in experiment.measured.items()}
    left_out = [] if usable.all() else [
        f'{int((~usable).sum())} rows in gaps of {" or ".join(rows.role.drives)}, and after them '
        'until the chamber has caught up, are not compared']
    _check_enough(compared, rows.source, *left_out)
    return replace(experiment, measured=compared, notes=(*experiment.notes, *left_out))


def _with_doubt_of_timing(experiment: Experiment, declared: PositionerParameters, source: str
                          ) -> Experiment:
    """Return the experiment with what is not known of when its commands were given."""
    if experiment.is_slow:  # rows after a jump, which would not count, tell how fast it follows
        return experiment
    told = with_sampled_commands(experiment, declared)
    if told is not experiment:
        _check_enough(told.measured, source, *told.notes[-1:])
    return with_noise_of_timing(told, declared) if commands_may_be_late(told) else told


def _current(columns: Mapping[str, Array], role: Roles, quasi_static: bool) -> Array:
    """Return the command that stands from each row to the next."""
    if not role.commanded:
        return np.zeros(len(next(iter(columns.values()))))
    current = columns[role.command]
    current = current[last_known(current)]  # the first row has one
    if quasi_static:
        # a row of a sweep was read after its own current had stood
        return np.append(current[1:], current[-1:])
    return current


def _drive_noise(name: str, sampled: Array, calm: list[slice]) -> DriveNoise:
    """
    Return the noise of a measured drive from its samples, before rows between them are filled.

    Steps between its values do not count: levels at which it stood are no resolution.
    """
    coloured = noise_of(sampled, calm)
    level = coloured.level if coloured.correlation else np.nan_to_num(white_noise(sampled))
    every = round(len(sampled) / np.isfinite(sampled).sum())
    return DriveNoise(max(float(level), LEAST_NOISE[name]), every, coloured.correlation)


def _check_enough(compared: Mapping[str, Array], source: str, *notes: str) -> None:
    rows = max(int(np.isfinite(values).sum()) for values in compared.values())
    if rows < FEWEST:
        raise RecordError(
            '; '.join((f'{source}: only {rows} rows can be compared with the model, at least '
                       f'{FEWEST} are needed', *notes)))


def _with_noise_of_drives(experiment: Experiment, declared: PositionerParameters) -> Experiment:
    """Return the experiment with what the noise of measured drives adds to that of channels."""
    if not experiment.drive_noise:
        return experiment
    # noise on top of noise would move a booster whose two seats differ by another amount
    quiet = replace(experiment, pinned={
        name: uniform_filter1d(values, AVERAGED * experiment.drive_noise[name].every)
        for name, values in experiment.pinned.items()})
    still = quiet.predict(declared)
    moved = quiet.shaken(experiment.drive_noise, np.random.default_rng(1)).predict(declared)
    return replace(experiment, noise={
        name: float(np.hypot(level, np.sqrt(np.nanmean((moved[name] - still[name])**2))))
        for name, level in experiment.noise.items()})
