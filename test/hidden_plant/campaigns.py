# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Sets of cases: every catalogued effect, every other, and a mixture as real plants bring it."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from .cases import Case, visibility
from .currents import KINDS
from .effects import CATALOGUED, EFFECTS, SIZES, UNCATALOGUED
from .sensors import POSITION_NOISE, PRESSURE_NOISE

PAIRS = (
    ('chamber_leak', 'stem_friction'),
    ('tubing_restriction', 'ep_hysteresis'),
    ('booster_dead_band', 'position_backlash'),
    ('supply_droop', 'stem_friction'),
    ('ep_drift', 'stem_friction_coulomb'),
    ('supply_ripple', 'chamber_leak'),
    ('tubing_restriction', 'stem_friction'),
    ('exhaust_asymmetry', 'position_sensor_lag'),
    ('ep_hysteresis', 'spring_nonlinearity'),
)


def single(text: str, seed: int, kind: str, spread: str) -> Case:
    """Return the case that "none", "EFFECT", "EFFECT:SIZE" or several joined by "+" describe.

    SIZE is small, medium, large or a number in the effect's unit. Raises ValueError when the text
    names no effect or no size.
    """
    effects = () if text == 'none' else tuple(_sized(part) for part in text.split('+'))
    return Case(text.replace(':', '_'), effects, kind, 'mixed', spread, seed)


def _sized(text: str) -> tuple[str, float]:
    key, _, size = text.partition(':')
    if key not in EFFECTS:
        raise ValueError(f'no effect is called {key!r}; there are none, {", ".join(EFFECTS)}')
    if size in ('', *SIZES):
        return key, EFFECTS[key].size(size or 'medium')
    try:
        return key, float(size)
    except ValueError:
        raise ValueError(
            f'size {size!r} of {key} is neither a number nor {", ".join(SIZES)}'
        ) from None


def every(effects: Iterable[str], size: str, seed: int, kind: str, spread: str) -> list[Case]:
    """Return one case for each effect, all at one size, each with a plant of its own."""
    return [
        Case(key, ((key, EFFECTS[key].size(size)),), kind, 'mixed', spread, seed + number)
        for number, key in enumerate(effects)
    ]


def unseen(seed: int, spread: str) -> list[Case]:
    """Return 31 cases: 15 catalogued effects, 6 others, 5 pairs and 5 clean plants, shuffled."""
    return drawn(seed, spread, catalogued=15, uncatalogued=6, pairs=5, clean=5)


def drawn(
    seed: int, spread: str, *, catalogued: int, uncatalogued: int, pairs: int, clean: int
) -> list[Case]:
    """Return so many cases of each kind, no effect or pair twice, shuffled."""
    generator = np.random.default_rng([seed, 99])
    contents = [
        (str(key),) for key in generator.choice(list(CATALOGUED), catalogued, replace=False)]
    contents += [
        (str(key),) for key in generator.choice(list(UNCATALOGUED), uncatalogued, replace=False)]
    contents += [PAIRS[i] for i in generator.choice(len(PAIRS), pairs, replace=False)]
    contents += [()] * clean
    order = generator.permutation(len(contents))
    return list(_drawn([contents[i] for i in order], generator, seed, spread))


def _drawn(
    contents: list[tuple[str, ...]], generator: np.random.Generator, seed: int, spread: str
) -> Iterator[Case]:
    kinds, often_mixed = list(KINDS), [0.4, 0.25, 0.15, 0.1, 0.1]
    for number, keys in enumerate(contents, start=1):
        label = '+'.join(keys) or 'none'
        case = Case(
            name=f'{number:02d}_{label}',
            effects=tuple((key, _drawn_size(key, generator, paired=len(keys) > 1)) for key in keys),
            kind=str(generator.choice(kinds, p=often_mixed)),
            validation_kind=str(generator.choice(kinds, p=often_mixed)),
            spread=spread,
            seed=1000 * seed + number,
        )
        yield _shown(case)


def _shown(case: Case) -> Case:
    """Return the case with its effects doubled until the record shows them at twice the noise."""
    while case.effects:
        pressure, position = visibility(case)
        if max(pressure / PRESSURE_NOISE, position / POSITION_NOISE) >= 2.0:
            break
        case = replace(case, effects=tuple((key, 2.0 * size) for key, size in case.effects))
    return case


def _drawn_size(key: str, generator: np.random.Generator, paired: bool) -> float:
    effect = EFFECTS[key]
    chances = [0.0, 0.4, 0.6] if paired else [0.15, 0.35, 0.5]
    size = effect.size(str(generator.choice(SIZES, p=chances))) * generator.uniform(0.8, 1.2)
    return -size if effect.signed and generator.random() < 0.5 else size
