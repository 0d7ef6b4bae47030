# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Commands that the valve took at some moment between two rows.

A clock that stamps rows as they arrive does not know when between two of them the valve took a
command: it may have been anywhere in a row, with a standard deviation of the row's length over
sqrt(12).
"""

from dataclasses import replace

import numpy as np

from booster_ros.diagnosis.data.experiment import Experiment
from booster_ros.model.system import PositionerParameters

Array = np.ndarray

EVEN = 1e-3
"""Unevenness of the spacing of rows, relative to their distance, below which rows and drive have
one clock."""

DRAWS = 4

OFTEN = 0.5
"""Share of rows whose command is a row late: a standard deviation of the delay of half a row."""

AS_OFTEN = 0.5 - np.sqrt(1.0 / 6.0)
"""Share of rows for a delay with a standard deviation of a row over sqrt(12), which is that of a
uniform delay."""


def commands_may_be_late(experiment: Experiment) -> bool:
    """
    Tell whether rows are stamped by another clock than that of the commands.

    Commands that were read now and then are known no closer, and run straight from row to row.
    """
    if (experiment.quasi_static or experiment.ends is not None
            or np.ptp(experiment.current) == 0.0):
        return False
    steps = np.diff(experiment.time)
    usual = np.median(steps)
    return float(np.quantile(np.abs(steps - usual), 0.9)) >= EVEN * usual


def with_late_commands(
    experiment: Experiment, share: float, rng: np.random.Generator
) -> Experiment:
    """Return the experiment with this share of its rows commanded as the row before them."""
    before = np.append(experiment.current[:1], experiment.current[:-1])
    return replace(experiment, current=np.where(
        rng.random(len(before)) < share, before, experiment.current))


def with_noise_of_timing(experiment: Experiment, declared: PositionerParameters) -> Experiment:
    """
    Return the experiment with the noise of each channel at least what late commands leave.

    Each command is drawn a whole row late or not late, with a standard deviation that is sqrt(3)
    times what it should be: if they were late more seldom, more draws would be needed.
    """
    rng = np.random.default_rng(1)
    taken = experiment.predict(declared)
    squares: dict[str, list[float]] = {name: [] for name in experiment.noise}
    for _ in range(DRAWS):
        moved = with_late_commands(experiment, OFTEN, rng).predict(declared)
        for name, values in squares.items():
            values.append(float(np.mean((moved[name] - taken[name])**2)))
    return replace(experiment, noise={
        name: max(level, float(np.sqrt(np.mean(squares[name]) / 3.0)))
        for name, level in experiment.noise.items()})
