# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
What a record leaves open of its model, and by how much predictions may be off for that.

A record tells parameters to their intervals. Data that ask for what it hardly shows, a largest area
that none of its steps needed, are missed by as much as models within these differ by there, though
nothing is missing in any of them. So

1. draw parameters as the record leaves them open: as for their intervals, by a bootstrap of its
   segments and of what was expected, or, of a stem that sticks and slips, trials that do as well;
2. leave out those with which the rows that were fitted are missed by clearly more: a straight line
   along which one parameter makes up for another leads over bounds and past bends;
3. run the others over the data. The root mean square of what they differ by from the model is the
   standard uncertainty of what it predicts.

(Propagation of distributions by a Monte Carlo method: JCGM 101:2008, 5 and 7.)
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace

import numpy as np

from booster_ros.diagnosis.experiment.experiment import Experiment, Initial, rmse
from booster_ros.diagnosis.fitting.fit import Fit, Problem
from booster_ros.diagnosis.fitting.freedom import label
from booster_ros.diagnosis.fitting.side_by_side import side_by_side
from booster_ros.diagnosis.last_fit import LastFit
from booster_ros.diagnosis.result import Alike, ChannelError
from booster_ros.model.actuator import has_dry_friction
from booster_ros.model.parameters import ParameterError, check_consistent
from booster_ros.model.system import PositionerParameters

Array = np.ndarray

MODELS = 32
"""Models that are run: what is left open is told to 13 % then, two times of three."""

MOST_DRAWN = 96

AS_WELL = 10.0
"""Rise of the cost for each variable, in what is left of each row, from which a draw misses clearly
more: of intervals that are right it is one for each, some times that of coloured residuals."""

WORTH_ASKING = 0.3
"""Share of the noise from which it is asked what makes most of it: it then adds 4 % to an error."""

MOST = 0.5
"""Share of the square that one parameter makes by itself, from which most is of it."""


def models_alike(last: LastFit, draws: Array) -> Alike:
    """Return models that suit the record as well as the last one; `draws` of z are for them."""
    problem, fit = last.problem, last.fit
    found = _among_trials(last.trials.as_good) if last.trials else _suiting(problem, fit, draws)
    models = [(problem.parameters(z), z) for z in found]
    return Alike(
        tuple((p, problem.initial(z, p)) for p, z in models if _consistent(p)),
        dict(_apart(problem, fit, np.array(found))) if len(found) > 1 else {})


def with_left_open(
    errors: Mapping[str, ChannelError], experiment: Experiment, run: Mapping[str, Array],
    models: Alike | None, rows: Array, start: Initial | None = None,
) -> dict[str, ChannelError]:
    """
    Return the errors of a run of the model with what is left open in these rows.

    All models begin where `start` says, each in its own start if it is None.
    """
    if models is None or not models.models:
        return dict(errors)

    def apart(model: tuple[PositionerParameters, Initial]) -> dict[str, float]:
        parameters, initial = model
        other = experiment.predict(parameters, start or initial)
        return {name: rmse(np.where(np.isfinite(measured), run[name], np.nan), other[name], rows)
                for name, measured in experiment.measured.items()}

    total = _together(side_by_side(apart, models.models))
    share = max(total[name] / error.noise for name, error in errors.items())
    asked = models.one_off if share >= WORTH_ASKING else {}
    alone = {one: _together(side_by_side(apart, ends)) for one, ends in asked.items()}
    return {name: replace(error, left_open=total[name], mostly=tuple(
        one for one, moved in alone.items() if moved[name]**2 > MOST * total[name]**2))
            for name, error in errors.items()}


def _together(runs: Iterable[Mapping[str, float]]) -> dict[str, float]:
    """Return the root mean square over runs, NaN where one did not come to its end."""
    several = list(runs)
    return {name: float(np.sqrt(np.mean([one[name]**2 for one in several]))) for name in several[0]}


def _among_trials(good: Array) -> list[Array]:
    """Return some of the trials, near ones and far ones alike."""
    return list(good[np.unique(np.linspace(0, len(good) - 1, MODELS).astype(int))])


def _suiting(problem: Problem, fit: Fit, draws: Array) -> list[Array]:
    """Return draws, shapes as they were found, that miss what was fitted by hardly more."""
    low, high = problem.bounds()
    shapes = [j for j, free in enumerate(problem.freedoms) if free.knob.shape]
    drawn = draws[:MOST_DRAWN].copy()
    drawn[:, shapes] = fit.z[shapes]
    cost = _cost(problem, fit)
    least = cost(fit.z)
    most = least + AS_WELL * len(fit.z) * max(1.0, least / problem.rows_counted())
    found: list[Array] = []
    for some in np.split(np.clip(drawn, low, high), MOST_DRAWN // MODELS):
        found += [z for z, left in zip(some, side_by_side(cost, some)) if left <= most]
        if len(found) >= MODELS:
            break
    return found[:MODELS]


def _cost(problem: Problem, fit: Fit) -> Callable[[Array], float]:
    return problem.cost_through_slips if has_dry_friction(fit.parameters.actuator) else problem.cost


def _apart(problem: Problem, fit: Fit, models: Array
           ) -> Iterable[tuple[str, tuple[tuple[PositionerParameters, Initial], ...]]]:
    """
    Yield the model with a single parameter off to either side by as much as it is left open.

    Only of those that may be off by so much alone: where others have to make up for it, what it
    does by itself is no model of the record.
    """
    middle, spread = models.mean(axis=0), models.std(axis=0)
    noticed = np.linalg.norm(fit.jacobian, axis=0) * spread
    for j, free in enumerate(problem.freedoms):
        if spread[j] == 0.0 or noticed[j]**2 > AS_WELL:
            continue
        ends = []
        for way in (-spread[j], spread[j]):
            z = fit.z.copy()
            z[j] = middle[j] + way
            p = problem.parameters(z)
            ends.append((p, problem.initial(z, p)))
        if all(_consistent(p) for p, _ in ends):
            yield label(free), tuple(ends)


def _consistent(parameters: PositionerParameters) -> bool:
    try:
        check_consistent(parameters)
    except ParameterError:
        return False
    return True
