# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Sets that stay the same from state to state: golden, quick, and the ladder of noise."""

from dataclasses import replace
import json
from pathlib import Path
import shutil

from .campaigns import drawn, single, unseen
from .cases import Case
from .sensors import PRESSURE_NOISE

SAMPLES = Path(__file__).resolve().parents[1] / 'samples'

GOLDEN_SEED = 40
QUICK_SEEDS = (4507, 6101)
QUICK = 60

LADDER_NOISES = (0.0, 5.0, 50.0, 150.0, 450.0)  # Pa
LADDER_SEEDS = (1, 2, 3)
LADDER = (
    'stem_friction_coulomb:250',
    'stem_friction:80',
    'stem_friction:350',
    'stem_friction_stick_slip:200',
    'stem_friction_yielding:350',
    'chamber_leak:3e-8',
    'booster_dead_band:0.01',
)


def golden() -> list[Case]:
    """Return 35 cases: 20 catalogued effects, 6 others, 5 pairs, 4 clean; SAMPLES make them 40."""
    return drawn(GOLDEN_SEED, 'samples', catalogued=20, uncatalogued=6, pairs=5, clean=4)


def quick() -> list[Case]:
    """Return 60 cases of two drawn sets: two effects that both have are left out of the second."""
    first, second = (
        [replace(case, name=f'{seed}_{case.name}') for case in unseen(seed, 'samples')]
        for seed in QUICK_SEEDS)
    contents = [[key for key, _ in case.effects] for case in first if case.effects]
    twice = [case for case in second if [key for key, _ in case.effects] in contents]
    left_out = twice[:len(first) + len(second) - QUICK]
    return [*first, *(case for case in second if case not in left_out)]


def ladder() -> list[Case]:
    """
    Return one friction, leak or dead band after the other, at each noise and with each seed.

    A seed has the same valve and currents at every noise; position noise and the resolution of the
    recorder go with the noise of pressure, down to none.
    """
    return [
        replace(single(text, 100 * number + seed, 'mixed', 'samples'),
                name=f'{text.replace(":", "_")}_{seed}_{noise:03.0f}Pa',
                noise=noise / PRESSURE_NOISE, resolution=noise / PRESSURE_NOISE)
        for number, text in enumerate(LADDER, start=1)
        for seed in LADDER_SEEDS
        for noise in LADDER_NOISES
    ]


def add_samples(folder: Path) -> list[str]:
    """Copy the sample records into a written set; return the names of their cases."""
    added = json.loads((SAMPLES / 'key.json').read_text(encoding='utf-8'))
    for name in added:
        for path in SAMPLES.glob(f'{name}[._]*'):
            shutil.copy(path, folder)
    path = folder / 'key.json'
    key = json.loads(path.read_text(encoding='utf-8')) if path.exists() else {}
    path.write_text(json.dumps({**key, **added}, indent=1) + '\n', encoding='utf-8')
    return sorted(added)
