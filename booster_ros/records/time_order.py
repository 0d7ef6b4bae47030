# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Put rows in order of time: newest first, clocks that were changed, counters that wrap, runs.

A clock that goes back by more than disorder explains begins another run: a record of its own.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from booster_ros.records.record import Array, Defect, RecordError

HOUR = 3600.0
_COUNTS = {f'{bits} bits of {name}': 2.0**bits * unit for bits in (16, 24, 31, 32)
           for name, unit in (('milliseconds', 1e-3), ('microseconds', 1e-6))}
_COUNTS['a day'] = 86400.0
_NEAR = 5.0
"""Usual steps within which a time is near another one."""

_DISORDER = 0.02
"""Largest share of rows that are out of order in a record that is not made of runs."""


class Ordered(NamedTuple):
    """Times, s, in the order of the file, the runs as indices into it, and what was done."""

    time: Array
    runs: list[Array]
    defects: list[Defect]


def in_order(time: Array, rows: Array, zone: str | None, where: str) -> Ordered:
    """
    Return times and the runs that they are in, each with times that do not fall.

    `time`, shape (n,), s, NaN where missing; `rows` are the numbers of the rows. With a `zone` a
    step of an hour too much or too little is a clock that was changed; RecordError without one.
    """
    known = np.flatnonzero(np.isfinite(time))
    defects: list[Defect] = []
    if known.size < 3:
        return Ordered(time, [known], defects)
    order = known
    steps = np.diff(time[known])
    if np.mean(steps < 0.0) > 0.5:
        order = known[::-1]
        defects.append(_defect('newest_first', rows, order,
                               'newest row first, read from the last to the first'))
    time = time.copy()
    defects += _change_clock(time, order, rows, zone, where)
    defects += _unwrap(time, order, rows)
    runs, disordered = _runs(time, order)
    if disordered:
        defects.append(_defect('disorder', rows, order,
                               f'{disordered} rows out of order, sorted by time'))
    return Ordered(time, runs, defects)


def _usual(steps: Array) -> float:
    rising = steps[steps > 0.0]
    return float(np.median(rising)) if rising.size else 0.0


def _change_clock(
    time: Array, order: Array, rows: Array, zone: str | None, where: str
) -> list[Defect]:
    """Take out, in place, steps of an hour that a clock made when it was changed."""
    steps = np.diff(time[order])
    usual = _usual(steps)
    if not 0.0 < usual < HOUR / 4.0:
        return []
    found = []
    for sign in (-1.0, 1.0):
        # the step is an hour, and one that is usual, but for a little
        at = np.flatnonzero(np.abs(steps - sign * HOUR - usual) < 0.5 * usual)
        if at.size > 2:  # a record with gaps of an hour, or cycles of one
            continue
        if at.size and (zone is None or _has_no_summer(zone)):
            if sign < 0.0 and zone is None:
                row = rows[order[at[0] + 1]]
                raise RecordError(
                    f'{where}, row {row}: the clock goes back by an hour; if it hung on a wall, '
                    'say in which zone: time: {zone: Europe/Berlin}, or else zone: UTC')
            continue
        for place in at.tolist():
            time[order[place + 1:]] -= sign * HOUR
            row = int(rows[order[place + 1]])
            way = 'forward' if sign > 0.0 else 'back'
            found.append(Defect('clock_change', 'time', row, row, 1,
                                f'the clock on the wall went {way} by an hour ({zone}); time '
                                'runs on'))
    return found


def _has_no_summer(zone: str) -> bool:
    return zone.upper() in ('UTC', 'GMT', 'Z') or zone.startswith('Etc/')


def _unwrap(time: Array, order: Array, rows: Array) -> list[Defect]:
    """Let, in place, a counter that came to its end and began again run on."""
    steps = np.diff(time[order])
    usual = _usual(steps)
    back = np.flatnonzero(steps < -_NEAR * usual)
    for meaning, count in _COUNTS.items():
        on = steps[back] + count
        if back.size and np.all((on >= 0.0) & (on <= _NEAR * usual)) and (
                np.max(time[order]) <= count):
            for place in back.tolist():
                time[order[place + 1:]] += count
            row = int(rows[order[back[0] + 1]])
            return [Defect('wrapped_counter', 'time', row, row, len(back),
                           f'the counter wrapped after {meaning}; time runs on')]
    return []


def _runs(time: Array, order: Array) -> tuple[list[Array], int]:
    """Return the runs, and how many rows were out of order within one."""
    steps = np.diff(time[order])
    usual = _usual(steps)
    back = steps < 0.0
    far = back & (steps < -_NEAR * max(usual, 0.0))
    near = int(np.count_nonzero(back & ~far))
    if near > _DISORDER * len(order) + 1:
        far, near = back, 0
    begins = np.flatnonzero(far) + 1
    runs = np.split(order, begins)
    if near:
        runs = [run[np.argsort(time[run], kind='stable')] for run in runs]
    return runs, near


def _defect(kind: str, rows: Array, order: Array, text: str) -> Defect:
    first, last = int(min(rows[order])), int(max(rows[order]))
    return Defect(kind, 'time', first, last, len(order), text)
