# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How far the variable that a term without a name follows goes in a record, and beyond it."""

import numpy as np

from booster_ros.diagnosis.data.experiment import Experiment, Initial
from booster_ros.diagnosis.estimation.fit import Fit
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.model import discrepancy as term
from booster_ros.model.discrepancy import Discrepancy
from booster_ros.model.ep_converter import QUICKEST, times_as_slow
from booster_ros.model.system import PositionerParameters
from booster_ros.model.term_course import followed
from booster_ros.records.holding import bridged

Array = np.ndarray

MUCH_SLOWER = times_as_slow(-QUICKEST)
"""How many times as slow a converter is taken to be, at the most, where it is asked how far its
back pressure may have to go: about ten."""


def beyond(seen: tuple[float, float], experiment: Experiment, p: PositionerParameters,
           initial: Initial) -> Array:
    """Tell of each row, shape (n,), whether a run takes the variable of its term beyond `seen`."""
    run = experiment.simulate(p, initial)
    course = followed(p, experiment.time, run.columns, initial.departure.past)
    return (course < seen[0]) | (course > seen[1])


def range_followed(problem: Problem, reference: Fit, table: Discrepancy, seen: Array) -> Array:
    """Return the lowest and the highest value of a term's variable."""
    if table.variable == term.BACK_PRESSURE_ERROR:
        p = reference.parameters._replace(discrepancy=table)
        values = np.concatenate([_simulated_errors(problem.experiment, p, slower)[seen]
                                 for slower in (1.0, MUCH_SLOWER)])
    else:
        values = _course(problem.experiment, reference, table, seen)[seen]
    if table.location in (term.PRESSURE_SENSOR, term.POSITION_SENSOR):
        given = problem.parameters(problem.start())
        run = problem.experiment.simulate(given, reference.initial)
        read = followed(given._replace(discrepancy=table), run['time'], run.columns)
        values = np.r_[values, read[seen]]
    return np.array([np.nanmin(values), np.nanmax(values)])


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
