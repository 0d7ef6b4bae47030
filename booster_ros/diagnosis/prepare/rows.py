# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""From a cleaned record to the rows that an experiment is made of, on one clock."""

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np

from booster_ros.diagnosis.data.experiment import FEWEST, Array
from booster_ros.diagnosis.data.roles import Roles, roles
from booster_ros.diagnosis.prepare.plausibility import check_scales
from booster_ros.model.actuator import VESSEL
from booster_ros.model.system import PositionerParameters
from booster_ros.records import Record, RecordError
from booster_ros.records.holding import between_samples

DWELL_PINNED = 0.25
DWELL_FILLED = 30.0
"""How long each row of a sweep without time stands, s: where the chamber pressure drives, the stem
has to follow; else the chamber has to fill."""

CLOSEST_ROWS = 1e-6
"""Time from row to row, s, below which no valve is recorded: it is of another unit."""

LONGEST_RUN = 7 * 86400.0
"""Longest time of a record, a week in s: a run takes seconds, a diagnosis hundreds of runs."""

LONGEST_GAP = 3600.0
"""A gap longer than this, s, and than all the rest of a record leaves nothing to go on from."""


@dataclass(frozen=True)
class Rows:
    """
    The rows of a record that an experiment is made of, by column, SI units.

    `columns` has measured drives filled between their samples, `sampled` has them as they were.
    `time` counts from `begins`, s in the record's clock. `usable` rows have known drives.
    `left_out` says what of the record is not there, `notes` that and all else.
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


def aligned(record: Record, declared: PositionerParameters, dwell: float | None) -> Rows:
    """
    Return the rows of a record that can be used, their drives known and on one clock.

    RecordError where the record or its time is such that no run of the model over it would help.
    """
    if len(record) < FEWEST:
        raise RecordError(
            f'{record.source}: only {len(record)} row{"s" if len(record) > 1 else ""}, at least '
            f'{FEWEST} are needed')
    if 'time' in record:
        _check_time(record)
    beside = _beside(record, declared)
    record = _without(record, beside)
    needed = roles(record.columns, record.source, (*record.ignored, *beside.values())).compared
    sparse = _sparse(record, needed)
    record = _without(record, sparse)
    role = roles(record.columns, record.source)
    columns, trimmed = _from_known_start(record, role)
    check_scales(columns, declared, record.source)
    sampled = {name: columns[name] for name in role.pinned}
    time = columns.get('time')
    quasi_static = time is None
    begins = 0.0
    if time is None:
        step = dwell or (DWELL_PINNED if 'chamber_pressure' in role.pinned else DWELL_FILLED)
        time = step * np.arange(len(next(iter(columns.values()))))
        trimmed = (*trimmed, 'no time: read as a quasi-static sweep in row order, '
                   f'{step:g} s a row')
        check_length(time, record.source, swept=True)
    else:
        columns |= {name: between_samples(time, values) for name, values in sampled.items()}
        if time[0] != 0.0:  # what warms up or swings does so from where the record begins
            begins = float(time[0])
            trimmed = (*trimmed, f'time counted from the first row used, at {begins:.9g} s')
            time = time - begins
    usable = np.ones(len(time), dtype=bool)
    for name in role.drives:
        usable &= np.isfinite(columns[name])
    if quasi_static:  # it starts settled at its first current; only later ones were dwelt on
        usable[0] &= not role.commanded
    return Rows(
        source=record.source, columns=columns, sampled=sampled, role=role, time=time,
        begins=begins, quasi_static=quasi_static, usable=usable,
        left_out=(*sparse.values(), *trimmed),
        notes=(*beside.values(), *sparse.values(), *role.notes, *trimmed))


def _without(record: Record, names: Collection[str]) -> Record:
    """Return the record without these columns."""
    return replace(record, columns={
        name: values for name, values in record.columns.items() if name not in names})


def _beside(record: Record, declared: PositionerParameters) -> dict[str, str]:
    """Return what is said of columns that drive nothing: a set point beside a current is idle."""
    idle = {} if declared.actuator.kind != VESSEL else {
        'pressure_drop': 'a vessel has no stem that the process could push'}
    if {'control_current', 'back_pressure'} & {*record.columns} or 'time' not in record:
        idle['set_point'] = 'what lies downstream of it is recorded'
    elif not declared.position_controller.enabled:
        idle['set_point'] = ('position_controller.enabled: true in the parameters, with its '
                             'tuning, lets it drive the model')
    return {name: f'{name} is read and not used: {why}'
            for name, why in idle.items() if name in record}


def _check_time(record: Record) -> None:
    """Raise RecordError where rows are closer than a valve's, or a gap is longer than all else."""
    time = record['time']
    steps = np.diff(time)
    if np.median(steps) < CLOSEST_ROWS:
        raise RecordError(
            f'{record.source}, column time: rows are {np.median(steps):.3g} s apart, and no valve '
            'is recorded so: time must be in s')
    longest = int(np.argmax(steps))
    if LONGEST_GAP < steps[longest] > 0.5 * (time[-1] - time[0]):
        raise RecordError(
            f'{record.source}, row {record.rows[longest + 1]}, column time: a gap of '
            f'{steps[longest]:.4g} s, longer than all the rest of the record: make two records of '
            'it, one before and one behind the gap')


def check_length(time: Array, source: str, swept: bool = False) -> None:
    """Raise RecordError where one run of the model over these times, s, would take minutes."""
    if time[-1] - time[0] > LONGEST_RUN:
        column, remedy = ('', 'a sweep needs fewer rows, any other record the column time') \
            if swept else (', column time', 'time must be in s, or cut the record')
        raise RecordError(
            f'{source}{column}: lasts {time[-1] - time[0]:.3g} s, and no more than '
            f'{LONGEST_RUN:g} s are compared with the model: {remedy}')


def _sparse(record: Record, compared: Collection[str]) -> dict[str, str]:
    """Return what is said of channels of too few values to compare, if others have enough."""
    counts = {name: int(np.isfinite(record[name]).sum()) for name in compared}
    sparse = {name: f'{name} is not compared: it has {count} of the {FEWEST} values needed'
              for name, count in counts.items() if count < FEWEST}
    return sparse if len(sparse) < len(counts) else {}


def _from_known_start(record: Record, role: Roles) -> tuple[dict[str, Array], tuple[str, ...]]:
    """Return the columns from the first row with drives and start to the last row with drives."""
    drives = list(role.drives)
    needed = drives + [name for name in ('chamber_pressure',) if name in role.compared]
    time = record.columns.get('time')
    known = {name: np.isfinite(record[name] if name == role.command else
                               between_samples(time, record[name])) for name in needed}
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
