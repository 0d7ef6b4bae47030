# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The cells of the matrix, and the records that belong to them."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass

from ..campaigns import PAIRS
from ..cases import Case
from ..effects import (
    CATALOGUED, CHANGES, EFFECTS, LATER_VARIANTS, NAMELESS, SIZES, VARIANTS)

GROUPS: dict[str, tuple[str, ...]] = {
    'catalogued': (*CATALOGUED, *VARIANTS, *LATER_VARIANTS),
    'uncatalogued': tuple(NAMELESS),
    'changes': tuple(CHANGES),
    'pairs': tuple('+'.join(pair) for pair in PAIRS),
    'none': ('none',),
}
GROUPS['all'] = (*GROUPS['catalogued'], *GROUPS['uncatalogued'], 'none')

NO_SIZE = '-'


@dataclass(frozen=True)
class Cell:
    """One run: effects joined by '+' or 'none', their size, a factor on the noise, the draw."""

    effect: str
    size: str
    noise: float
    seed: int
    kind: str = 'mixed'
    spread: str = 'samples'

    @property
    def label(self) -> str:
        """A name for its files, unlike that of any other cell."""
        size = '' if self.size == NO_SIZE else f'_{self.size}'
        return f'{self.effect}{size}_noise{self.noise:g}_{self.kind}_{self.spread}_{self.seed}'

    @property
    def keys(self) -> tuple[str, ...]:
        """The effects, keys of EFFECTS."""
        return () if self.effect == 'none' else tuple(self.effect.split('+'))

    def case(self) -> Case:
        """Return what is put into the records: one valve and signal for all sizes and noises."""
        effects = tuple((key, EFFECTS[key].size(self.size)) for key in self.keys)
        order = ('none', *EFFECTS)
        number = sum(len(order) ** k * order.index(key) for k, key in enumerate(self.keys))
        return Case(self.label, effects, self.kind, 'mixed', self.spread,
                    10000 * self.seed + number, self.noise)


def cells_of(
    effects: Sequence[str], sizes: Sequence[str], noises: Sequence[float], seed: int, clean: int,
    kind: str, spread: str,
) -> list[Cell]:
    """
    Return the cells of these effects (names, pairs 'a+b', groups), plainest first.

    `clean` records of each noise, with seeds from `seed` on, have no effect. ValueError where a
    name, size or number is not known.
    """
    for size in sizes:
        if size not in SIZES:
            raise ValueError(f'no size is called {size!r}; there are {", ".join(SIZES)}')
    for noise in noises:
        if not 0.0 < noise < float('inf'):
            raise ValueError(f'noise must be positive, got {noise:g}')
    if clean < 1:
        raise ValueError(f'there must be at least one clean record, got {clean}')
    names = [name for text in effects for name in GROUPS.get(text, (text,))]
    cells = []
    for noise in noises:
        for size in sorted(sizes, key=SIZES.index, reverse=True):
            for name in dict.fromkeys(names):
                if name != 'none':
                    _check(name)
                    cells.append(Cell(name, size, noise, seed, kind, spread))
        if 'none' in names:
            cells += [Cell('none', NO_SIZE, noise, seed + k, kind, spread) for k in range(clean)]
    return cells


def values_of(cell: Cell) -> dict[str, str | float | int]:
    """Return the cell as plain values."""
    return asdict(cell)


def _check(name: str) -> None:
    for key in name.split('+'):
        if key not in EFFECTS:
            raise ValueError(
                f'no effect is called {key!r}; there are {", ".join((*GROUPS, *EFFECTS))}')
