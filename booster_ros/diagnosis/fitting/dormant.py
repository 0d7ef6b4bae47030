# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Parameters that move nothing where a descent has ended, but would further on.

A largest opening that is never reached moves nothing as it is given; a smaller one would be
reached, and may be what the valve has. Its slope is zero, so a descent leaves it where it is, and
bends other parameters to what it does. So, from the end of the descent,

1. each such parameter is moved by one and by two standard deviations to either side, and the model
   is run;
2. what that misses is reckoned less what all other parameters can make up for by their slopes;
3. where least is left, if it is less than before by more than chance, another descent may begin.
"""

from collections.abc import Sequence

import numpy as np

from booster_ros.diagnosis.fitting.descent import Residuals
from booster_ros.diagnosis.fitting.side_by_side import side_by_side

Array = np.ndarray

AWAY = (-2.0, -1.0, 1.0, 2.0)
"""Steps to where a parameter may move something, in standard deviations of its prior."""

BY_CHANCE = 10.0
"""Fall of the cost up to which it is taken for chance."""


def place_beyond(residuals: Residuals, z: Array, jacobian: Array, dormant: Sequence[int],
                 room: tuple[Array, Array]) -> Array | None:
    """
    Return where another descent may begin, None where nothing speaks for one.

    `jacobian`, shape (residuals, variables), is that of `residuals` at z, where the `dormant`
    variables move nothing but their priors; `room` are the lower and upper bounds of z.
    """
    moves = []
    for j in dormant:
        for away in AWAY:
            moved = z.copy()
            moved[j] = np.clip(z[j] + away, room[0][j], room[1][j])
            if moved[j] != z[j]:
                moves.append((j, moved))
    if not moves:
        return None
    others, upper = np.linalg.qr(np.delete(jacobian, dormant, axis=1))
    kept = np.setdiff1d(np.arange(len(z)), dormant)

    def left(missed: Array) -> float:
        return float(np.sum(missed**2) - np.sum((others.T @ missed)**2))

    missed = side_by_side(lambda move: residuals(move[1]), moves)
    least = int(np.argmin([left(each) for each in missed]))
    if left(missed[least]) > left(residuals(z)) - BY_CHANCE:
        return None
    begin = moves[least][1]
    begin[kept] -= np.linalg.lstsq(upper, others.T @ missed[least])[0]
    return np.asarray(np.clip(begin, *room))
