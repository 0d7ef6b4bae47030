# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The friction of a stem that slips, read off a record.

Model: the force on the stem that the chamber pressure leaves beside spring, seat and process,

    F = A(x) p - F_spring(x) - c dx/dt,

is what dry friction holds. While a stem creeps one way in slips, F rises until the stem breaks away
and falls as it slips: a saw, whose upper end is the break-away friction. Its lower end lies at the
sliding friction or below, as a stem that slips goes beyond where it would come to rest.

1. take the rows around which the stem goes the same way before and after, further than noise;
2. mean and variance of F there, less the variance that noise makes, are those of a saw, which is
   spread evenly: its ends are sqrt(3) standard deviations from the mean;
3. take the average over both ways: a spring that is preloaded otherwise moves the two apart.

When single slips come does not matter to that, nor what lies above the stem.
(Stick-slip of a slowly driven mass: B. Armstrong-Helouvry et al., Automatica 30 (1994) 1083.)
"""

from typing import NamedTuple

import numpy as np

from booster_ros.diagnosis.fitting.fit import Problem
from booster_ros.model.actuator import (
    friction_along_travel, lower_stop, stem_force, upper_stop)
from booster_ros.model.sensors import position_behind, pressure_behind
from booster_ros.model.system import PositionerParameters

Array = np.ndarray

BESIDE = 0.4
"""Time before and after a row, s, over which the stem has to go the same way."""

BEYOND_NOISE = 6.0
"""How far it has to go in that time, in standard deviations of the position's noise."""

FEWEST = 30
"""Number of rows, one way, below which nothing is read."""


class Saw(NamedTuple):
    """Lowest and highest force on a stem that goes one way, N: sliding, and breaking away."""

    low: float
    high: float


def read_saw(problem: Problem, z: Array) -> Saw | None:
    """
    Return the saw of the rows that count, with all but friction as it is at z.

    None where pressure or position was not measured, or where too few rows show the stem go.
    """
    ends = []
    for way in (1.0, -1.0):
        rows, speed = _going(problem, z, way)
        if np.count_nonzero(rows) >= FEWEST:
            ends.append(_one_way(problem, z, way, rows, speed[rows]))
    return Saw(*np.mean(ends, axis=0)) if ends else None


def rows_going(problem: Problem, z: Array) -> Array:
    """Return the rows that count around which the stem goes, either way, as a mask."""
    return _going(problem, z, 1.0)[0] | _going(problem, z, -1.0)[0]


def _going(problem: Problem, z: Array, way: float) -> tuple[Array, Array]:
    """Return the rows around which the stem goes this way, as a mask, and its mean speed, m/s."""
    experiment, p = problem.experiment, problem.parameters(z)
    time = experiment.time
    if not {'chamber_pressure', 'valve_position'} <= set(experiment.measured):
        return np.zeros(len(time), dtype=bool), np.zeros(len(time))
    position = _position(problem, p)
    known = np.isfinite(position)
    earlier, later = (np.interp(time + beside, time[known], position[known])
                      for beside in (-BESIDE, BESIDE)) if known.any() else (position, position)
    least = BEYOND_NOISE * experiment.noise['valve_position']
    off_its_stops = (
        (position > lower_stop(p.actuator) + least) & (position < upper_stop(p.actuator) - least))
    rows = (problem.rows & off_its_stops & np.isfinite(experiment.measured['chamber_pressure'])
            & (way * (position - earlier) > least) & (way * (later - position) > least))
    return rows, (later - earlier) / (2.0 * BESIDE)


def _one_way(problem: Problem, z: Array, way: float, rows: Array, speed: Array) -> Saw:
    """Return the saw of these rows, around which the stem goes one way at these speeds, m/s."""
    experiment, p = problem.experiment, problem.parameters(z)
    act, noise = p.actuator, experiment.noise
    readings, position = experiment.measured['chamber_pressure'][rows], _position(problem, p)[rows]
    held = np.array([
        way * stem_force(act, pressure_behind(p.sensors, reading), x, v, 0.0)
        - friction_along_travel(act, x) for reading, x, v in zip(readings, position, speed)])
    rate = (act.bench_set[1] - act.bench_set[0]) / act.travel
    blurred = act.effective_area * np.hypot(
        noise['chamber_pressure'], rate * noise['valve_position'])
    reach = float(np.sqrt(3.0 * max(np.var(held) - blurred**2, 0.0)))
    middle = float(np.mean(held))
    return Saw(max(middle - reach, 0.0), max(middle + reach, 0.0))


def _position(problem: Problem, p: PositionerParameters) -> Array:
    """Return the position of the stem behind each reading, m."""
    return np.array([
        position_behind(p.sensors, x) for x in problem.experiment.measured['valve_position']])
