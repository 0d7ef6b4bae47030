# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Model discrepancy without a name: the best smooth terms in one place over one variable.

A table is a hypothesis as any other: its ten values have priors, so that its evidence pays for
them, and its gain must not rest on a single block. (M. Kennedy and A. O'Hagan, J. R. Statist. Soc.
B 63 (2001) 425.)
"""

from collections.abc import Callable

import numpy as np

from booster_ros.diagnosis.estimation.fit import FIRST_STEPS, Fit, fit, fit_at
from booster_ros.diagnosis.estimation.parallel import side_by_side
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.diagnosis.hypotheses.discrepancy import (
    UNNAMED, Term, linear_reach, moved, terms, with_free_past)
from booster_ros.diagnosis.hypotheses.knots import looking_closer
from booster_ros.diagnosis.selection.decide import NOISE
from booster_ros.diagnosis.selection.neighbours import FINISHED, fitted_to_every_row
from booster_ros.diagnosis.selection.task import Model, Task
from booster_ros.model import discrepancy as term

Array = np.ndarray

WITHIN_REACH, POINTED_AT = 5.0, 2.0
"""
Multiples of the least cost that a term reaches by linear reckoning: terms up to the first are
tried, and up to the second they begin where the reckoning points. For the others the reckoning is
far off where much is missing. What a lag does is far from straight: it is tried whatever the
reckoning says, and does not begin where that points.
"""

LOOKS, WORTH_A_LOOK = 3, 0.05
"""How often knots go to where a term bends, as long as that lowers the cost by so much."""

UNFELT = 1e-9
"""Largest value of a term, in sizes that show, that is rounding where nothing asks for any."""

_NEED_A_CLOCK = (*term.CHANGE_OF, term.BACK_PRESSURE_ERROR)


def best_terms(task: Task, root: Model, tick: Callable[[], None] = lambda: None) -> list[Model]:
    """Return the models with a term without a name that explain most, fitted to every row."""
    problem = task.problem()
    likely = [one for one in terms(task.experiment.channels, task.declared)
              if one.place in task.places
              and not (task.experiment.quasi_static and one.variable in _NEED_A_CLOCK)]
    begun = _begun(problem, fit_at(problem, root.fit.z), likely)
    models = []
    for label in sorted(begun, key=lambda name: begun[name][1].cost)[:FINISHED]:
        joint, z = _fitted(*begun[label])
        models.append(fitted_to_every_row(task, (UNNAMED + label,), joint, z))
        tick()
    order = list(begun)
    return sorted(models, key=lambda one: order.index(one.effects[0].removeprefix(UNNAMED)))


def _begun(problem: Problem, reference: Fit, likely: list[Term]) -> dict[str, tuple[Problem, Fit]]:
    """
    Return the first steps with each term that may explain much, in the order of `terms`.

    Of the same term with several pasts, the one that reaches furthest. Terms over time come last:
    they say what was, not what comes.
    """
    reached: dict[str, tuple[float, Array, Array, Problem]] = {}
    for one, reach in zip(likely, side_by_side(
            lambda one: linear_reach(problem, reference, one, problem.rows), likely)):
        if _felt(reach[3], reach[2]) and (
                one.label not in reached or reach[0] < reached[one.label][0]):
            reached[one.label] = reach
    least = min((cost for cost, *_ in reached.values()), default=0.0)
    begun = {}
    last = f' over {term.VARIABLES[term.TIME]}'
    for label in sorted(reached, key=lambda name: name.endswith(last)):
        cost, z, move, joint = reached[label]
        bends = joint.base.discrepancy.location == term.EP_CONVERTER_LAG
        if bends or cost < WITHIN_REACH * least:
            pointed = cost < POINTED_AT * least and not bends
            start = moved(joint, z, move) if pointed else joint.start()
            joint, start = with_free_past(joint, start)
            begun[label] = joint, fit(joint, [start], FIRST_STEPS)
    return begun


def _felt(joint: Problem, move: Array) -> bool:
    """
    Tell whether a term moves anything compared; `move` is what linear reckoning makes of it.

    What lies upstream of a measured drive moves nothing.
    """
    return any(abs(step) > UNFELT for free, step in zip(joint.freedoms, move)
               if free.knob.parameter == 'discrepancy.values')


def _fitted(problem: Problem, begun: Fit) -> tuple[Problem, Array]:
    """
    Return the problem with a term and z, fitted to its end.

    Its knots are spread evenly at first. Where that leaves more than noise, they go to where the
    term bends, as long as that lowers the cost by a share that matters.
    """
    best = fit(problem, [begun.z])
    for _ in range(LOOKS):
        if best.cost < NOISE * problem.observed:
            break
        closer, z = looking_closer(problem, best)
        further = fit(closer, [z])
        gains = further.cost < (1.0 - WORTH_A_LOOK) * best.cost
        if further.cost < best.cost:
            problem, best = closer, further
        if not gains:
            break
    return problem, best.z
