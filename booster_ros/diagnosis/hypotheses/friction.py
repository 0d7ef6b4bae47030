# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Where fits of dry friction begin: the best of a population that begins on a grid.

The statistics of windows have many minima over friction, in a valley along which stiction makes up
for sliding friction, and the deepest is less than a percent wide. So both are tried over a grid,
for a packing that yields and for one that does not, and the best of it go on by differential
evolution, which follows such a valley; each trial takes one run of the model.

Stick-slip of a slowly driven mass: B. Armstrong-Helouvry et al., Automatica 30 (1994) 1083.
Differential evolution: R. Storn and K. Price, Journal of Global Optimization 11 (1997) 341.
"""

from collections.abc import Mapping

import numpy as np
from scipy.optimize import differential_evolution

from booster_ros.diagnosis.data.experiment import Array
from booster_ros.diagnosis.estimation.parallel import side_by_side
from booster_ros.diagnosis.estimation.parametrisation import Free
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.model.catalogue import EFFECTS
from booster_ros.model.scaling import proportion

_DAMPING = 'actuator.presliding_damping'

SLIDING = (75.0, 106.0, 150.0, 212.0, 300.0, 424.0, 600.0, 849.0, 1200.0)
"""Values of sliding friction that are tried first, N, in a valve of the paper's size."""

BREAKING_AWAY = (0.0, 0.2, 0.4, 0.8)
"""Values of stiction that are tried first, as shares of the sliding friction."""

DAMPINGS = (0.0, 0.3, 0.6)
"""Damping of a packing that is tried, as shares of the critical one, 0 for one that does not yield:
damping and viscous friction trade."""

POPULATION, GENERATIONS, MUTATION = 40, 10, (0.3, 0.8)
"""Trials that go on from the grid, how often, and their steps as shares of their distances: 24
trials missed the deepest minimum of a record in six of six searches, 40 in one of four."""

UNLIKELY = 5.0
"""Standard deviations beyond which a statistic tells of a slip more or less, not of noise."""

KEPT = 3
"""Number of best trials from which fits begin."""


def begins_on_a_grid(name: str) -> bool:
    """Tell whether fits of an effect begin at the best of a grid: screening does not lead there."""
    return EFFECTS[name].rubs


def can_be(free: tuple[Free, ...], move: Mapping[int, float]) -> bool:
    """
    Tell whether an effect with these variables can have the sizes of a move (by variable's index).

    Break-away or bent-stem friction of a packing that hardly rubs does not exist, and is slow to
    simulate. A galled stem may rub in one place alone, which a fit finds from there.
    """
    return all(abs(step) <= move.get(j, 0.0)
               for j, one in enumerate(free) if one.knob.rubs for step in move.values())


def friction_starts(problem: Problem, z: Array) -> list[Array]:
    """Return where to begin with dry friction, all else as it is at z; z alone if none is free."""
    if not any(free.knob.rubs for free in problem.freedoms):
        return [z]
    larger = proportion(problem.base, 'actuator', 'N')
    yields = any(free.knob.parameter == _DAMPING for free in problem.freedoms)
    dampings = DAMPINGS[:None if yields else 1]

    def placed(trial: Array) -> Array:
        return _placed(problem, z, larger * np.exp(trial[0]), trial[1], dampings[int(trial[2])])

    def cost(trial: Array) -> float:
        return bounded_cost(problem.residuals(placed(trial)))

    grid = np.array([(np.log(force), share, k) for force in SLIDING for share in BREAKING_AWAY
                     for k in range(len(dampings))])
    first = np.argsort(side_by_side(cost, grid), kind='stable')[:POPULATION]
    ends = np.log([0.7 * SLIDING[0], 1.4 * SLIDING[-1]])
    found = differential_evolution(
        cost, [ends, (0.0, 1.0), (0, len(dampings) - 1)], init=grid[first],
        maxiter=GENERATIONS, mutation=MUTATION, tol=0.0, polish=False, updating='deferred', seed=1,
        workers=lambda one, trials: side_by_side(one, list(trials)),
        integrality=(False, False, True))
    best = np.argsort(found.population_energies, kind='stable')[:KEPT]
    return [placed(found.population[k]) for k in best]


def bounded_cost(residuals: Array) -> float:
    """
    Return a sum of squares that grows as a logarithm where residuals are UNLIKELY.

    It is that of Cauchy's distribution, sum c² log(1 + r²/c²): one slip that comes in another
    window is up to hundreds of standard deviations there, and would hide how well all else is met.
    """
    return float(np.sum(UNLIKELY**2 * np.log1p((residuals / UNLIKELY)**2)))


def _placed(problem: Problem, z: Array, sliding: float, share: float, damping: float) -> Array:
    """Return z with such friction, its start as given and all other shapes typical."""
    moved = z.copy()
    moved[len(problem.freedoms):] = 0.0
    for j, free in enumerate(problem.freedoms):
        typical = free.knob.typical
        values = {'actuator.stiction': share * sliding,
                  'actuator.presliding_stiffness': typical if damping else 0.0,
                  _DAMPING: damping or typical, 'actuator.stribeck_velocity': typical}
        if free.knob.rubs:
            moved[j] = free.variable(sliding)
        elif free.knob.parameter in values:
            moved[j] = free.variable(values[free.knob.parameter])
    return np.clip(moved, *problem.bounds())
