# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Where fits of dry friction begin: the best of a grid.

The statistics of windows have several minima over friction. So sliding friction and stiction are
tried over a grid, for a packing that yields and for one that does not; each trial takes one run of
the model. (Stick-slip of a slowly driven mass: B. Armstrong-Helouvry et al., Automatica 30 (1994)
1083.)
"""

from collections.abc import Iterable, Mapping

import numpy as np

from booster_ros.diagnosis.data.experiment import Array
from booster_ros.diagnosis.estimation.parallel import side_by_side
from booster_ros.diagnosis.estimation.parametrisation import Free
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.model.catalogue import EFFECTS
from booster_ros.model.scaling import proportion

_DAMPING = 'actuator.presliding_damping'

SLIDING = (75.0, 106.0, 150.0, 212.0, 300.0, 424.0, 600.0, 849.0, 1200.0)
"""Values of sliding friction that are tried, N, in a valve of the paper's size: closer trials reach
from each to the next."""

BREAKING_AWAY = (0.0, 0.2, 0.4, 0.8)
"""Values of stiction that are tried, as shares of the sliding friction."""

DAMPINGS = (0.0, 0.3, 0.6)
"""Damping of a packing that is tried, as shares of the critical one, 0 for one that does not yield:
damping and viscous friction trade."""

KEPT, CLOSER = 3, (0.06, 0.03, 0.015)
"""Number of best trials around which closer ones follow, and the steps of these, round by round, as
shares of the sliding friction; those of the stiction are twice as long."""

_Trial = tuple[float, float, float]


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

    def tried(trials: Iterable[_Trial]) -> list[tuple[float, _Trial]]:
        several = list(dict.fromkeys(trials))
        costs = side_by_side(lambda one: problem.cost(_placed(problem, z, *one)), several)
        return sorted(zip(costs, several))[:KEPT]

    larger = proportion(problem.base, 'actuator', 'N')
    forces = [(larger * force, share) for force in SLIDING for share in BREAKING_AWAY]
    yields = any(free.knob.parameter == _DAMPING for free in problem.freedoms)
    best = tried((*one, damping) for one in forces for damping in DAMPINGS[:None if yields else 1])
    for step in CLOSER:
        best = tried((force * (1.0 + step * j), max(share + 2.0 * step * k, 0.0), damping)
                     for _, (force, share, damping) in best
                     for j in (-2, -1, 0, 1, 2) for k in (-1, 0, 1))
    return [_placed(problem, z, *one) for _, one in best]


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
