# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""All figures of a record, and the segments that they come from."""

from typing import Any, NamedTuple

import numpy as np

from booster_ros.records import Record, RecordError

from .dead_band import Bound, Offset, Reversal, bounds_of_steps, hysteresis, reversals
from .segments import Course, levels, noise_level, ramps
from .step_response import StepResponse, step_responses
from .stick_slip import LimitCycle, limit_cycles, stick_slip_index

FEWEST_ROWS = 12
"""Rows with set point and position that a record must have."""

COLUMNS = ('time', 'set_point', 'valve_position')


class RampFigure(NamedTuple):
    """Index of stick-slip over a ramp: its rows, its rate, m/s."""

    first: int
    last: int
    rate: float
    jumpiness: float


class Figures(NamedTuple):
    """
    The figures of a record; rows are those of its file.

    `noise` is the standard deviation of that of the position, m; `dead_band` and `resolution` are
    what steps tell of these, `turns` what ramps tell of the dead band.
    """

    noise: float
    steps: tuple[StepResponse, ...]
    dead_band: Bound
    resolution: Bound
    turns: tuple[Reversal, ...]
    hysteresis: Offset | None
    limit_cycles: tuple[LimitCycle, ...]
    ramps: tuple[RampFigure, ...]


def course_of(record: Record) -> tuple[Course, np.ndarray]:
    """
    Return set point and position where both are known, and the rows in the file.

    RecordError where the record lacks one of the columns, or has too few such rows.
    """
    for name in COLUMNS:
        if name not in record:
            raise RecordError(
                f'{record.source}: there is no column {name}; figures of a valve need '
                f'{", ".join(COLUMNS)}')
    known = np.isfinite(record['set_point']) & np.isfinite(record['valve_position'])
    if known.sum() < FEWEST_ROWS:
        raise RecordError(
            f'{record.source}: {int(known.sum())} rows have both set_point and valve_position, '
            f'{FEWEST_ROWS} are needed')
    return Course(*(record[name][known] for name in COLUMNS)), record.rows[known]


def figures_of(record: Record) -> Figures:
    """Return the figures of a record; RecordError as `course_of`."""
    course, rows = course_of(record)
    noise = noise_level(course)
    found = levels(course)
    running = ramps(course, found)
    responses = step_responses(course, found, noise)
    dead_band, resolution = bounds_of_steps(responses)
    delays = [one.dead_time for one in responses if one.settled and one.dead_time is not None]
    turns = reversals(course, running, noise, float(np.median(delays)) if delays else 0.0)
    slow = []
    for ramp in running:
        part = slice(ramp.first, ramp.last + 1)
        jumpiness = stick_slip_index(course.time[part], course.position[part], noise)
        if jumpiness is not None:
            slow.append(RampFigure(
                int(rows[ramp.first]), int(rows[ramp.last]), ramp.rate, jumpiness))

    def in_file(places: tuple[int, ...]) -> tuple[int, ...]:
        return tuple(int(rows[place]) for place in places)

    return Figures(
        noise,
        tuple(one._replace(first=int(rows[one.first]), last=int(rows[one.last]))
              for one in responses),
        dead_band._replace(rows=in_file(dead_band.rows)),
        resolution._replace(rows=in_file(resolution.rows)),
        tuple(one._replace(row=int(rows[one.row])) for one in turns),
        hysteresis(responses),
        tuple(one._replace(first=int(rows[one.first]), last=int(rows[one.last]))
              for one in limit_cycles(course, found, noise)),
        tuple(slow))


def as_plain(figures: Figures) -> dict[str, Any]:
    """Return the figures as lists, numbers and names, for JSON; SI units."""

    def plain(value: Any) -> Any:
        if hasattr(value, '_asdict'):
            return {name: plain(item) for name, item in value._asdict().items()}
        return [plain(item) for item in value] if isinstance(value, tuple) else value

    return {'version': 1, **plain(figures)}
