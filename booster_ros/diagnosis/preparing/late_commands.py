# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Commands that the valve took somewhere between two rows.

A clock that stamps rows as they arrive does not know when in between the valve took a command: each
one anywhere in a row, with a standard deviation of its length over sqrt(12).
"""

from dataclasses import replace

import numpy as np

from booster_ros.diagnosis.experiment.experiment import Experiment
from booster_ros.model.system import PositionerParameters

Array = np.ndarray

EVEN = 1e-3
"""Rows this evenly spaced, relative to their distance, are those of one clock with the drive."""

DRAWS = 4

OFTEN = 0.5
"""Share of rows in which a command comes a row late: its standard deviation is half a row."""

AS_OFTEN = 0.5 - np.sqrt(1.0 / 6.0)
"""The same where its standard deviation is a row over sqrt(12), as that of a uniform delay."""


def commands_may_be_late(experiment: Experiment) -> bool:
    """Tell whether rows are stamped by another clock than that of the commands."""
    if experiment.quasi_static or np.ptp(experiment.current) == 0.0:
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

    Drawn is a whole row late or none, whose standard deviation is sqrt(3) times what it should be:
    seldom late would take more draws.
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
