# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Dead band, resolution, hysteresis: how much of a change of the set point moves nothing.

Dead band: the change of the set point after a reversal that the position does not answer
(ISA-75.25.01; IEC 61298-2). Resolution: the same without a reversal. Hysteresis, dead band
included: how much lower the position stands when it is approached from below (IEC 61298-2).
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from .segments import Course, Ramp
from .step_response import NOISE_BAND, StepResponse

SLOWEST_SHARE = 0.5
"""Share of a dead band, seen in a ramp, that the delay of the response may make up."""


class Bound(NamedTuple):
    """
    What steps tell of a size, m: the largest that moved nothing, the smallest that moved the stem.

    None where there was no such step. `rows` are the first rows of the steps looked at.
    """

    without_motion: float | None
    with_motion: float | None
    rows: tuple[int, ...]


class Reversal(NamedTuple):
    """A ramp that turns: the change of set point until the position follows, m, and its row."""

    row: int
    change: float


class Offset(NamedTuple):
    """Mean set point less position, m, after steps up less that after steps down; the counts."""

    difference: float
    up: int
    down: int


def bounds_of_steps(responses: list[StepResponse]) -> tuple[Bound, Bound]:
    """
    Return what steps tell of the dead band and of the resolution.

    A step that moves nothing counts together with those before it, since the stem last moved.
    """
    still: dict[bool, list[float]] = {True: [], False: []}
    moved: dict[bool, list[float]] = {True: [], False: []}
    rows: dict[bool, list[int]] = {True: [], False: []}
    direction, waiting, last = 0.0, 0.0, None
    for response in responses:
        if last is None or response.first != last + 1:
            direction, waiting = 0.0, 0.0
        last = response.last
        waiting += response.size
        if direction != 0.0 and waiting != 0.0:
            reverses = bool(np.sign(waiting) != direction)
            (moved if response.change else still)[reverses].append(abs(waiting))
            rows[reverses].append(response.first)
        if response.change:
            direction, waiting = float(np.sign(response.change)), 0.0

    def bound(reverses: bool) -> Bound:
        return Bound(max(still[reverses], default=None), min(moved[reverses], default=None),
                     tuple(rows[reverses]))

    return bound(True), bound(False)


def reversals(course: Course, found: list[Ramp], noise: float, delay: float) -> list[Reversal]:
    """
    Return how far the set point goes after a turn from ramp to ramp until the position follows.

    The way that it makes within `delay` (s), the dead time of the response, is taken off. Turns
    after which that is more than SLOWEST_SHARE of what is seen are left out: too fast to tell.
    """
    out = []
    for one, other in pairwise(found):
        if other.first - one.last > 1 or one.rate * other.rate >= 0.0:
            continue
        moved = np.sign(other.rate) * course.position[other.first:other.last + 1]
        way = moved - np.minimum.accumulate(moved)
        followed = np.flatnonzero(way > 2.0 * NOISE_BAND * noise + 1e-12)
        if not len(followed):
            continue
        row = other.first + int(followed[0])
        seen = abs(float(course.set_point[row] - course.set_point[other.first]))
        beyond = abs(other.rate) * delay
        if beyond <= SLOWEST_SHARE * seen:
            out.append(Reversal(other.first, seen - beyond))
    return out


def hysteresis(responses: list[StepResponse]) -> Offset | None:
    """Return by how much settled positions depend on where they are approached from."""
    sides = {sign: [response.offset for response in responses
                    if response.settled and response.change * sign > 0.0
                    and response.offset is not None]
             for sign in (1.0, -1.0)}
    if not all(sides.values()):
        return None
    return Offset(float(np.mean(sides[1.0]) - np.mean(sides[-1.0])), len(sides[1.0]),
                  len(sides[-1.0]))
