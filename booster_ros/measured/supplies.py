# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Table I across its supply pressures: fitted to some of them, judged on another."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import NamedTuple

import numpy as np

from ..diagnosis.hypotheses.applicable import free_to_refit
from ..diagnosis.data.experiment import Experiment, rmse
from ..diagnosis.estimation.fit import Fit, fit
from ..diagnosis.estimation.problem import Problem
from ..diagnosis.estimation.parametrisation import effect_freedom, put
from ..model.catalogue import EFFECTS
from ..model.system import PositionerParameters
from ..paper.printed import FLOW_UNIT


class Model(NamedTuple):
    """Effects that are fitted; `gain` is an opening gain, m²/N, that is given and not fitted."""

    effects: tuple[str, ...]
    gain: float | None = None


NO_SPRING = 1e-3
"""An opening gain at which next to no force but that of the flow resists the opening, m²/N."""

_BOTH = ('booster_dead_band', 'plug_flow_force')

MODELS = {
    'declared, refitted': Model(()),
    'preload': Model(('booster_dead_band',)),
    'preload and flow force': Model(_BOTH),
    'preload, flow force alone resists': Model(_BOTH, NO_SPRING),
}
"""What is compared. At one supply gain and flow force are the same slope: the last has only one."""

SPLITS = (
    ((150e3, 200e3), 100e3), ((100e3, 200e3), 150e3), ((100e3, 150e3), 200e3),
    ((150e3,), 200e3), ((200e3,), 150e3),
)
"""Supply pressures to fit, gauge Pa, and the one that is predicted."""

GAINS = (1.0, 2.0, 5.0, 20.0)
PRELOADS = (0.3, 0.38)
FORCES = (0.3, 0.8)
"""
Where fits begin: multiples of the declared opening gain, preloads in N, coefficients of the flow
force. Knees and closed rows give the misfit several valleys; the best of all starts counts.
"""

_EVALUATIONS = 60


class Prediction(NamedTuple):
    """RMS errors of one model in units of the table, on the supplies it was fitted to and not."""

    fitted: float
    predicted: float
    rows: int
    """How many were predicted."""


def predictions(
    experiment: Experiment, declared: PositionerParameters
) -> dict[str, list[Prediction]]:
    """Return, for each of `MODELS`, how each of `SPLITS` comes out."""
    return {label: [_prediction(experiment, declared, model, *split) for split in SPLITS]
            for label, model in MODELS.items()}


def _prediction(
    experiment: Experiment, declared: PositionerParameters, model: Model,
    fitted: tuple[float, ...], predicted: float,
) -> Prediction:
    supply = experiment.pinned['supply_pressure']
    rows, others = np.isin(supply, fitted), supply == predicted
    fit = best_fit(experiment, declared, model, rows)
    flow = experiment.predict(fit.parameters, fit.initial)['mass_flow']
    measured = experiment.measured['mass_flow']
    return Prediction(
        rmse(measured, flow, rows) / FLOW_UNIT, rmse(measured, flow, others) / FLOW_UNIT,
        int(others.sum()))


def best_fit(
    experiment: Experiment, declared: PositionerParameters, model: Model, rows: np.ndarray
) -> Fit:
    """Return the fit of the declared parameters and the model's effects to the marked rows."""
    own = [free for free in free_to_refit(declared, experiment)
           if not (model.gain and free.knob.parameter == 'booster.opening_gain')]
    added = [free for name in model.effects
             for free in effect_freedom(EFFECTS[name], declared)]
    base = put(declared, 'booster.opening_gain', model.gain) if model.gain else declared
    problem = Problem(experiment, rows, base, (*own, *added))
    return fit(problem, list(_starts(problem)), _EVALUATIONS)


def _starts(problem: Problem) -> Iterator[np.ndarray]:
    names = [free.knob.parameter for free in problem.freedoms]
    gain = problem.base.booster.opening_gain
    known = {'booster.opening_gain': [factor * gain for factor in GAINS],
             'booster.intake_preload': PRELOADS, 'booster.intake_flow_force': FORCES}
    turned = [name for name in known if name in names]
    for values in product(*(known[name] for name in turned)):
        z = problem.start()
        for name, value in zip(turned, values):
            place = names.index(name)
            z[place] = problem.freedoms[place].variable(value)
        yield z


def left_out(found: list[Prediction]) -> float:
    """Return the RMS error over all rows, each predicted from the other two supplies."""
    three = found[:3]
    squares = sum(one.rows * one.predicted**2 for one in three)
    return float(np.sqrt(squares / sum(one.rows for one in three)))
