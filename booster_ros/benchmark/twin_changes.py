# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Changes of a valve by the hundred, over topics: what the twin says of them, and what it adopts.

    python -m booster_ros.benchmark.twin_changes FOLDER [--changes N] [--jobs N] [--write]

A drawn valve, near the model that the twin has but not equal, is moved and learnt. Then, for each
fault and once without one, the twin is restarted with what it had learnt, and the valve changes.
What raises an alarm is diagnosed, and adopted where it is confirmed. Where no alarm comes,
`~/diagnose` is called. FOLDER keeps what came of each, so that an interrupted run goes on, and the
reports.
"""

import argparse
from concurrent.futures import ProcessPoolExecutor
import json
import multiprocessing
from pathlib import Path
import sys

import numpy as np
from tqdm import tqdm

from . import twin_page
from .twin_change import NONE, Came, changed, learn
from .twin_changes_table import table

FAULTS = (
    NONE, 'stem_friction', 'stem_damping', 'spring_rate_change', 'bench_set_shift', 'chamber_leak',
    'exhaust_seat_leak', 'ep_gain_loss', 'dead_time', 'position_backlash', 'pressure_sensor_bias')
"""What a valve of this age may get; each takes its turn."""

SIZES = 2
"""Sizes of each fault that a valve gets."""

COMMAND = 'python -m booster_ros.benchmark.twin_changes FOLDER --write'

KEPT = 'changes.jsonl'


def main(arguments: list[str] | None = None) -> int:
    """Run what is missing, and print the table."""
    parser = argparse.ArgumentParser(prog='twin_changes', description='Change valves of twins.')
    parser.add_argument('folder', type=Path)
    parser.add_argument('--changes', type=int, default=200)
    parser.add_argument('--jobs', type=int, default=2)
    parser.add_argument('--write', action='store_true', help='put the table into docs/twin.md')
    given = parser.parse_args(arguments)
    given.folder.mkdir(parents=True, exist_ok=True)
    kept = given.folder / KEPT
    known = {one.seed: one for one in _read(kept)}
    missing = [seed for seed in range(given.changes) if seed not in known]
    with (ProcessPoolExecutor(given.jobs, multiprocessing.get_context('spawn')) as pool,
          kept.open('a', encoding='utf-8') as file):
        numbers = [seed // (SIZES * len(FAULTS)) for seed in missing]
        memories = {number: given.folder / f'learnt_{number:02}.json' for number in numbers}
        new = [number for number, memory in memories.items() if not memory.exists()]
        list(tqdm(pool.map(learn, new, [memories[number] for number in new]), total=len(new)))
        all_came = pool.map(
            changed, missing, numbers, [memories[number] for number in numbers],
            [FAULTS[seed % len(FAULTS)] for seed in missing],
            [float(2.0 ** np.random.default_rng(seed).uniform(0.0, 2.0)) for seed in missing],
            [given.folder / f'{seed:03}' for seed in missing])
        for came in tqdm(all_came, total=len(missing)):
            known[came.seed] = came
            file.write(json.dumps(came._asdict()) + '\n')
            file.flush()
    told = table([known[seed] for seed in range(given.changes)])
    print(told)
    if given.write:
        twin_page.write(told, COMMAND)
    return 0


def _read(path: Path) -> list[Came]:
    if not path.exists():
        return []
    return [Came(**json.loads(line)) for line in path.read_text(encoding='utf-8').splitlines()]


if __name__ == '__main__':
    sys.exit(main())
