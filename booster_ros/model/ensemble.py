# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Many parameter sets over one input, on all cores."""

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
import os

import numpy as np

from .simulation import simulate
from .stream import DEFAULT_TOLERANCE
from .system import PositionerParameters

COLUMNS = ('chamber_pressure', 'valve_position')
"""Columns of a simulation that an ensemble keeps unless others are asked for."""


def simulate_ensemble(
    parameter_sets: Sequence[PositionerParameters],
    time: np.ndarray,
    command: np.ndarray,
    columns: Sequence[str] = COLUMNS,
    initial: Mapping[str, float] | None = None,
    pinned: Mapping[str, np.ndarray] | None = None,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    compiled: bool = True,
) -> dict[str, np.ndarray]:
    """
    Simulate every parameter set over the same rows, with the same bits as `simulate`.

    `command` is a control current, A, or a set point, m, as there.

    Return arrays of shape (sets, rows), SI, for the `columns` asked for (names of `Outputs`).
    Machine code runs outside Python's lock, so that `threads` (default: as many as cores) share
    the work; they share no state, so their number changes nothing else. ValueError where
    shapes or times do not fit, KeyError for an unknown column.
    """
    kept = {name: np.empty((len(parameter_sets), len(time))) for name in columns}

    def run(k: int) -> None:
        outcome = simulate(
            parameter_sets[k], time, command, initial, pinned, tolerance, compiled)
        for name, rows in kept.items():
            rows[k] = outcome[name]

    first = range(len(parameter_sets))[:1]
    for k in first:
        run(k)  # alone: it compiles, or loads what has been compiled, and others would wait for it
    with ThreadPoolExecutor(threads or os.cpu_count()) as pool:
        for _ in pool.map(run, range(len(first), len(parameter_sets))):
            pass
    return kept
