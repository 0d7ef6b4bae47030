# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""From a cleaned record to an experiment."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import uniform_filter1d

from booster_ros.diagnosis.experiment.calm_pieces import calm_pieces
from booster_ros.diagnosis.experiment.experiment import DriveNoise, Experiment
from booster_ros.diagnosis.experiment.noise import white_noise
from booster_ros.diagnosis.experiment.noise_colour import noise_of
from booster_ros.diagnosis.experiment.roles import Roles, roles
from booster_ros.diagnosis.preparing.gaps import caught_up, gaps_that_hide
from booster_ros.diagnosis.preparing.late_commands import (
    commands_may_be_late, with_noise_of_timing)
from booster_ros.diagnosis.preparing.plausibility import (
    check_bench, check_clock, check_direction, check_drive, check_pressures, check_scales,
    stands_still, without_stuck)
from booster_ros.diagnosis.preparing.reversed_current import check_current
from booster_ros.diagnosis.preparing.sampled_commands import with_sampled_commands
from booster_ros.diagnosis.preparing.start_state import start_state, with_start_of_converter
from booster_ros.model.system import PositionerParameters
from booster_ros.records import Record, RecordError
from booster_ros.records.holding import bridged, last_known
from booster_ros.records.time_axis import longest_usual

Array = np.ndarray

DWELL_PINNED = 0.25
DWELL_FILLED = 30.0
"""How long each row of a sweep without time stands, s: where the chamber pressure drives, only the
stem has to follow; where the current or the back pressure does, the chamber has to fill."""

FEWEST_ROWS = 12
"""Smallest number of rows that must be comparable."""

QUIETING = 25
"""Number of samples of a measured drive that are averaged to see what its noise adds."""

LEAST_NOISE = {'back_pressure': 5.0, 'supply_pressure': 5.0, 'chamber_pressure': 5.0,
               'valve_position': 1e-7, 'mass_flow': 1e-9}
"""
Smallest noise of a channel, in its unit: what the solver leaves on thinned rows, 2 Pa and 0.03 um,
must not count as something that the model lacks. Sensors resolve far less.
"""


@dataclass(frozen=True)
class _Rows:
    """
    The rows of a record that an experiment is made of, by column, SI units.

    `columns` has measured drives filled between their samples, `sampled` has them as they were.
    `time` counts from the first row, at `begins`, s in the record's clock. `usable` rows have known
    drives. `left_out` says what of the record is not there, `notes` that and all else.
    """

    source: str
    columns: dict[str, Array]
    sampled: dict[str, Array]
    role: Roles
    time: Array
    begins: float
    quasi_static: bool
    usable: Array
    left_out: tuple[str, ...]
    notes: tuple[str, ...]


def prepare(
    record: Record, declared: PositionerParameters, dwell: float | None = None
) -> Experiment:
    """
    Return the experiment that is made of a record.

    The most upstream channels drive, the others are compared; rows in and shortly after gaps of
    the drive do not count. A record without time is a quasi-static sweep whose rows last `dwell`
    seconds each. RecordError where nothing can be compared, or values cannot be of this valve.
    """
    rows = _aligned(record, declared, dwell)
    experiment = _experiment(rows, declared)
    if not rows.quasi_static:
        experiment = _without_gaps(experiment, rows, declared)
    experiment = _checked(experiment, declared, rows.source)
    if rows.quasi_static:
        return experiment
    experiment = _with_doubt_of_timing(experiment, declared, rows.source)
    if rows.role.commanded and 'back_pressure' not in rows.columns:
        experiment = with_start_of_converter(experiment, declared)
    return _with_noise_of_drives(experiment, declared)


def _aligned(record: Record, declared: PositionerParameters, dwell: float | None) -> _Rows:
    """Return the rows of a record that can be used, their drives known and on one clock."""
    record, idle = _without_idle_command(record)
    needed = roles(record.columns, record.source, record.ignored).compared
    record, sparse = _without_sparse(record, needed)
    role = roles(record.columns, record.source)
    columns, trimmed = _from_known_start(record, role)
    check_scales(columns, declared, record.source)
    sampled = {name: columns[name] for name in role.pinned}
    time = columns.get('time')
    quasi_static = time is None
    begins = 0.0
    if time is None:
        time = _sweep_time(len(next(iter(columns.values()))), role, dwell)
    else:
        columns |= {name: _between_samples(time, values) for name, values in sampled.items()}
        if time[0] != 0.0:  # what warms up or swings does so from where the record begins
            begins = float(time[0])
            trimmed = (*trimmed, f'time counted from the first row used, at {begins:.9g} s')
            time = time - begins
    return _Rows(
        source=record.source, columns=columns, sampled=sampled, role=role, time=time,
        begins=begins, quasi_static=quasi_static,
        usable=_usable_rows(time, columns, role, quasi_static), left_out=(*sparse, *trimmed),
        notes=(*idle, *sparse, *role.notes, *trimmed, *_sweep_notes(time, quasi_static)))


def _experiment(rows: _Rows, declared: PositionerParameters) -> Experiment:
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
    clouded = [name for name in role.compared if told[name].clouded]
    return Experiment(
        time=time,
        current=current,
        measured=compared,
        noise={name: noise[name] for name in role.compared},
        pinned=pinned,
        initial=start_state({name: values if np.isfinite(values[0]) else _between_samples(
            columns.get('time'), values) for name, values in columns.items()}, declared, noise),
        drive_noise={} if rows.quasi_static else {
            name: _drive_noise(name, values, calm) for name, values in rows.sampled.items()},
        quasi_static=rows.quasi_static,
        begins=rows.begins,
        notes=(*rows.notes, *_colour_notes(calm, rows.quasi_static), *_clouded_notes(clouded)),
    )


def _without_gaps(experiment: Experiment, rows: _Rows, declared: PositionerParameters
                  ) -> Experiment:
    """Return the experiment without the rows that show what went on in gaps of its drives."""
    gaps = gaps_that_hide(rows.time, rows.columns, rows.role.drives)
    usable = rows.usable & caught_up(experiment, declared, gaps)
    compared = {name: np.where(usable, values, np.nan)
                for name, values in experiment.measured.items()}
    left_out = _gap_notes(usable, rows.role)
    _check_enough(compared, rows.source, *left_out)
    return replace(experiment, measured=compared, notes=(*experiment.notes, *left_out))


def _checked(experiment: Experiment, declared: PositionerParameters, source: str) -> Experiment:
    """
    Return the experiment without channels that are stuck, those that stand still noted.

    RecordError where its values cannot be of this valve.
    """
    check_drive(experiment, declared, source)
    check_bench(experiment, declared, source)
    if not experiment.quasi_static:
        check_clock(experiment, declared, source)
    check_pressures(experiment, declared, source)
    check_current(experiment, declared, source)
    check_direction(experiment, declared, source)
    experiment = without_stuck(experiment, declared, source)
    return replace(experiment, notes=(*experiment.notes, *_still_notes(experiment.measured)))


def _with_doubt_of_timing(experiment: Experiment, declared: PositionerParameters, source: str
                          ) -> Experiment:
    """Return the experiment with what is not known of when its commands were given."""
    told = with_sampled_commands(experiment, declared)
    if told is not experiment:
        _check_enough(told.measured, source, *told.notes[-1:])
        return told
    if commands_may_be_late(experiment):
        return with_noise_of_timing(experiment, declared)
    return experiment


def _without_idle_command(record: Record) -> tuple[Record, tuple[str, ...]]:
    """Return the record of a sweep without a current that is 0 in every row that is compared."""
    current = record.columns.get('control_current')
    if current is None or 'time' in record or np.any(np.nan_to_num(current[1:])):
        return record, ()
    others = {name: values for name, values in record.columns.items() if name != 'control_current'}
    return replace(record, columns=others), (
        'control_current is 0 A in every row that a sweep is compared in: it did not drive it',)


def _without_sparse(record: Record, compared: Collection[str]) -> tuple[Record, tuple[str, ...]]:
    """Return the record without channels of too few values to compare, if others have enough."""
    counts = {name: int(np.isfinite(record[name]).sum()) for name in compared}
    sparse = {name: count for name, count in counts.items() if count < FEWEST_ROWS}
    if len(sparse) == len(counts):
        return record, ()
    others = {name: values for name, values in record.columns.items() if name not in sparse}
    return replace(record, columns=others), tuple(
        f'{name} is not compared: it has {count} of the {FEWEST_ROWS} values needed'
        for name, count in sparse.items())


def _from_known_start(
    record: Record, role: Roles
) -> tuple[dict[str, Array], tuple[str, ...]]:
    """Return the columns from the first row with drives and start to the last row with drives."""
    drives = list(role.drives)
    needed = drives + [name for name in ('chamber_pressure',) if name in role.compared]
    time = record.columns.get('time')
    known = {name: np.isfinite(record[name] if name == 'control_current' else
                               _between_samples(time, record[name])) for name in needed}
    driven, started = (np.all([known[name] for name in names], axis=0)
                       if names else np.ones(len(record), dtype=bool) for names in (drives, needed))
    if not started.any():
        raise RecordError(f'{record.source}: no row has all of {", ".join(needed)}')
    first, last = int(np.argmax(started)), len(record) - int(np.argmax(driven[::-1]))
    columns = {name: np.asarray(values[first:last]) for name, values in record.columns.items()}
    return columns, (*_left_out(record, needed, 0, first), *_left_out(record, drives, last, None))


def _left_out(record: Record, needed: list[str], first: int, last: int | None) -> tuple[str, ...]:
    """Return a sentence on the rows at an end that were left out, if any."""
    rows = record.rows[first:last]
    if not len(rows):
        return ()
    lacking = [name for name in needed if not np.isfinite(record[name][first:last]).all()]
    return (f'rows {rows[0]} to {rows[-1]} left out: they lack {" or ".join(lacking)}',)


def _sweep_time(rows: int, role: Roles, dwell: float | None) -> Array:
    step = dwell or (DWELL_PINNED if 'chamber_pressure' in role.pinned else DWELL_FILLED)
    return step * np.arange(rows)


def _usable_rows(
    time: Array, columns: Mapping[str, Array], role: Roles, quasi_static: bool
) -> Array:
    """Return which rows have known drives that, in a sweep, were dwelt on."""
    usable = np.ones(len(time), dtype=bool)
    if not role.drives:
        return usable
    for name in role.drives:
        usable &= np.isfinite(columns[name])
    if quasi_static:
        # a sweep of currents starts settled at its first one; only later ones were dwelt on
        usable[0] &= not role.commanded
    return usable


def _current(columns: Mapping[str, Array], role: Roles, quasi_static: bool) -> Array:
    """Return the current that stands from each row to the next."""
    if not role.commanded:
        return np.zeros(len(next(iter(columns.values()))))
    current = columns['control_current']
    current = current[last_known(current)]  # the first row has one
    if quasi_static:
        # a row of a sweep was read after its own current had stood
        return np.append(current[1:], current[-1:])
    return current


def _drive_noise(name: str, sampled: Array, calm: list[slice]) -> DriveNoise:
    """
    Return the noise of a measured drive from its samples, before rows between them are filled.

    The steps between its values do not count: levels at which it stood are no resolution.
    """
    coloured = noise_of(sampled, calm)
    level = coloured.level if coloured.correlation else np.nan_to_num(white_noise(sampled))
    every = round(len(sampled) / np.isfinite(sampled).sum())
    return DriveNoise(max(float(level), LEAST_NOISE[name]), every, coloured.correlation)


def _between_samples(time: Array | None, values: Array) -> Array:
    """Return values sampled more slowly than the rows, filled except in gaps of their own."""
    if time is None:
        return values
    known = time[np.isfinite(values)]
    if len(known) < 3:
        return values
    after = np.searchsorted(known, time).clip(1, len(known) - 1)
    near = known[after] - known[after - 1] <= longest_usual(np.diff(known))
    near &= (time >= known[0]) & (time <= known[-1])
    return np.where(near | np.isfinite(values), bridged(time, values), np.nan)


def _check_enough(compared: Mapping[str, Array], source: str, *notes: str) -> None:
    rows = max(int(np.isfinite(values).sum()) for values in compared.values())
    if rows < FEWEST_ROWS:
        raise RecordError(
            '; '.join((f'{source}: only {rows} rows can be compared with the model, at least '
                       f'{FEWEST_ROWS} are needed', *notes)))


def _sweep_notes(time: Array, quasi_static: bool) -> tuple[str, ...]:
    if not quasi_static:
        return ()
    return (f'no time: read as a quasi-static sweep in row order, {time[1] - time[0]:g} s a row',)


def _colour_notes(calm: Sequence[slice], quasi_static: bool) -> tuple[str, ...]:
    if quasi_static or calm:
        return ()
    return ('what drives the valve hardly rests, nor moves smoothly for long: noise is taken as '
            'white, as its colour shows there alone; where a sensor is damped there is more of it, '
            'up to several times, and what seems to be missed may be noise',)


def _clouded_notes(clouded: Sequence[str]) -> tuple[str, ...]:
    if not clouded:
        return ()
    return (f'the noise of {" and ".join(clouded)} is taken as white: where the drives are calm, '
            'the valve still moves (slips, hunting, a supply that ripples), which hides how noise '
            'carries over from row to row; where a sensor is damped there is more of it than is '
            'said here',)


def _gap_notes(usable: Array, role: Roles) -> tuple[str, ...]:
    if usable.all():
        return ()
    return (f'{int((~usable).sum())} rows in gaps of {" or ".join(role.drives)}, and after them '
            'until the chamber has caught up, are not compared',)


def _still_notes(compared: Mapping[str, Array]) -> tuple[str, ...]:
    return tuple(f'{name} stands still: every row has the same value'
                 for name, values in compared.items() if stands_still(values))


def _with_noise_of_drives(experiment: Experiment, declared: PositionerParameters) -> Experiment:
    """Return the experiment with what the noise of measured drives adds to that of channels."""
    if not experiment.drive_noise:
        return experiment
    # noise on top of noise would move a booster whose two seats differ by another amount
    quiet = replace(experiment, pinned={
        name: uniform_filter1d(values, QUIETING * experiment.drive_noise[name].every)
        for name, values in experiment.pinned.items()})
    still = quiet.predict(declared)
    moved = quiet.shaken(experiment.drive_noise, np.random.default_rng(1)).predict(declared)
    return replace(experiment, noise={
        name: float(np.hypot(level, np.sqrt(np.nanmean((moved[name] - still[name])**2))))
        for name, level in experiment.noise.items()})
