# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Where a fit of a stem that sticks may begin: with the friction that fits best through slips.

The timing of slips makes the cost of a fit rough, and a fit from friction that is far off ends in
the nearest hollow. Friction that was fitted while something above the stem was missing is far off.
So sliding friction and stiction are tried over their range, first widely, then closely around the
best, for a packing that yields and for one that does not; each trial takes one run of the model.
"""

from collections.abc import Iterable
import itertools

import numpy as np

from booster_ros.diagnosis.fitting.fit import Problem
from booster_ros.diagnosis.fitting.intervals import shapes_of
from booster_ros.diagnosis.fitting.proportion import proportion
from booster_ros.diagnosis.fitting.side_by_side import side_by_side
from booster_ros.model.actuator import is_rigid
from booster_ros.model.catalogue import EFFECTS

Array = np.ndarray

SLIDING = (75.0, 110.0, 150.0, 220.0, 300.0, 400.0, 550.0, 750.0, 1000.0, 1400.0)
"""Values of sliding friction that are tried, N, in a valve of the paper's size."""

BREAKING_AWAY = (0.0, 0.2, 0.4, 0.8)
"""Values of stiction that are tried with each of these, as shares of the sliding friction."""

HOLLOWS = 5
CLOSER = ((0.06, 0.1), (0.03, 0.05), (0.015, 0.025))
"""
Number of best trials around which closer ones follow, and the steps of these, round by round: of
the sliding friction, as a share of it, and of the share that breaks away.
"""

DAMPINGS = (0.3, 0.6)
"""Values of the damping of a packing from which fits begin, as shares of critical damping."""

_STICTION = 'actuator.stiction'
_Trial = tuple[float, float, bool]


def best_friction(problem: Problem, z: Array) -> Array:
    """
    Return z with the friction that fits best through slips, beside everything else as it is.

    How friction differs along the travel stays, too; the shapes of the packing become typical. The
    start is as given, as it had bent itself to the earlier friction. Return z itself where no
    friction is free, or none does better than that at z.
    """
    if not any(free.knob.rubs for free in problem.freedoms):
        return z

    def placed(trial: _Trial) -> Array:
        return with_friction(problem, z, *trial)

    def tried(trials: Iterable[_Trial]) -> list[tuple[float, _Trial]]:
        several = list(trials)
        left = side_by_side(lambda trial: problem.cost_through_slips(placed(trial)), several)
        return sorted(zip(left, several))

    larger = proportion(problem.base, 'actuator', 'N')
    sliding = [larger * force for force in SLIDING]
    hollows = tried(itertools.product(sliding, BREAKING_AWAY, (False, True)))[:HOLLOWS]
    for step, more in CLOSER:
        hollows = [tried((sliding * (1.0 + step * j), max(share + more * k, 0.0), yields)
                         for j in (-2, -1, 0, 1, 2) for k in (-1, 0, 1))[0]
                   for _, (sliding, share, yields) in hollows]
    return min(z, placed(min(hollows)[1]), key=problem.cost_through_slips)


def with_friction(problem: Problem, z: Array, sliding: float, share: float, yields: bool) -> Array:
    """
    Return z with this sliding friction (N) and stiction (a share of it), the start as given.

    The shapes of the packing, which yields or does not, become typical.
    """
    packing = _shapes_of_packings()
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
        elif name in packing:
            moved[j] = free.variable(free.knob.typical)
    return np.clip(moved, *problem.bounds())


def _shapes_of_packings() -> set[str]:
    """Return the shapes of friction that has no size but those that are tried."""
    return set().union(*(
        shapes_of(name) for name, effect in EFFECTS.items() if effect.rubs
        and all(knob.shape or knob.rubs or knob.parameter == _STICTION for knob in effect.knobs)))


def each_damping(problem: Problem, z: Array) -> list[Array]:
    """
    Return z with each of DAMPINGS of the packing, a rigid packing replaced by a soft one.

    A descent does not get from much damping to little, as damping and viscous friction trade; nor
    far from a rigid packing, with which slips come all at once. From a soft one it gets to a rigid
    one.
    """
    rigid = is_rigid(problem.parameters(z).actuator)
    places = []
    for damping in DAMPINGS:
        moved = z.copy()
        for j, free in enumerate(problem.freedoms):
            if free.knob.parameter == 'actuator.presliding_damping':
                moved[j] = free.variable(damping)
            elif free.knob.parameter == 'actuator.presliding_stiffness' and rigid:
                moved[j] = free.variable(free.knob.typical)
        places.append(moved)
    return places
