# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Where fits of dry friction begin: the best of a grid.

The statistics of windows have several minima over friction. So sliding friction and stiction are
tried over a grid, for a packing that yields and for one that does not, then closer around the best
of each; each trial takes one run of the model.
(Stick-slip of a slowly driven mass: B. Armstrong-Helouvry et al., Automatica 30 (1994) 1083.)
"""

from collections.abc import Iterable
import itertools

import numpy as np

from booster_ros.diagnosis.estimation.parallel import side_by_side
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.model.scaling import proportion

Array = np.ndarray

SLIDING = (75.0, 120.0, 190.0, 300.0, 475.0, 755.0, 1200.0)
"""Values of sliding friction that are tried, N, in a valve of the paper's size: closer trials reach
half of the way to the next."""

BREAKING_AWAY = (0.0, 0.2, 0.4, 0.8)
"""Values of stiction that are tried, as shares of the sliding friction."""

KEPT, CLOSER = 2, (0.1, 0.04)
"""
Number of best trials of a kind around which closer ones follow, and the steps of these, round by
round: of the sliding friction, as a share of it, and of the share that breaks away.
"""

DAMPINGS = (0.3, 0.6)
"""Damping of a packing from which fits begin, as shares of the critical one: a descent does not get
from much damping to little, as damping and viscous friction trade."""

_STICTION = 'actuator.stiction'
_Trial = tuple[float, float, bool]


def friction_starts(problem: Problem, z: Array) -> list[Array]:
    """
    Return where to begin with dry friction, all else as it is at z; z alone if none is free.

    The best of the grid for a packing that yields and one that does not; for each damping where it
    yields. The start is as given.
    """
    if not any(free.knob.rubs for free in problem.freedoms):
        return [z]

    def tried(trials: Iterable[_Trial]) -> list[tuple[float, _Trial]]:
        several = list(dict.fromkeys(trials))
        costs = side_by_side(lambda one: problem.cost(_placed(problem, z, *one)), several)
        return sorted(zip(costs, several))[:KEPT]

    larger = proportion(problem.base, 'actuator', 'N')
    places: list[Array] = []
    for yields in (False, True):
        best = tried(itertools.product(
            [larger * force for force in SLIDING], BREAKING_AWAY, [yields]))
        for step in CLOSER:
            best = sorted({*best, *tried(
                (force * (1.0 + step * j), max(share + step * k, 0.0), yields)
                for _, (force, share, _) in best
                for j in (-2, -1, 0, 1, 2) for k in (-1, 0, 1))})[:KEPT]
        for _, one in best:
            places += _dampings(problem, _placed(problem, z, *one))
    return places


def _placed(problem: Problem, z: Array, sliding: float, share: float, yields: bool) -> Array:
    """
    Return z with this sliding friction (N) and stiction (a share of it), the start as given.

    The shapes of the packing, which yields or does not, become typical.
    """
    moved = z.copy()
    moved[len(problem.freedoms):] = 0.0
    for j, free in enumerate(problem.freedoms):
        name = free.knob.parameter
        if free.knob.rubs:
            moved[j] = free.variable(sliding)
        elif name == _STICTION:
            moved[j] = free.variable(share * sliding)
        elif name == 'actuator.presliding_stiffness':
            moved[j] = free.variable(free.knob.typical if yields else 0.0)
        elif name in ('actuator.presliding_damping', 'actuator.stribeck_velocity'):
            moved[j] = free.variable(free.knob.typical)
    return np.clip(moved, *problem.bounds())


def _dampings(problem: Problem, z: Array) -> list[Array]:
    """Return z with each of DAMPINGS of the packing; z alone if it does not yield."""
    at = {free.knob.parameter: j for j, free in enumerate(problem.freedoms)}
    damped = at.get('actuator.presliding_damping')
    if damped is None or z[at['actuator.presliding_stiffness']] <= 0.0:
        return [z]
    places = [z.copy() for _ in DAMPINGS]
    for place, damping in zip(places, DAMPINGS):
        place[damped] = problem.freedoms[damped].variable(damping)
    return places
