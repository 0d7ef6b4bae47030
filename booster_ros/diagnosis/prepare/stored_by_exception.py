# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The noise of channels that a historian stored only when they had changed by more than a limit."""

from collections.abc import Mapping
from dataclasses import replace
from math import sqrt

from booster_ros.diagnosis.data.experiment import Experiment

UNIFORM = 1.0 / sqrt(3.0)
"""Standard deviation of what lies anywhere within a limit on either side, in limits."""


def with_limits_of_storing(experiment: Experiment, held: Mapping[str, float]) -> Experiment:
    """
    Return the experiment with at least the noise that the limits of storing leave.

    `held` has the limit of each channel, in its unit. Between two stored values the channel was
    anywhere within the limit, while the held values show no noise at all.
    """
    return replace(experiment, noise={
        name: max(level, UNIFORM * held.get(name, 0.0))
        for name, level in experiment.noise.items()})
