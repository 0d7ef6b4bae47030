# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
What a record leaves open of its model, and what predictions may be off by for that alone.

A record tells parameters to their intervals. Data that ask for what it hardly shows, a largest area
that none of its steps needed, are missed by as much as models within these differ by there, though
nothing is missing in any of them. So, where the fitted rows are met,

1. draw parameters as the record leaves them open: as for their intervals, by a bootstrap of its
   segments and of what was expected, of a stem that sticks and slips with trials that do as well.
   Shapes of effects stay as they were found;
2. leave out those with which the rows that were fitted are missed by clearly more: a straight line
   along which one parameter makes up for another leads over bounds and past bends;
3. run the others over the data. The root mean square of what they differ by from the model is the
   standard uncertainty of what it predicts there;
4. where more than noise is missed, seek the model that meets the fitted rows and these together. If
   it still meets the fitted ones, what it leaves of the others is what no parameter is to blame
   for. Of slips, which come when chance will have it, the size alone is compared.

(Propagation of distributions by a Monte Carlo method: JCGM 101:2008, 5 and 7.)
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from booster_ros.diagnosis.experiment.experiment import Experiment, Initial, rmse
from booster_ros.diagnosis.fitting.descent import descend
from booster_ros.diagnosis.fitting.fit import Fit, Problem
from booster_ros.diagnosis.fitting.freedom import label
from booster_ros.diagnosis.fitting.side_by_side import side_by_side
from booster_ros.diagnosis.last_fit import LastFit
from booster_ros.diagnosis.result import Alike, ChannelError
from booster_ros.model.actuator import has_dry_friction
from booster_ros.model.parameters import is_consistent
from booster_ros.model.system import PositionerParameters

Array = np.ndarray
Model = tuple[PositionerParameters, Initial]

MODELS = 32
"""Models that are run: what is left open is told to 13 % then, two times of three."""

MOST_DRAWN = 100

FEWEST = 12
"""Models below which nothing is said."""

AS_WELL = 10.0
"""Rise of the cost for each variable from which a draw misses clearly more: of intervals that are
right it is one for each, some times that of coloured residuals."""

WORTH_ASKING = 0.3
"""Share of the noise from which it is asked what makes most of it: it then adds 4 % to an error."""

MOST = 0.5
"""Share of the square that one parameter makes by itself, from which most is of it."""

SLIPS = 2.0
"""Standard deviations of what is left open up to which slips are missed by chance."""

EVALUATIONS = 12


def models_alike(last: LastFit, draws: Array) -> Alike | None:
    """Return models that suit the record as well as the last one; `draws` of z are for them."""
    problem, fit = last.problem, last.fit
    found = _suiting(problem, last, draws)
    if len(found) < FEWEST:
        return None
    return Alike(tuple(_model(problem, z) for z in found),
                 dict(_one_off(problem, fit, np.array(found))), problem, fit)


def with_left_open(
    errors: Mapping[str, ChannelError], experiment: Experiment, run: Mapping[str, Array],
    models: Alike | None, rows: Array, start: Initial | None = None,
) -> dict[str, ChannelError]:
    """
    Return the errors of a run of the model with what is left open in these rows.

    All models begin where `start` says, each in its own start if it is None.
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

    total = _together(side_by_side(apart, models.models))
    much = any(total[name] >= WORTH_ASKING * errors[name].noise for name in total)
    alone = {one: _together(side_by_side(apart, ends)) for one, ends in models.one_off.items()
             } if much else {}
    beyond = {name: errors[name].after for name in counted}
    found: dict[str, float] = {}
    if any(has_dry_friction(p.actuator) for p, _ in models.models):
        beyond = _beyond_size(errors, total)
    elif much and not all(errors[name].met for name in counted):
        nearer, found = _beyond_reach(models, experiment, rows, start is None)
        beyond |= nearer
    return {name: error if name not in total else replace(
        error, left_open=total[name], unforeseen=beyond[name], mostly={
            one: found.get(one, np.nan) for one, moved in alone.items()
            if moved[name]**2 > MOST * total[name]**2})
            for name, error in errors.items()}


def _together(runs: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """Return the root of the mean over runs, NaN where one of them did not come to its end."""
    return {name: float(np.sqrt(np.mean([one[name] for one in runs]))) for name in runs[0]}


def _beyond_size(errors: Mapping[str, ChannelError], total: Mapping[str, float]
                 ) -> dict[str, float]:
    """Return what is missed beyond some standard deviations of what is left open, and noise."""
    found = {}
    for name, left in total.items():
        noise = min(errors[name].noise, errors[name].after)
        found[name] = float(np.hypot(noise, np.sqrt(np.maximum(
            errors[name].after**2 - noise**2 - (SLIPS * left)**2, 0.0))))
    return found


def _beyond_reach(models: Alike, experiment: Experiment, rows: Array, same: bool
                  ) -> tuple[dict[str, float], dict[str, float]]:
    """
    Return what is missed by the model that is nearest to meeting the record and these rows as well.

    And its parameters by name. Both are empty if the record speaks against it. Where it is the
    `same` experiment the model begins as fitted.
    """
    first, fit = models.problem, models.fit
    shared, own = len(first.freedoms), len(fit.z)
    # what was expected of the parameters counts once
    other = replace(first, experiment=experiment, rows=rows, freedoms=tuple(
        replace(free, sigma=np.inf) for free in first.freedoms))
    begin = np.append(fit.z, fit.z[shared:] if same else np.zeros(other.nuisances))
    of_other = np.r_[0:shared, own:len(begin)]
    many = len(first.residuals(fit.z))

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
    z = descend(residuals, jacobian, np.clip(begin, low, high), low, high, EVALUATIONS).z
    if first.cost(z[:own]) > first.cost(fit.z) + AS_WELL * own:
        return {}, {}
    predicted = other.predict(z[of_other]) or {}
    return ({name: rmse(experiment.measured[name], values, rows)
             for name, values in predicted.items()},
            {label(free): float(free.value(one)) for free, one in zip(first.freedoms, z)})


def _suiting(problem: Problem, last: LastFit, draws: Array) -> list[Array]:
    """Return draws, shapes as they were found, that miss what was fitted by hardly more."""
    fit = last.fit
    varied = last.trials.varied if last.trials else ()
    shapes = [j for j, free in enumerate(problem.freedoms) if free.knob.shape and j not in varied]
    drawn = np.clip(draws[::max(len(draws) // MOST_DRAWN, 1)][:MOST_DRAWN], *problem.bounds())
    drawn[:, shapes] = fit.z[shapes]
    cost = _cost(problem, fit)
    least = cost(fit.z) if last.trials is None else float(
        np.max(last.trials.cost[last.trials.are_good]))
    found: list[Array] = []
    for k in range(0, len(drawn), MODELS):
        some = drawn[k:k + MODELS]
        found += [z for z, left in zip(some, side_by_side(cost, some))
                  if left <= least + AS_WELL * len(fit.z)]
        if len(found) >= MODELS:
            break
    return found[:MODELS]


def _cost(problem: Problem, fit: Fit) -> Callable[[Array], float]:
    return problem.cost_through_slips if has_dry_friction(fit.parameters.actuator) else problem.cost


def _one_off(problem: Problem, fit: Fit, models: Array) -> Iterable[tuple[str, tuple[Model, ...]]]:
    """
    Yield the model with a single parameter off to either side by as much as it is left open.

    Only of those that may be off by so much alone: where others have to make up for it, what it
    does by itself is no model of the record.
    """
    low, high = problem.bounds()
    middle, spread = models.mean(axis=0), models.std(axis=0)
    noticed = np.linalg.norm(fit.jacobian, axis=0) * spread
    for j, free in enumerate(problem.freedoms):
        if spread[j] == 0.0 or noticed[j]**2 > AS_WELL:
            continue
        ends = np.tile(fit.z, (2, 1))
        ends[:, j] = np.clip(middle[j] + spread[j] * np.array([-1.0, 1.0]), low[j], high[j])
        both = tuple(_model(problem, z) for z in ends)
        if all(is_consistent(p) for p, _ in both):
            yield label(free), both


def _model(problem: Problem, z: Array) -> Model:
    p = problem.parameters(z)
    return p, problem.initial(z, p)
