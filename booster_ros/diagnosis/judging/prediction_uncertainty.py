# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
What a record leaves open of its model, and by how much predictions may be off for that alone.

Data that depend on what a record hardly shows, such as a largest area that none of its steps
needed, are missed by as much as models within the intervals of its parameters differ there, though
none of them lacks anything. So, where the fitted rows are met,

1. take the draws of the bootstrap that intervals come of, shapes of effects as they were found;
2. leave out those that miss the fitted rows by clearly more;
3. run the others over the data: the root mean square of their differences from the model is the
   standard uncertainty of its prediction;
4. for what is missed beyond FAR_OFF times that, no parameter that the record leaves open is to
   blame.

(Propagation of distributions by a Monte Carlo method: JCGM 101:2008, 5 and 7.)
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from booster_ros.diagnosis.data.experiment import FEWEST, Array, Experiment, Initial
from booster_ros.diagnosis.estimation.final_fit import FinalFit
from booster_ros.diagnosis.result import FAR_OFF, ChannelError, Started
from booster_ros.numerics.parallel import side_by_side

BY_CHANCE = 10.0
"""Change of the cost for each variable up to which it is taken for chance: coloured noise makes it
some times one."""

MODELS = 32
"""Number of models that are run: they tell what is left open to 13 %, two times of three."""


def models_alike(last: FinalFit) -> tuple[Started, ...] | None:
    """Return models out of the draws of z, shapes as they were found, that suit the record too."""
    problem, fit = last.problem, last.fit
    shapes = [j for j, free in enumerate(problem.freedoms) if free.knob.shape]
    drawn = np.clip(last.draws, *problem.bounds())
    drawn[:, shapes] = fit.z[shapes]
    found: list[Array] = []
    for k in range(0, len(drawn), MODELS):
        some = drawn[k:k + MODELS]
        found += [z for z, left in zip(some, side_by_side(problem.cost, some))
                  if left <= fit.cost + BY_CHANCE * len(fit.z)]
        if len(found) >= MODELS or len(found) * len(drawn) < FEWEST * k:  # FEWEST will not come
            break
    if len(found) < FEWEST:
        return None
    parameters = map(problem.parameters, found[:MODELS])
    return tuple((p, problem.initial(z, p)) for z, p in zip(found, parameters))


def with_left_open(errors: Mapping[str, ChannelError], experiment: Experiment,
                   run: Mapping[str, Array], models: Sequence[Started] | None, rows: Array,
                   start: Initial | None = None) -> dict[str, ChannelError]:
    """
    Return the errors of a run of the model with what is left open in these rows.

    All models begin at `start`, or each at its own start if that is None.
    """
    counted = {name: rows & np.isfinite(measured) for name, measured in experiment.measured.items()
               if np.isfinite(errors[name].after)}
    if models is None or not counted:
        return dict(errors)

    def apart(model: Started) -> list[float]:
        parameters, initial = model
        other = experiment.predict(parameters, start or initial)
        return [float(np.mean((other[name] - run[name])[at]**2)) for name, at in counted.items()]

    left = np.sqrt(np.mean(side_by_side(apart, models), axis=0))
    return {**errors, **{name: _beyond(errors[name], float(one))
                         for name, one in zip(counted, left)}}


def _beyond(error: ChannelError, left_open: float) -> ChannelError:
    """Return the error with what is left of it, noise included, beyond FAR_OFF times that."""
    noise = min(error.noise, error.after)
    beyond = max(error.after**2 - noise**2 - (FAR_OFF * left_open)**2, 0.0)
    return replace(error, left_open=left_open, unforeseen=float(np.hypot(noise, np.sqrt(beyond))))
