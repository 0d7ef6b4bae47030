# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Which effects a record cannot tell from one that it shows, whatever the noise of the day was.

Model: if a fitted effect were the truth, the record would be what the model predicts, and another
effect in its place would leave unexplained what no parameter can imitate. Scaled by the noise, the
sum of squares of that is what the other costs more than the truth, on average over all noise.

1. the measured values are replaced by the prediction of the fit;
2. the effect is taken out, all else stays;
3. every other effect is screened in its place (see screening: what all other parameters can
   imitate is projected off, then a few steps follow, as effects are not linear).

Where that cost is less than what makes a model unlikely, no fit to this record can decide.
"""

from dataclasses import dataclass, replace

import numpy as np

from booster_ros.diagnosis.experiment.experiment import Experiment
from booster_ros.diagnosis.fitting.fit import Fit, Problem
from booster_ros.diagnosis.fitting.side_by_side import side_by_side
from booster_ros.diagnosis.searching.screening import reference_at, screen
from booster_ros.diagnosis.searching.search import carried

Array = np.ndarray

_A_FREQUENCY = np.array([0.5])


@dataclass(frozen=True)
class Substitute:
    """An effect, how much more it would cost than the one it replaces, and where a fit begins."""

    effect: str
    cost: float
    problem: Problem
    start: Array


def substitutes(problem: Problem, fit: Fit, rest: Problem, others: tuple[str, ...]
                ) -> list[Substitute]:
    """
    Return the other effects by how much they would cost in the place of a fitted one, least first.

    `problem` is that of the fit; `rest`, on the same rows, is that of the same model without the
    effect, each parameter as sure as it is without it.
    """
    rest = replace(rest, experiment=_as_predicted(problem, fit))
    z = carried(rest, fit)
    around = [reference_at(rest, rest.at(z))]
    departures = problem.cost_of_priors(fit.z)

    def one(name: str) -> Substitute:
        found = screen(rest, around, name, _A_FREQUENCY)
        start = found.starts[0] if found.starts else z
        joint = replace(found.problem, experiment=problem.experiment)
        return Substitute(name, found.cost - departures, joint, start)

    return sorted(side_by_side(one, others), key=lambda found: found.cost)


def _as_predicted(problem: Problem, fit: Fit) -> Experiment:
    """Return the experiment with the prediction of a fit where a value was measured."""
    predicted = problem.predict(fit.z)
    if predicted is None:
        raise ValueError('the fitted model cannot run')
    return replace(problem.experiment, measured={
        name: np.where(np.isfinite(values), predicted[name], np.nan)
        for name, values in problem.experiment.measured.items()})
