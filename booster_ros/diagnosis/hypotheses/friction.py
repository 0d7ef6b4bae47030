# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Fits of dry friction: where they begin, and how they get from one minimum to the next.

The statistics of windows have many minima over friction, in a valley along which stiction makes up
for sliding friction. Sliding friction and stiction are tried over a grid, for a packing that yields
and for one that does not, and the best of it go on by differential evolution; each trial takes one
run of the model.

Each further slip on the way from one end of the travel to the other is another minimum, at another
stiction, and between two of them no slope leads on. So stiction is tried in small steps, while all
else goes along (`profile`), and fits begin at the best.

Stick-slip of a slowly driven mass: B. Armstrong-Helouvry et al., Automatica 30 (1994) 1083.
Differential evolution: R. Storn and K. Price, Journal of Global Optimization 11 (1997) 341.
"""

from collections.abc import Mapping

import numpy as np
from scipy.optimize import differential_evolution

from booster_ros.diagnosis.data.experiment import Array
from booster_ros.diagnosis.estimation.fit import Fit, fit
from booster_ros.diagnosis.estimation.parametrisation import Free
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.diagnosis.estimation.profile import bounded_cost, profiled
from booster_ros.model.catalogue import EFFECTS
from booster_ros.model.scaling import proportion
from booster_ros.numerics.parallel import side_by_side

PAYS = 0.1
"""Share of the cost that another minimum has to save for the next to be looked for."""

_DAMPING, _STICTION = 'actuator.presliding_damping', 'actuator.stiction'

SLIDING = (75.0, 106.0, 150.0, 212.0, 300.0, 424.0, 600.0, 849.0, 1200.0)
"""Values of sliding friction that are tried first, N, in a valve of the paper's size."""

BREAKING_AWAY = (0.0, 0.2, 0.4, 0.8)
"""Values of stiction that are tried first, as shares of the sliding friction."""

DAMPINGS = (0.0, 0.3, 0.6)
"""Damping of a packing that is tried, as shares of the critical one, 0 for one that does not yield:
damping and viscous friction trade."""

POPULATION, GENERATIONS = 40, 6
"""Trials that go on from the grid, and how often: of 24 trials fewer came near the deepest minimum
of a record."""

KEPT = 3
"""Number of best trials of stiction that get slopes of their own."""

FINELY, WIDELY = 0.007, 40
"""Steps of stiction, as a share of it, and their number to either side: a minimum over it is some
2 % wide, and the next is 7 % away where a stroke takes fourteen slips."""

MADE_UP = 0.4
"""Sliding friction that stiction makes up for, as a share: between slips the force on a stem runs
from below the sliding friction, as a slip shoots over, to break-away."""


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
    first = grid[np.argsort(side_by_side(cost, grid), kind='stable')[:POPULATION]]
    ends = np.log([0.7 * SLIDING[0], 1.4 * SLIDING[-1]])
    best = differential_evolution(
        cost, [ends, (0.0, 1.0), (0, len(dampings) - 1)], init=first,
        maxiter=GENERATIONS, tol=0.0, polish=False, updating='deferred', seed=1,
        workers=lambda one, trials: side_by_side(one, list(trials)),
        integrality=(False, False, True)).x
    return [placed(best)]


def over_minima(problem: Problem, found: Fit) -> Fit:
    """Return the fit that another minimum over stiction leads to, again and again while it pays."""
    names = [free.knob.parameter for free in problem.freedoms]
    held = names.index(_STICTION) if _STICTION in names else None
    while held is not None and found.seen[held]:
        further = fit(problem, [_other_minimum(problem, found, held)])
        if further.cost > (1.0 - PAYS) * found.cost:
            break
        found = further
    return found


def _other_minimum(problem: Problem, found: Fit, held: int) -> Array:
    """Return the best trial of stiction, variable `held`, around a fit, all else gone along."""
    slides = [free.knob.rubs for free in problem.freedoms].index(True)
    stiction, sliding = problem.freedoms[held], problem.freedoms[slides]
    here = stiction.value(found.z[held])

    def at(step: int) -> tuple[float, Array]:
        there, z = here * np.exp(FINELY * step), found.z.copy()
        z[held] = stiction.variable(there)
        z[slides] = sliding.variable(sliding.value(z[slides]) - MADE_UP * (there - here))
        z = np.clip(z, *problem.bounds())
        return profiled(problem, z, problem.residuals(z), found.jacobian, held)

    def again(z: Array) -> tuple[float, Array]:
        residuals = problem.residuals(z)
        slopes = problem.jacobian(z, residuals, found.jacobian)
        z = profiled(problem, z, residuals, slopes, held)[1]
        return bounded_cost(problem.residuals(z)), z

    trials = sorted(side_by_side(at, range(-WIDELY, WIDELY + 1)), key=lambda trial: trial[0])
    return min(side_by_side(again, [z for _, z in trials[:KEPT]]), key=lambda end: end[0])[1]


def _placed(problem: Problem, z: Array, sliding: float, share: float, damping: float) -> Array:
    """Return z with such friction, its start as given and all other shapes typical."""
    moved = z.copy()
    moved[len(problem.freedoms):] = 0.0
    for j, free in enumerate(problem.freedoms):
        typical = free.knob.typical
        values = {_STICTION: share * sliding,
                  'actuator.presliding_stiffness': typical if damping else 0.0,
                  _DAMPING: damping or typical, 'actuator.stribeck_velocity': typical}
        if free.knob.rubs:
            moved[j] = free.variable(sliding)
        elif free.knob.parameter in values:
            moved[j] = free.variable(values[free.knob.parameter])
    return np.clip(moved, *problem.bounds())
