# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Gaps of what drives a model: which rows after a gap show what went on in it.

A run goes on through a gap with the current as it last stood, and with measured drives on a
straight line. What really drove the valve meanwhile shows until its chamber has caught up.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from booster_ros.diagnosis.data.experiment import Array, Experiment
from booster_ros.model.system import PositionerParameters
from booster_ros.records.holding import last_known
from booster_ros.records.time_axis import gap_rows

SHORT_GAP = 0.5
MISSED = 5e-4
"""Longest gap, s, and most that holding the drive through it may miss, as a share of the drive's
range times seconds, for all rows after it to count: the chamber hardly notices."""


def gaps_that_hide(time: Array, columns: Mapping[str, Array], drives: Sequence[str]) -> list[slice]:
    """Return the gaps that hide what moves the chamber: from the last row known to the next."""
    if not drives:
        return []
    known = np.all([np.isfinite(columns[name]) for name in drives], axis=0)
    resumed = np.flatnonzero(np.diff(known.astype(np.int8)) == 1) + 1
    ends = np.union1d(gap_rows(time), resumed).astype(int)
    if not len(ends):
        return []
    missed = np.any([_misses(time, columns[name], ends) for name in drives], axis=0)
    last = last_known(np.where(known, 0.0, np.nan))
    return [slice(max(int(last[row - 1]), 0), int(row)) for row in ends[missed]]


def caught_up(experiment: Experiment, declared: PositionerParameters, gaps: Sequence[slice]
              ) -> Array:
    """
    Tell of each row, shape (n,), whether it shows nothing of what went on in a gap before it.

    The declared model is driven in every gap once with the least that the record has of each drive
    and once with the most. Both come to the same, within the noise, once the chamber has caught up.
    """
    counts = np.ones(len(experiment.time), dtype=bool)
    if not gaps:
        return counts
    hidden = np.zeros(len(counts), dtype=bool)
    for gap in gaps:
        hidden[gap] = True
    low, high = (replace(
        experiment, current=np.where(hidden, bound(experiment.current), experiment.current),
        pinned={name: np.where(hidden, bound(values), values)
                for name, values in experiment.pinned.items()},
    ).predict(declared) for bound in (np.min, np.max))
    apart = np.any([np.abs(low[name] - high[name]) > experiment.noise[name]
                    for name in experiment.channels], axis=0)
    for gap, end in zip(gaps, [*(later.start for later in gaps[1:]), len(counts)], strict=True):
        differ = np.flatnonzero(apart[gap.stop:end])
        if len(differ):
            counts[gap.stop:gap.stop + differ[-1] + 1] = False
    return counts


def _misses(time: Array, drive: Array, rows: Array) -> Array:
    """Tell of each of these rows whether a gap before it hides what moves the chamber."""
    known, before = np.isfinite(drive), last_known(drive)[rows - 1]
    gap, changed = time[rows] - time[before], np.abs(drive[rows] - drive[before])
    hides = (gap > SHORT_GAP) | (gap * changed > MISSED * np.ptp(drive[known]))
    return np.asarray(hides | ~known[rows] | (before < 0))
