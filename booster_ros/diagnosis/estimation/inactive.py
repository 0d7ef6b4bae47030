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

from collections.abc import Mapping

import numpy as np

from booster_ros.diagnosis.estimation.least_squares import Residuals
from booster_ros.diagnosis.estimation.parallel import side_by_side

Array = np.ndarray

AWAY = (-2.0, -1.0, 1.0, 2.0)
"""Steps to where a parameter may move something, in standard deviations of its prior."""

BY_CHANCE = 10.0
"""Change of the cost for each variable up to which it is taken for chance, in mean squares of what
is left: one where residuals are white, and some times that where they are coloured."""


def place_beyond(residuals: Residuals, z: Array, jacobian: Array, dormant: Mapping[int, float],
                 room: tuple[Array, Array]) -> Array | None:
    """
    Return where another descent may begin, None where nothing speaks for one.

    `jacobian`, shape (residuals, variables), is that of `residuals` at z. `dormant` has the
    variables that move nothing but their priors there, with the standard deviations of these;
    `room` are the lower and upper bounds of z.
    """
    moves = []
    for j, sigma in dormant.items():
        for away in AWAY:
            moved = z.copy()
            moved[j] = np.clip(z[j] + away * sigma, room[0][j], room[1][j])
            if moved[j] != z[j]:
                moves.append(moved)
    if not moves:
        return None
    able = np.setdiff1d(np.flatnonzero(np.any(jacobian != 0.0, axis=0)), list(dormant))
    others, upper = np.linalg.qr(jacobian[:, able])

    def left(missed: Array) -> float:
        return float(np.sum(missed**2) - np.sum((others.T @ missed)**2))

    here = residuals(z)
    missed = side_by_side(residuals, moves)
    least = int(np.argmin([left(each) for each in missed]))
    if left(missed[least]) > left(here) - BY_CHANCE * max(left(here) / len(here), 1.0):
        return None
    begin = moves[least].copy()
    begin[able] -= np.linalg.lstsq(upper, others.T @ missed[least])[0]
    return np.asarray(np.clip(begin, *room))
