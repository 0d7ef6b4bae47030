# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
False alarms of the twin against the promised rate, and how soon faults are seen beside others.

    python -m booster_ros.benchmark.twin_alarms [--hours H] [--drawn-hours H] [--write]

1. Drawn residuals: laws, colours, drifts and set-point noise drawn valve by valve, without a model.
2. Valves: parameters, inputs, noise and drifts drawn, the model run as valve and as twin.
3. The numbers of the same valves with faults are given to CUSUM, Page-Hinkley and ADWIN (of river,
   where it is installed), whose thresholds are set so that they give as many false alarms on the
   clean ones as the twin promises.
"""

import argparse
import sys

from tqdm import tqdm

from . import twin_page
from .twin_rivals import PROMISED, rivals
from .twin_valves import CLEAN, drawn_alarms, effects, numbers_of, twin_delay, twin_false_alarms

FAULTY = 12
"""Valves drawn for each effect and size."""


def main(arguments: list[str] | None = None) -> int:
    """Run what was asked for and print the tables."""
    parser = argparse.ArgumentParser(prog='twin_alarms', description='Count alarms of the twin.')
    parser.add_argument('--hours', type=float, default=100.0, help='valve-hours with the model')
    parser.add_argument('--drawn-hours', type=float, default=10_000.0,
                        help='valve-hours of drawn residuals')
    parser.add_argument('--write', action='store_true', help='put the tables into docs/twin.md')
    given = parser.parse_args(arguments)
    lines = ['| clean | valve-hours | promised, per 1000 h | alarms | measured, per 1000 h, 95 % |',
             '|---|---|---|---|---|']
    for per_thousand in (1000.0 / 8766.0, 10.0):
        alarms, hours = drawn_alarms(given.drawn_hours, per_thousand)
        lines.append(twin_page.rate_row('drawn residuals', hours, per_thousand, alarms))
        print(lines[-1], flush=True)
    clean = [numbers_of(seed, CLEAN) for seed in tqdm(range(max(int(given.hours / 2.0), 2)))]
    for per_thousand in (1000.0 / 8766.0, 10.0, PROMISED):
        alarms, hours = twin_false_alarms(clean, per_thousand)
        lines.append(twin_page.rate_row('valves, model run', hours, per_thousand, alarms))
        print(lines[-1], flush=True)
    others = rivals(clean)
    table = [f'| effect | {" | ".join(["twin", *others])} |', '|---|' + '---|' * (1 + len(others))]
    for name, values in effects():
        runs = [numbers_of(10_000 + seed, values) for seed in range(FAULTY)]
        seen = [[twin_delay(run, PROMISED) for run in runs],
                *([rival(run) for run in runs] for rival in others.values())]
        table.append(f'| {name} | ' + ' | '.join(map(twin_page.seen, seen)) + ' |')
        print(table[-1], flush=True)
    tables = '\n'.join(lines) + '\n\n' + '\n'.join(table)
    print(tables)
    if given.write:
        twin_page.write(tables)
    return 0


if __name__ == '__main__':
    sys.exit(main())
