# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Whole experiment segments, and which of them fit, select and test."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

Array = np.ndarray

SHORTEST = 3.0
"""A segment lasts at least this long, s: a chamber fills in seconds."""

LONGEST = 8.0
"""A segment without a change of the drive is cut after this time, s."""


SWEEP_ROWS = 2
SWEEP_ROLES = ('fit', 'select', 'fit', 'test', 'fit', 'select', 'fit')
"""Rows in a segment of a sweep without time, and what one after the other is for."""


@dataclass(frozen=True)
class Segment:
    """Rows first..last (last excluded) of a record, and what they are for."""

    first: int
    last: int
    role: str  # 'fit', 'select' or 'test'


def drive_changes(time: Array, drive: Array) -> Array:
    """Return the rows at which the drive steps or a ramp begins or ends."""
    if len(time) < 3:
        return np.array([], dtype=int)
    slope = np.diff(drive) / np.diff(time)
    change = np.abs(np.diff(slope))
    spread = np.ptp(drive) / max(time[-1] - time[0], 1e-9)
    return np.flatnonzero(change > 0.2 * spread + 1e-30) + 1


def split(time: Array, drive: Array, locked: float = 0.2) -> list[Segment]:
    """
    Cut a record at changes of its drive and give each segment a role.

    The last `locked` share of the record is the test part, opened once. Of the rest every third
    segment selects between models, the others fit them.
    """
    edges = [0]
    changes = drive_changes(time, drive)
    for row in changes:
        if time[row] - time[edges[-1]] >= SHORTEST and time[-1] - time[row] >= SHORTEST:
            edges.append(int(row))
    fine = []
    for first, last in zip(edges, [*edges[1:], len(time)]):
        length = time[min(last, len(time) - 1)] - time[first]
        parts = max(1, int(np.ceil(length / LONGEST)))
        fine.extend(np.linspace(first, last, parts + 1).astype(int)[:-1].tolist())
    fine.append(len(time))
    begin_test = time[0] + (1.0 - locked) * (time[-1] - time[0])
    segments: list[Segment] = []
    for k, (first, last) in enumerate(pairwise(fine)):
        if last <= first:
            continue
        middle = 0.5 * (time[first] + time[last - 1])
        role = 'test' if middle > begin_test else ('select' if k % 3 == 1 else 'fit')
        segments.append(Segment(first, last, role))
    return segments


def split_sweep(rows: int) -> list[Segment]:
    """
    Cut a sweep without time into short segments of which every seventh is locked.

    Interleaved, because each part of a sweep is a state of its own: one that was left out as a
    whole could not be known from the others.
    """
    edges = [*range(0, rows - SWEEP_ROWS + 1, SWEEP_ROWS), rows]
    return [Segment(first, last, SWEEP_ROLES[k % len(SWEEP_ROLES)])
            for k, (first, last) in enumerate(pairwise(edges))]


def segment_of_row(segments: list[Segment], size: int) -> Array:
    """Return which of the segments each row belongs to, shape (size,), -1 for none."""
    of_row = np.full(size, -1)
    for k, segment in enumerate(segments):
        of_row[segment.first:segment.last] = k
    return of_row


def rows_of(segments: list[Segment], roles: tuple[str, ...], size: int) -> Array:
    """Return a boolean array, shape (size,), that marks the rows of these roles."""
    marked = np.zeros(size, dtype=bool)
    for segment in segments:
        if segment.role in roles:
            marked[segment.first:segment.last] = True
    return marked
