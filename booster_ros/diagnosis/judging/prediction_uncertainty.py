# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
What a record leaves open of its model, and by how much predictions may be off for that alone.

A record tells parameters only to their intervals. Data that depend on what it hardly shows, such
as a largest area that none of its steps needed, are missed by as much as models within these
intervals differ there, though none of these models lacks anything. So, where the fitted rows are
met,

1. draw parameters as the record leaves them open, as for their intervals: by a bootstrap of its
   blocks and of what was expected; shapes of effects stay as they
   were found;
2. leave out the draws that miss the fitted rows by clearly more: a straight line along which one
   parameter makes up for another leads over bounds and past bends;
3. run the other draws over the data. The root mean square of their differences from the model is
   the standard uncertainty of what the model predicts there;
4. where the data are missed by more than noise, seek the model that meets the fitted rows and the
   data together. If it still meets the fitted rows, no parameter is to blame for what it leaves of
   the data. Where the stem slips, which it does when chance will have it, only the size of what is
   missed is compared with that of what is left open.

(Propagation of distributions by a Monte Carlo method: JCGM 101:2008, 5 and 7.)
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from booster_ros.diagnosis.data.experiment import FEWEST, Experiment, Initial, rmse
from booster_ros.diagnosis.estimation.least_squares import descend
from booster_ros.diagnosis.estimation.final_fit import FinalFit
from booster_ros.diagnosis.estimation.fit import EVALUATIONS
from booster_ros.diagnosis.estimation.observation import WINDOWS
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.diagnosis.estimation.parametrisation import label
from booster_ros.diagnosis.estimation.parallel import side_by_side
from booster_ros.diagnosis.judging.perturbation import WORTH_SAYING
from booster_ros.diagnosis.result import FAR_OFF, Alike, ChannelError
from booster_ros.model.system import PositionerParameters

Array = np.ndarray
Model = tuple[PositionerParameters, Initial]

BY_CHANCE = 10.0
"""Change of the cost for each variable up to which it is taken for chance: one where residuals are
white, and some times that where they are coloured."""

MODELS = 32
"""Number of models that are run: they tell what is left open to 13 %, two times of three."""


def models_alike(last: FinalFit) -> Alike | None:
    """Return models, out of the draws of z, that suit the record as well as the last one does."""
    problem = last.problem
    found = _suiting(last)
    if len(found) < FEWEST:
        return None
    return Alike(tuple(_model(problem, z) for z in found), problem.base, problem.freedoms,
                 last.fit.z, problem.experiment, problem.rows, problem.observation.name)


def with_left_open(
    errors: Mapping[str, ChannelError], experiment: Experiment, run: Mapping[str, Array],
    models: Alike | None, rows: Array, start: Initial | None = None,
) -> dict[str, ChannelError]:
    """
    Return the errors of a run of the model with what is left open in these rows.

    All models begin at `start`, or each at its own start if that is None.
    """
    if models is None:
        return dict(errors)
    counted = {name: rows & np.isfinite(measured) for name, measured in experiment.measured.items()
               if np.isfinite(errors[name].after)}
    if not counted:
        return dict(errors)

    def apart(model: Model) -> dict[str, float]:
        parameters, initial = model
        other = experiment.predict(parameters, start or initial)
        return {name: float(np.mean((other[name] - run[name])[at]**2))
                for name, at in counted.items()}

    runs = side_by_side(apart, models.models)
    total = {name: float(np.sqrt(np.mean([one[name] for one in runs]))) for name in counted}
    much = any(total[name] >= WORTH_SAYING * errors[name].noise for name in total)
    beyond = {name: errors[name].after for name in counted}
    moved: dict[str, float] = {}
    if models.observation == WINDOWS.name:
        beyond = _beyond_size(errors, total)
    elif much and not all(errors[name].met for name in counted):
        nearer, moved = _beyond_reach(models, experiment, rows, start is None)
        beyond |= nearer
    return {name: error if name not in total else replace(
        error, left_open=total[name], unforeseen=beyond[name], mostly=moved)
            for name, error in errors.items()}


def _beyond_size(errors: Mapping[str, ChannelError], total: Mapping[str, float]
                 ) -> dict[str, float]:
    """Return the error, noise included, beyond FAR_OFF standard deviations of what is left open."""
    found = {}
    for name, left in total.items():
        noise = min(errors[name].noise, errors[name].after)
        found[name] = float(np.hypot(noise, np.sqrt(np.maximum(
            errors[name].after**2 - noise**2 - (FAR_OFF * left)**2, 0.0))))
    return found


def _beyond_reach(models: Alike, experiment: Experiment, rows: Array, same: bool
                  ) -> tuple[dict[str, float], dict[str, float]]:
    """
    Return the errors in these rows of the model that comes nearest to meeting them and the record.

    And its value, by name, of the parameter that changes most of what is predicted there on the way
    to it, of those that the record hardly shows alone. Both are empty if this model misses the
    record by clearly more. Where the rows are of the `same` experiment, their start is sought from
    the one that was fitted.
    """
    first, z = Problem(models.experiment, models.rows, models.base, models.freedoms), models.z
    shared, own = len(first.freedoms), len(z)
    # what was expected of the parameters counts once, in the first problem
    other = replace(first, experiment=experiment, rows=rows, freedoms=tuple(
        replace(free, sigma=np.inf) for free in first.freedoms))
    begin = np.append(z, z[shared:] if same else np.zeros(other.nuisances))
    of_other = np.r_[0:shared, own:len(begin)]
    many = len(first.residuals(z))

    def residuals(z: Array) -> Array:
        return np.append(first.residuals(z[:own]), other.residuals(z[of_other]))

    def jacobian(z: Array, here: Array, before: Array | None) -> Array:
        slopes = np.zeros((len(here), len(z)))
        slopes[:many, :own] = first.jacobian(
            z[:own], here[:many], None if before is None else before[:many, :own])
        slopes[many:, of_other] = other.jacobian(
            z[of_other], here[many:], None if before is None else before[many:, of_other])
        return slopes

    low, high = (np.append(one, another[shared:])
                 for one, another in zip(first.bounds(), other.bounds()))
    end = descend(residuals, jacobian, np.clip(begin, low, high), low, high, EVALUATIONS)
    both = end.z
    if first.cost(both[:own]) > first.cost(z) + BY_CHANCE * own:
        return {}, {}
    way = (end.jacobian[:, :shared] * (both - begin)[:shared])**2
    # where others have to make up for one, that one alone is not what the record leaves open
    open_yet = np.where(way[:many].sum(axis=0) > BY_CHANCE, 0.0, way[many:].sum(axis=0))
    predicted = other.predict(both[of_other]) or {}
    return ({name: rmse(experiment.measured[name], values, rows)
             for name, values in predicted.items()},
            {label(free): float(free.value(one))
             for free, one, part in zip(first.freedoms, both, open_yet)
             if part > 0.5 * open_yet.sum()})


def _suiting(last: FinalFit) -> list[Array]:
    """Return draws, with shapes as they were found, that miss the fitted rows by hardly more."""
    problem, fit = last.problem, last.fit
    shapes = [j for j, free in enumerate(problem.freedoms) if free.knob.shape]
    drawn = np.clip(last.draws, *problem.bounds())
    drawn[:, shapes] = fit.z[shapes]
    found: list[Array] = []
    for k in range(0, len(drawn), MODELS):
        some = drawn[k:k + MODELS]
        found += [z for z, left in zip(some, side_by_side(problem.cost, some))
                  if left <= fit.cost + BY_CHANCE * len(fit.z)]
        if len(found) >= MODELS:
            break
    return found[:MODELS]


def _model(problem: Problem, z: Array) -> Model:
    p = problem.parameters(z)
    return p, problem.initial(z, p)
