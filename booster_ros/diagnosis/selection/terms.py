# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Model discrepancy without a name: the best smooth terms in one place over one variable.

A table is a hypothesis as any other: its ten values have priors, so that its evidence pays for
them. (M. Kennedy and A. O'Hagan, J. R. Statist. Soc. B 63 (2001) 425.)
"""

import numpy as np

from booster_ros.diagnosis.data.experiment import Array
from booster_ros.diagnosis.estimation.fit import FIRST_STEPS, Fit, fit, fit_at
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.diagnosis.hypotheses.discrepancy import (
    UNNAMED, Term, linear_reach, place_of, terms)
from booster_ros.diagnosis.selection.neighbours import BEGUN, fitted_to_every_row
from booster_ros.diagnosis.selection.screening import BEST
from booster_ros.diagnosis.selection.task import Model, Task
from booster_ros.model import discrepancy as term
from booster_ros.numerics.parallel import side_by_side


def best_terms(task: Task, root: Model) -> list[Model]:
    """Return the models with a term without a name that explain most, fitted to every row."""
    problem = task.problem()
    likely = [one for one in terms(task.experiment.channels, task.declared)
              if place_of(one.location) in task.places
              and not (task.experiment.quasi_static
                       and one.variable in (*term.CHANGE_OF, term.BACK_PRESSURE_ERROR))]
    begun = _begun(problem, fit_at(problem, root.fit.z), likely)

    def to_its_end(label: str) -> Model:
        joint, end = begun[label]
        return fitted_to_every_row(task, (UNNAMED + label,), joint, fit(joint, [end.z]).z)

    models = side_by_side(
        to_its_end, sorted(begun, key=lambda name: begun[name][1].cost)[:BEST])
    order = list(begun)
    return sorted(models, key=lambda one: order.index(one.effects[0].removeprefix(UNNAMED)))


def _begun(problem: Problem, reference: Fit, likely: list[Term]) -> dict[str, tuple[Problem, Fit]]:
    """
    Return the first steps with each term that reaches furthest, in the order of `terms`.

    Of several pasts the one that reaches furthest counts. Steps begin with the declared parameters
    as given, as the fitted ones have imitated it. Terms over time come last.
    """
    reached: dict[str, tuple[float, Problem, Array]] = {}
    for one, reach in zip(likely, side_by_side(
            lambda one: linear_reach(problem, reference, one), likely)):
        if np.isfinite(reach[0]) and reach[0] < reached.get(one.label, (np.inf,))[0]:
            reached[one.label] = reach
    furthest = sorted(reached, key=lambda name: reached[name][0])[:BEGUN]
    last = f' over {term.VARIABLES[term.TIME]}'

    def first_steps(label: str) -> tuple[Problem, Fit]:
        _, joint, slopes = reached[label]
        return joint, fit(joint, [joint.start()], FIRST_STEPS, slopes=slopes)

    # what a lag does is far from straight: it is tried whatever the reckoning says
    tried = [label for label in sorted(reached, key=lambda name: name.endswith(last))
             if label in furthest
             or reached[label][1].base.discrepancy.location == term.EP_CONVERTER_LAG]
    return dict(zip(tried, side_by_side(first_steps, tried)))
