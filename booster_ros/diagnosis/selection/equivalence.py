# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Distinguishability: which effects a record cannot tell from one that it shows.

Two answers are given together. Models that were fitted, and whose evidence is within TIE of the
chosen one's. And by expected discrimination, as if a fitted effect were the truth:

1. the measured values are replaced by the prediction of the fit;
2. the effect is taken out, all else stays;
3. every other effect is screened in its place, and the best of them take the first steps of a fit.

What one then costs, it costs more than the truth on average over all noise. Where that is less than
what tells models apart, no fit to this record can decide.
"""

from dataclasses import replace

import numpy as np

from booster_ros.diagnosis.data.experiment import Array, Experiment
from booster_ros.diagnosis.estimation.fit import carried, fit_at
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.diagnosis.hypotheses.compose import redundant
from booster_ros.diagnosis.hypotheses.friction import begins_on_a_grid
from booster_ros.diagnosis.selection.decide import TIE
from booster_ros.diagnosis.selection.neighbours import BEGUN
from booster_ros.diagnosis.selection.screening import first_steps, reference_at, screen
from booster_ros.diagnosis.selection.stepwise import Selection, comparison
from booster_ros.diagnosis.selection.task import Model, Task
from booster_ros.model.catalogue import EFFECTS
from booster_ros.numerics.parallel import side_by_side


def alike(task: Task, selection: Selection, chosen: Model, name: str) -> tuple[str, ...]:
    """Return the effects that could take the place of this one for all that the record says."""
    rest = set(chosen.but(name))
    found = []
    for one in selection.models:
        instead = set(one.effects) - rest
        if (len(instead) == 1 and rest <= set(one.effects) and name not in instead
                and instead <= EFFECTS.keys() and one.score.observed == chosen.score.observed):
            said = comparison(task, chosen, one, [])
            found += sorted(instead) if said.log_evidence < TIE + said.luck else []
    if not chosen.problem.observation.summary:
        found += _indistinct(task, chosen, name)
    return tuple(dict.fromkeys(found))


def _indistinct(task: Task, chosen: Model, name: str) -> list[str]:
    """Return the effects that expected discrimination does not tell from this one."""
    whole = task.problem(chosen.effects)
    z = carried(whole, chosen.fit)
    rest = task.problem(chosen.but(name))
    rest = replace(rest, experiment=_as_predicted(whole, z))
    around = [reference_at(rest, fit_at(rest, carried(rest, chosen.fit)))]
    known = float(np.sum(whole.residuals(z)[whole.observed:]**2))
    # thinned rows tell so much less than all of them
    most = 2.0 * TIE * chosen.score.dispersion * whole.observed / max(chosen.problem.observed, 1)

    others = [other for other in task.names if other not in chosen.effects
              and not begins_on_a_grid(other) and not redundant(other, chosen.but(name))]
    quick = side_by_side(lambda other: screen(rest, around, other), others)
    quick = sorted((one for one in quick if one.starts), key=lambda one: one.cost)[:BEGUN]
    ends = side_by_side(lambda one: first_steps(rest, one), quick)
    found = {one.effect for one, end in zip(quick, ends) if end.cost - known < most}
    return [other for other in others if other in found]


def _as_predicted(problem: Problem, z: Array) -> Experiment:
    """Return the experiment with the prediction at z where a value was measured."""
    predicted = problem.predict(z) or problem.experiment.measured  # a fitted model can run
    return replace(problem.experiment, measured={
        name: np.where(np.isfinite(values), predicted[name], np.nan)
        for name, values in problem.experiment.measured.items()})
