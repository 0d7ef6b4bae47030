# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The course of the variable that a term without a name follows, over a run or a record."""

from collections.abc import Mapping

import numpy as np

from booster_ros.diagnosis.data.experiment import Experiment, Initial
from booster_ros.diagnosis.estimation.fit import Fit
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.model import discrepancy as term
from booster_ros.model.booster import diaphragm_force
from booster_ros.model.discrepancy import Discrepancy, past_at_rest, place_in_play
from booster_ros.model.ep_converter import (
    QUICKEST, play, settled_back_pressure, times_as_slow)
from booster_ros.model.sensors import lagged
from booster_ros.model.stream import delayed_current
from booster_ros.model.system import PAST_UNIT, PositionerParameters
from booster_ros.records.holding import bridged

Array = np.ndarray

STRAY = 0.002
"""Share of the rows at either end of a variable that may be stray."""

MUCH_SLOWER = 1.0 / times_as_slow(QUICKEST)
"""How many times as slow a converter is taken to be, at the most, where it is asked how far its
back pressure may have to go: about ten."""


def followed(p: PositionerParameters, time: Array, columns: Mapping[str, Array], past: float = 0.0
             ) -> Array:
    """
    Return the variable of the term in these parameters over time (s), shape (n,).

    `columns` are channels of a run or a record. For a change, they must include the variable that
    changes; for a play of the booster's force, all pressures that make up that force; for the error
    of the back pressure, that pressure and all that it follows. `past` is that of the start's
    `Departure`. A change of the current is that of the current as given, which a dead time or a
    hysteresis hides from the model for a while; the error is that of the current behind these.
    """
    table = p.discrepancy
    if table.variable == term.BACK_PRESSURE_ERROR:
        return _errors(p, time, columns)
    if term.has_play(table):
        return _places_in_play(p, columns, past * PAST_UNIT[term.FORCE_PLAY])
    if table.variable not in term.CHANGE_OF:
        return columns[term.VARIABLES[table.variable]]
    now = columns[term.VARIABLES[term.CHANGE_OF[table.variable]]]
    remembered = np.empty(len(now))
    remembered[0] = now[0] + past * PAST_UNIT[table.variable]
    stands = table.variable == term.CURRENT_CHANGE  # a command stands until the next
    for k in range(1, len(now)):
        step, end = time[k] - time[k - 1], now[k - 1] if stands else now[k]
        remembered[k] = remembered[k - 1] if step <= 0.0 else lagged(
            remembered[k - 1], now[k - 1], end, table.memory, step)
    return now - remembered


def _errors(p: PositionerParameters, time: Array, columns: Mapping[str, Array]) -> Array:
    """Return how far the back pressure still has to go row by row, Pa, shape (n,)."""
    ep, errors = p.ep_converter, np.empty(len(time))
    rows = np.column_stack([
        time, delayed_current(time, columns['control_current'], ep.dead_time),
        columns['supply_pressure'], columns['back_pressure']])
    seen = float(rows[0, 1])
    for k, (now, current, supply, back) in enumerate(rows.tolist()):
        seen = play(seen, current, ep.hysteresis)
        errors[k] = settled_back_pressure(ep, seen, supply, now, 0.0) - back
    return errors


def _places_in_play(p: PositionerParameters, columns: Mapping[str, Array], past: float) -> Array:
    """Return where in its play the booster's force stands row by row, -1 to 1, shape (n,)."""
    pressures = np.column_stack(
        [columns[name] for name in ('back_pressure', 'outlet_pressure', 'supply_pressure')])
    places = np.empty(len(pressures))
    for k, (back, outlet, supply) in enumerate(pressures.tolist()):
        force = diaphragm_force(p.booster, back, outlet, supply)
        if k == 0:
            past += past_at_rest(p.discrepancy, force)
        places[k] = place_in_play(p.discrepancy, past, force)
        past = force - p.discrepancy.reach * places[k]
    return np.clip(places, -1.0, 1.0)  # but for rounding they are


def beyond(seen: tuple[float, float], experiment: Experiment, p: PositionerParameters,
           initial: Initial) -> Array:
    """Tell of each row, shape (n,), whether a run takes the variable of its term beyond `seen`."""
    run = experiment.simulate(p, initial)
    course = followed(p, experiment.time, run.columns, initial.departure.past)
    return (course < seen[0]) | (course > seen[1])


def range_followed(problem: Problem, reference: Fit, table: Discrepancy, seen: Array) -> Array:
    """Return the lowest and the highest value of a term's variable, but for stray ones."""
    if table.variable == term.BACK_PRESSURE_ERROR:
        p = reference.parameters._replace(discrepancy=table)
        ways = np.concatenate([_simulated_errors(problem.experiment, p, slower)[seen]
                               for slower in (1.0, MUCH_SLOWER)])
        return np.array([np.nanmin(ways), np.nanmax(ways)])
    values = _course(problem.experiment, reference, table, seen)[seen]
    if table.location in (term.PRESSURE_SENSOR, term.POSITION_SENSOR):
        given = problem.parameters(problem.start())
        run = problem.experiment.simulate(given, reference.initial)
        read = followed(given._replace(discrepancy=table), run['time'], run.columns)
        values = np.r_[values, read[seen]]
    return np.quantile(values[np.isfinite(values)], [STRAY, 1.0 - STRAY])


def _simulated_errors(experiment: Experiment, p: PositionerParameters, slower: float) -> Array:
    """
    Return how far the back pressure has to go, Pa, shape (n,), if the lag is so many times as long.

    The error is no reading. It is the height of a step whatever the lag, but on a ramp it grows
    with the lag that is to be found.
    """
    ep = p.ep_converter
    p = p._replace(ep_converter=ep._replace(time_constant=slower * ep.time_constant))
    # the start of a fit without the term may have gone far to imitate it
    run = experiment.simulate(p, experiment.initial)
    return followed(p, experiment.time, run.columns)


def _course(experiment: Experiment, reference: Fit, table: Discrepancy, seen: Array) -> Array:
    """
    Return the variable of a term as measured, or as simulated where no row `seen` has a reading.

    For a change, the variable that changes runs straight across a gap.
    """
    name = term.VARIABLES[term.CHANGE_OF.get(table.variable, table.variable)]
    values = experiment.measured.get(name)
    if values is None or not np.isfinite(values[seen]).any():
        values = experiment.simulate(reference.parameters, reference.initial)[name]
    elif table.variable in term.CHANGE_OF:
        values = bridged(experiment.time, values)
    p = reference.parameters._replace(discrepancy=table)
    return followed(p, experiment.time, {name: np.asarray(values)})
