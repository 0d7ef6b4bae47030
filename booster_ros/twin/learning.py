# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
How long blocks have to be so that one says nothing of the next, told by the valve's first hours.

A healthy valve's numbers hang together over the time of the slowest part of its noise. Blocks are
joined, two by two, until what is left of that, beyond a slow course that the tolerance allows, is
no more than chance.
"""

import numpy as np

from .summaries import KINDS, Summary, joined

LONGEST_JOIN = 8
"""Blocks that are joined at the most; residuals that hang together for longer cannot be promised
anything of."""

SLOW = 9
"""Blocks over which the course is averaged that counts as slow, and is the tolerance's business."""

HANGS = 0.2
"""Correlation of neighbouring blocks up to which they are taken for exchangeable."""


def correlation(numbers: np.ndarray) -> float:
    """Return the correlation of neighbours, slow courses taken off; 0 for fewer than 24 numbers."""
    if len(numbers) < 24:
        return 0.0
    weights = np.ones(SLOW)
    slow = np.convolve(numbers, weights, 'same') / np.convolve(
        np.ones(len(numbers)), weights, 'same')
    fast = numbers - slow
    power = float(np.sum(fast * fast))
    if power <= 0.0:
        return 0.0
    # what the average takes off white noise makes neighbours differ: by 1 / SLOW
    return float(np.sum(fast[1:] * fast[:-1])) / power + 1.0 / SLOW


def join_of(blocks: list[Summary]) -> int | None:
    """Return how many blocks to join so that neighbours do not hang together; None: too many."""
    join = 1
    while join <= LONGEST_JOIN:
        made = in_groups(blocks, join)
        if len(made) < 24:
            return None
        limit = max(HANGS, 2.0 / np.sqrt(len(made)))
        if all(correlation(_numbers(made, name)) <= limit for name in _names(made)):
            return join
        join *= 2
    return None


def in_groups(blocks: list[Summary], join: int) -> list[Summary]:
    """Return blocks joined in groups of `join`; an incomplete last group is left out."""
    return [joined(blocks[k:k + join]) for k in range(0, len(blocks) - join + 1, join)]


def _names(blocks: list[Summary]) -> list[tuple[str, str]]:
    return [name for name in dict.fromkeys(name for one in blocks for name in one.numbers)
            if name[1] in KINDS]


def _numbers(blocks: list[Summary], name: tuple[str, str]) -> np.ndarray:
    """Return a number over blocks, the mean of each cell taken off: cells are judged apart."""
    kept = [one for one in blocks if name in one.numbers]
    cells = [one.cells[name[0]] for one in kept]
    means = {cell: np.mean([one.numbers[name] for one in kept if one.cells[name[0]] == cell])
             for cell in set(cells)}
    return np.array([one.numbers[name] - means[cell] for one, cell in zip(kept, cells)])
