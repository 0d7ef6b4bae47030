# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Runs of a bag: what was recorded before and after its clock was set."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TypeVar

import numpy as np

from booster_ros.records.clock import CLOCK_SET
from booster_ros.records.mapping import ASKED, FileMapping
from booster_ros.records.record import Array, Defect, RecordError

Key = TypeVar('Key')


def run_starts(times: Iterable[Array]) -> list[int]:
    """Return the stamps (ns) with which runs begin, in the order of time."""
    every = np.unique(np.concatenate(list(times)))
    return [int(every[0]), *map(int, every[1:][np.diff(every) > CLOCK_SET * 1e9])]


def in_run(times: Array, starts: list[int], run: int) -> Array:
    """Return which stamps (ns) belong to a run; the first is 1."""
    return np.searchsorted(np.array(starts), times, side='right') == run


def longest(times: Iterable[Array], starts: list[int]) -> int:
    """Return the number of the run with the most stamps."""
    every = np.concatenate(list(times))
    return 1 + int(np.argmax(_counts(every, starts)))


def listed(times: Iterable[Array], starts: list[int]) -> str:
    """Return what the runs are, for a sentence."""
    counts = _counts(np.concatenate(list(times)), starts)
    return '; '.join(f'{number}: {count} messages from {start * 1e-9:.10g} s on'
                     for number, (count, start) in enumerate(zip(counts[:8], starts), 1)
                     ) + ' …' * (len(starts) > 8)


def chosen_run(
    times: Mapping[Key, Array], mapping: FileMapping | None, source: str
) -> tuple[dict[Key, Array], list[Defect]]:
    """
    Return which samples of each channel are used, and a note.

    They are all, unless the clock was set on the way; then those of the run that is mapped.
    RecordError where it names none, or one that is not there.
    """
    starts = run_starts(times.values())
    run = None if mapping is None or mapping.run == ASKED else mapping.run
    where = 'the mapping' if mapping is None else mapping.source
    if len(starts) == 1 and run in (None, 1):
        return {key: np.full(len(one), True) for key, one in times.items()}, []
    if run is None:
        raise RecordError(
            f'{source}: its clock was set on the way, and it has {len(starts)} runs, each a record '
            f'of its own ({listed(times.values(), starts)}); say which in a mapping, as in run: 1')
    if not 1 <= int(run) <= len(starts):
        raise RecordError(f'{where}, run: there is no run {run}, {source} has {len(starts)}')
    kept = {key: in_run(one, starts, int(run)) for key, one in times.items()}
    count = sum(int(one.sum()) for one in kept.values())
    return kept, [Defect('run', 'time', 0, 0, count,
                         f'run {run} of {len(starts)} in this bag: its clock was set')]


def _counts(every: Array, starts: list[int]) -> Array:
    return np.bincount(np.searchsorted(np.array(starts), every, side='right') - 1,
                       minlength=len(starts))
