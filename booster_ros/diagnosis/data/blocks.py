# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Blocks of a record, each a whole step or ramp, and which of them train and which test."""

from collections import Counter
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from booster_ros.diagnosis.data.experiment import Array
from booster_ros.records import RecordError
from booster_ros.records.time_axis import gap_rows

SHORTEST = 3.0
"""A segment lasts at least this long, s: a chamber fills in seconds."""

LONGEST = 8.0
"""A segment without a change of the drive is cut after this time, s."""

TESTED = 0.2
"""Share of a record that is the test set, at its end."""

FEWEST_ROWS = 4
"""Smallest number of rows of a segment, which counts where rows are seconds apart."""

FEWEST = {'train': 4, 'test': 1}
"""Smallest number of blocks of each role; a short record is cut into shorter ones for that."""

SWEEP_ROWS, TESTED_OF_SWEEP = 2, 7
"""Rows in a block of a sweep without time; one of so many of its blocks is for testing."""

FEWEST_BLOCKS = 8
"""Number of blocks below which they are cut for resampling: of two there are three draws in all."""


@dataclass(frozen=True)
class Segment:
    """Rows first..last (last excluded) of a record, and what they are for."""

    first: int
    last: int
    role: str  # 'train' or 'test'


def drive_changes(time: Array, drive: Array) -> Array:
    """Return the rows at which the drive steps or a ramp begins or ends."""
    if len(time) < 3:
        return np.array([], dtype=int)
    steps = np.diff(time)
    slope = np.diff(drive) / np.where(steps > 0.0, steps, np.median(steps))
    change = np.abs(np.diff(slope))
    spread = np.ptp(drive) / max(time[-1] - time[0], 1e-9)
    return np.flatnonzero(change > 0.2 * spread + 1e-30) + 1


def split(time: Array, drive: Array) -> list[Segment]:
    """
    Cut a record at changes of its drive, and at gaps, and give each block a role.

    The last fifth of the record is the test set, opened once; the rest trains. RecordError where
    the record is too short for that.
    """
    clock = _clock_without_gaps(time)
    changes = np.union1d(drive_changes(clock, drive), np.flatnonzero(np.diff(clock) == 0.0) + 1)
    division = 1
    while division <= len(time):  # no finer than rows
        segments = _cut(clock, changes, SHORTEST / division, LONGEST / division)
        count = Counter(segment.role for segment in segments)
        if all(count[role] >= fewest for role, fewest in FEWEST.items()):
            return segments
        division *= 2
    raise RecordError(
        f'the record is too short, {len(time)} rows over {clock[-1] - clock[0]:.3g} s: it cannot '
        'be cut into parts to fit and to judge by')


def _clock_without_gaps(time: Array) -> Array:
    """Return the time as if none passed in gaps longer than SHORTEST."""
    after = gap_rows(time)
    after = after[time[after] - time[after - 1] > SHORTEST]
    if not len(after):
        return time
    steps = np.diff(time)
    steps[after - 1] = 0.0
    return np.concatenate((time[:1], time[0] + np.cumsum(steps)))


def _cut(clock: Array, changes: Array, shortest: float, longest: float) -> list[Segment]:
    edges = [0]
    for row in changes:
        long = min(clock[row] - clock[edges[-1]], clock[-1] - clock[row]) >= shortest
        if long and min(row - edges[-1], len(clock) - row) >= FEWEST_ROWS:
            edges.append(int(row))
    fine = []
    for first, last in zip(edges, [*edges[1:], len(clock)]):
        length = clock[min(last, len(clock) - 1)] - clock[first]
        parts = max(1, min(int(np.ceil(length / longest)), (last - first) // FEWEST_ROWS))
        fine.extend(np.linspace(first, last, parts + 1).astype(int)[:-1].tolist())
    fine.append(len(clock))
    begin_test = clock[0] + (1.0 - TESTED) * (clock[-1] - clock[0])
    return [Segment(first, last, 'test' if 0.5 * (clock[first] + clock[last - 1]) > begin_test
                    else 'train') for first, last in pairwise(fine)]


def split_sweep(rows: int) -> list[Segment]:
    """
    Cut a sweep without time into short blocks of which every seventh is for testing.

    Roles are interleaved as each part of a sweep is a state of its own.
    """
    edges = [*range(0, rows - SWEEP_ROWS + 1, SWEEP_ROWS), rows]
    return [Segment(first, last, 'test' if k % TESTED_OF_SWEEP == TESTED_OF_SWEEP // 2 else 'train')
            for k, (first, last) in enumerate(pairwise(edges))]


def training_blocks(segments: list[Segment], size: int) -> Array:
    """
    Return the number of the training block of each row, shape (size,), -1 where it is none.

    Where there are fewer than FEWEST_BLOCKS, each is cut into as many equal parts as make them.
    """
    train = [one for one in segments if one.role == 'train']
    parts = -(-FEWEST_BLOCKS // max(len(train), 1))
    of_row = np.full(size, -1)
    for k, one in enumerate(train):
        rows = one.last - one.first
        of_row[one.first:one.last] = k * parts + np.arange(rows) * parts // rows
    return of_row


def rows_of(segments: list[Segment], role: str, size: int) -> Array:
    """Return a boolean array, shape (size,), that marks the rows of this role."""
    marked = np.zeros(size, dtype=bool)
    for segment in segments:
        marked[segment.first:segment.last] = segment.role == role
    return marked
