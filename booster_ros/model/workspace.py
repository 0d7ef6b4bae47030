# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the step methods share: scratch memory, and the error that a step may have."""

from typing import NamedTuple

from .state import STATES

# Error per step that is tolerated: Pa, Pa, Pa, Pa, K, -, m, m/s, N.
TOLERANCE = (2.0, 2.0, 2.0, 2.0, 1e-2, 2e-5, 1e-7, 3e-6, 5e-3)


class Workspace(NamedTuple):
    """
    Scratch memory of the solver: lists of floats, or float arrays where compiled.

    `start` is the state at the start of a step that reaches beyond its interval, `rates` are the
    derivatives at the start of a step, `trial` is the state at its end.
    """

    start: list[float]
    rates: list[float]
    stage_rates: list[float]
    trial: list[float]
    k1: list[float]
    k2: list[float]
    k3: list[float]
    k4: list[float]
    jacobian: list[float]
    matrix: list[float]
    slopes: list[float]


def new_workspace() -> Workspace:
    """Return scratch memory for plain Python."""
    return Workspace(*([0.0] * STATES for _ in range(8)), *([0.0] * STATES**2 for _ in range(3)))
