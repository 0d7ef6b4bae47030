# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The test set: the last part of a record, opened once, by which nothing is fitted or chosen."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from booster_ros.diagnosis.data.blocks import Segment, rows_of
from booster_ros.diagnosis.data.experiment import Experiment
from booster_ros.diagnosis.result import ChannelError
from booster_ros.diagnosis.selection.decide import NOISE


def without_test_set(experiment: Experiment, segments: list[Segment]) -> Experiment:
    """Return the experiment without the values of the test set, by which nothing may be chosen."""
    rows = rows_of(segments, 'train', len(experiment.time))
    return replace(experiment, measured={
        name: np.where(rows, values, np.nan) for name, values in experiment.measured.items()})


def stands(errors: Mapping[str, ChannelError]) -> bool:
    """
    Tell whether what was added makes the error in data that were not fitted no larger.

    Its square is told as well as the level of the noise is.
    """
    seen = [error for error in errors.values() if np.isfinite(error.before)]
    before, after = (sum((getattr(error, stage) / error.noise)**2 for error in seen)
                     for stage in ('before', 'after'))
    return after <= NOISE * max(before, float(len(seen)))
