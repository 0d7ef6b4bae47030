# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Where fits of dry friction begin: from the valve signature, then over a grid.

The force on the stem that the chamber pressure leaves beside spring, seat and process,

    F = A(x) p - F_spring(x) - c dx/dt,

is what dry friction holds. While a stem creeps one way in slips, F rises until the stem breaks away
and falls as it slips: a saw-tooth, whose upper end is the break-away friction; how far it falls
below that hangs on how far it slips. Its moments give the upper end (method of moments): of a saw,
which is spread evenly, it is sqrt(3) standard deviations from the mean; the average over both
directions takes out a spring that is preloaded otherwise.

The statistics of windows have several minima over friction. So sliding friction and stiction are
tried over a grid, with break-away friction as the moments have it among them, for a packing that
yields and for one that does not; each trial takes one run of the model.
(Stick-slip of a slowly driven mass: B. Armstrong-Helouvry et al., Automatica 30 (1994) 1083.)
"""

from collections.abc import Iterable

import numpy as np

from booster_ros.diagnosis.data.experiment import FEWEST
from booster_ros.diagnosis.estimation.parallel import side_by_side
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.model.actuator import (
    Actuator, friction_along_travel, lower_stop, process_force, stem_force, upper_stop)
from booster_ros.model.scaling import proportion
from booster_ros.model.sensors import position_behind, pressure_behind

Array = np.ndarray

_DAMPING = 'actuator.presliding_damping'

BESIDE = 0.4
"""Time before and after a row, s, over which the stem has to go the same way: some slips."""

BEYOND_NOISE = 6.0
"""How far it has to go in that time, in standard deviations of the position's noise."""

SLIDING = (75.0, 150.0, 300.0, 600.0, 1200.0)
"""Values of sliding friction that are tried, N, in a valve of the paper's size: each twice the one
before, as closer trials reach half of the way to the next."""

BREAKING_AWAY = (0.0, 0.2, 0.4, 0.8)
"""Values of stiction that are tried, as shares of the sliding friction."""

DAMPINGS = (0.0, 0.3, 0.6)
"""Damping of a packing that is tried, as shares of the critical one, 0 for one that does not yield:
a descent does not get from much damping to little, as damping and viscous friction trade."""

KEPT, CLOSER = 3, (0.06, 0.03, 0.015)
"""Number of best trials around which closer ones follow, and the steps of these, round by round, as
shares of the sliding friction; those of the stiction are twice as long."""

_Trial = tuple[float, float, float]


def friction_starts(problem: Problem, z: Array) -> list[Array]:
    """
    Return where to begin with dry friction, all else as it is at z; z alone if none is free.

    The best of a grid over sliding friction, stiction and damping, to which the break-away friction
    of the signature adds a value, and of closer trials around them. The start is as given.
    """
    if not any(free.knob.rubs for free in problem.freedoms):
        return [z]

    def tried(trials: Iterable[_Trial]) -> list[tuple[float, _Trial]]:
        several = list(dict.fromkeys(trials))
        costs = side_by_side(lambda one: problem.cost(_placed(problem, z, *one)), several)
        return sorted(zip(costs, several))[:KEPT]

    larger = proportion(problem.base, 'actuator', 'N')
    forces = [(larger * force, share) for force in SLIDING for share in BREAKING_AWAY]
    read = break_away_friction(problem, z)
    if read is not None:
        forces += [(read / (1.0 + share), share) for share in BREAKING_AWAY]
    yields = any(free.knob.parameter == _DAMPING for free in problem.freedoms)
    best = tried((*one, damping) for one in forces for damping in DAMPINGS[:None if yields else 1])
    for step in CLOSER:
        best = tried((force * (1.0 + step * j), max(share + 2.0 * step * k, 0.0), damping)
                     for _, (force, share, damping) in best
                     for j in (-2, -1, 0, 1, 2) for k in (-1, 0, 1))
    return [_placed(problem, z, *one) for _, one in best]


def _placed(problem: Problem, z: Array, sliding: float, share: float, damping: float) -> Array:
    """
    Return z with this sliding friction (N), stiction (a share of it) and damping.

    The start is as given, all other shapes of the packing become typical.
    """
    moved = z.copy()
    moved[len(problem.freedoms):] = 0.0
    for j, free in enumerate(problem.freedoms):
        typical = free.knob.typical
        values = {'actuator.stiction': share * sliding,
                  'actuator.presliding_stiffness': typical if damping else 0.0,
                  _DAMPING: damping or typical, 'actuator.stribeck_velocity': typical}
        if free.knob.rubs:
            moved[j] = free.variable(sliding)
        elif free.knob.parameter in values:
            moved[j] = free.variable(values[free.knob.parameter])
    return np.clip(moved, *problem.bounds())


def break_away_friction(problem: Problem, z: Array) -> float | None:
    """
    Return the break-away friction of the counted rows, N, with all else as it is at z.

    None where pressure or position was not measured, or where too few rows show the stem go.
    """
    experiment, p = problem.experiment, problem.parameters(z)
    if not {'chamber_pressure', 'valve_position'} <= set(experiment.measured):
        return None
    readings = experiment.measured['valve_position']
    drops = experiment.pinned.get('pressure_drop', np.zeros(len(readings)))
    position = np.array([position_behind(p.sensors, x) for x in readings])
    ends = []
    for way in (1.0, -1.0):
        rows, speed = _rows_going(problem, position, p.actuator, way)
        if np.count_nonzero(rows) < FEWEST:
            continue
        held = way * process_force(p.actuator, drops[rows]) + np.array([
            way * stem_force(p.actuator, pressure_behind(p.sensors, reading), x, v, 0.0)
            - friction_along_travel(p.actuator, x) for reading, x, v in zip(
                experiment.measured['chamber_pressure'][rows], position[rows], speed[rows])])
        low, high = p.actuator.bench_set
        blurred = p.actuator.effective_area * np.hypot(
            experiment.noise['chamber_pressure'],
            (high - low) / p.actuator.travel * experiment.noise['valve_position'])
        reach = np.sqrt(3.0 * max(np.var(held) - blurred**2, 0.0))
        ends.append(max(float(np.mean(held) + reach), 0.0))
    return float(np.mean(ends)) if np.any(ends) else None


def _rows_going(problem: Problem, position: Array, act: Actuator, way: float
                ) -> tuple[Array, Array]:
    """Return the rows around which the stem goes this way, as a mask, and its mean speed, m/s."""
    experiment, known = problem.experiment, np.isfinite(position)
    time = experiment.time
    earlier, later = (np.interp(time + beside, time[known], position[known])
                      for beside in (-BESIDE, BESIDE)) if known.any() else (position, position)
    least = BEYOND_NOISE * experiment.noise['valve_position']
    rows = (problem.rows & (position > lower_stop(act) + least)
            & (position < upper_stop(act) - least)
            & np.isfinite(experiment.measured['chamber_pressure'])
            & (way * (position - earlier) > least) & (way * (later - position) > least))
    return rows, (later - earlier) / (2.0 * BESIDE)
