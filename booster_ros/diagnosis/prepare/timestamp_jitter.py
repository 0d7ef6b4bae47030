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

LATE = 0.5 - np.sqrt(1.0 / 6.0)
"""Share of rows whose command is a whole row late if the delay is to have the standard deviation of
one that is anywhere in a row, sqrt(1/12): share times (1 - share) is its square."""

DRAWS = 8
"""Number of runs, in each of which every command is drawn anew: what they differ by is known to a
quarter."""


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


def with_late_commands(experiment: Experiment, rng: np.random.Generator) -> Experiment:
    """Return the experiment with some of its rows, drawn, commanded as the row before them."""
    before = np.append(experiment.current[:1], experiment.current[:-1])
    return replace(experiment, current=np.where(
        rng.random(len(before)) < LATE, before, experiment.current))


def with_noise_of_timing(experiment: Experiment, declared: PositionerParameters) -> Experiment:
    """Return the experiment with the noise of each channel at least what late commands leave."""
    rng = np.random.default_rng(1)
    taken = experiment.predict(declared)
    runs = [with_late_commands(experiment, rng).predict(declared) for _ in range(DRAWS)]
    return replace(experiment, noise={
        name: max(level, float(np.sqrt(np.mean([(run[name] - taken[name])**2 for run in runs]))))
        for name, level in experiment.noise.items()})
