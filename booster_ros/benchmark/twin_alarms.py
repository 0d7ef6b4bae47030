# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
False alarms of the twin against the promised rate, and how soon faults are seen beside others.

    python -m booster_ros.benchmark.twin_alarms
        [--hours H] [--drawn-hours H] [--keep FILE] [--jobs N] [--write]

1. Drawn residuals: laws, colours, drifts and set-point noise drawn valve by valve, without a model.
2. Valves: parameters, inputs, noise and drifts drawn, the model run as valve and as twin, eight
   hours each. FILE keeps what came of each, so that an interrupted run goes on.
3. The numbers of such valves with faults are given to CUSUM, Page-Hinkley and ADWIN (of river,
   where it is installed), whose thresholds are set so that they give as many false alarms on the
   clean ones as the twin promises.
"""

import argparse
from concurrent.futures import ProcessPoolExecutor
import contextlib
from functools import partial
import json
import multiprocessing
from pathlib import Path
import sys

from tqdm import tqdm

from . import twin_page
from .twin_rivals import PROMISED, rivals
from .twin_valves import (
    CLEAN, DAY, PROMISES, Watched, drawn_alarms, effects, numbers_of, twin_delay, watched)

COMMAND = 'python -m booster_ros.benchmark.twin_alarms --write'

FAULTY = 12
"""Valves drawn for each effect and size."""

CLEAN_RUNS = 100
"""Clean valves on which the thresholds of the other detectors are set."""

APART = 10_000
"""Seeds from here on are of valves with faults, from ten times this on of those for thresholds."""


def main(arguments: list[str] | None = None) -> int:
    """Run what was asked for and print the tables."""
    parser = argparse.ArgumentParser(prog='twin_alarms', description='Count alarms of the twin.')
    parser.add_argument('--hours', type=float, default=100.0, help='valve-hours with the model')
    parser.add_argument('--drawn-hours', type=float, default=10_000.0,
                        help='valve-hours of drawn residuals')
    parser.add_argument('--keep', type=Path, help='file of what came of the valves so far')
    parser.add_argument('--jobs', type=int, default=1, help='processes')
    parser.add_argument('--write', action='store_true', help='put the tables into docs/twin.md')
    given = parser.parse_args(arguments)
    # a child that was forked would have half of the threads of a library
    with ProcessPoolExecutor(given.jobs, multiprocessing.get_context('spawn')) as pool:
        rates = _rates(pool, given.hours, given.drawn_hours, given.keep)
        tables = f'{rates}\n\n{_delays(pool)}'
    print(tables)
    if given.write:
        twin_page.write(tables, COMMAND)
    return 0


def _rates(pool: ProcessPoolExecutor, hours: float, drawn_hours: float, keep: Path | None) -> str:
    """Return the table of false alarms."""
    lines = ['| clean | valve-hours | promised, per 1000 h | alarms | measured, per 1000 h, 95 % |',
             '|---|---|---|---|---|']
    drawn = list(pool.map(partial(drawn_alarms, drawn_hours), PROMISES[:2]))
    for promised, (alarms, watched_for) in zip(PROMISES, drawn):
        lines.append(twin_page.rate_row('drawn residuals', watched_for, promised, alarms))
    runs = _watched(pool, max(round(3600.0 * hours / DAY), 1), keep)
    for place, promised in enumerate(PROMISES):
        lines.append(twin_page.rate_row(
            'valves, model run', sum(run.hours for run in runs), promised,
            sum(run.alarms[place] for run in runs)))
    return '\n'.join(lines)


def _watched(pool: ProcessPoolExecutor, count: int, keep: Path | None) -> list[Watched]:
    """Return what came of so many valves; those kept in a file are not run again."""
    known = [] if keep is None or not keep.exists() else [
        Watched(**json.loads(line)) for line in keep.read_text(encoding='utf-8').splitlines()]
    with contextlib.ExitStack() as stack:
        file = keep and stack.enter_context(keep.open('a', encoding='utf-8'))
        for run in tqdm(pool.map(watched, range(len(known), count)), total=count - len(known)):
            known.append(run)
            if file:
                file.write(json.dumps(run._asdict()) + '\n')
                file.flush()
    return known[:count]


def _delays(pool: ProcessPoolExecutor) -> str:
    """Return the table of delays, and of shares seen, beside others at the same rate."""
    clean = list(tqdm(pool.map(partial(numbers_of, fault=CLEAN), range(
        10 * APART, 10 * APART + CLEAN_RUNS)), total=CLEAN_RUNS))
    others = rivals(clean)
    table = [f'| effect | {" | ".join(["twin", *others])} |', '|---|' + '---|' * (1 + len(others))]
    for name, values in effects():
        runs = list(pool.map(partial(numbers_of, fault=values), range(APART, APART + FAULTY)))
        seen = [[twin_delay(run, PROMISED) for run in runs],
                *([rival(run) for run in runs] for rival in others.values())]
        table.append(f'| {name} | ' + ' | '.join(map(twin_page.seen, seen)) + ' |')
        print(table[-1], flush=True)
    return '\n'.join(table)


if __name__ == '__main__':
    sys.exit(main())
