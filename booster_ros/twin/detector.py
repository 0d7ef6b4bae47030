# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
A sequential alarm whose rate of false alarms is bounded at any time, without a model of the noise.

One detector watches one number per block, x_t (a summary of residuals). What it takes for granted
of a healthy valve:

    x_t = m_t + n_t,  |m_t - centre| <= tolerance,  n_t exchangeable within each operating cell.

m_t is any slow course within the declared tolerance: day and night, error of the model, error of
the centre. Nothing is said of the law of n_t: heavy tails and any colour within a block will do.

1. Conformal p-value (V. Vovk, A. Gammerman, G. Shafer, Algorithmic Learning in a Random World,
   2005). If scores s_1 ... s_t are exchangeable and u_t is uniform,

       p_t = (#{i < t: s_i > s_t} + u_t (1 + #{i < t: s_i = s_t})) / t

   are independent and uniform on (0, 1), exactly, for any t. Scores of a cell are compared within
   that cell alone (Mondrian), so a change of the operating point asks a fresh question.
2. Tolerance. Not |n_t| is seen but x_t. A past block scores |x_i - centre| + tolerance, which is
   not below |n_i|, the present one max(|x_t - centre| - tolerance, 0) <= |n_t|. So p_t is not below
   the one of the |n|, point by point, and what follows holds for every course within tolerance.
3. e-value. f(p) = integral over k in (0, 1) of k p^(k-1) = (1 - p + p ln p) / (p ln² p) falls in p
   and has the integral 1, so e_t = f(p_t) has an expectation <= 1 given the past.
4. e-detector of Shiryaev and Roberts (J. Shin, A. Ramdas, A. Rinaldo, E-detectors, New England J.
   Statistics in Data Science 2 (2024) 229): M_t = (M_t-1 + 1) e_t, and 0 after an alarm, which is
   given where M_t >= c. As E[M_t | past] <= M_t-1 + 1, M_t - t + c N_t is a supermartingale, N_t
   being the alarms so far, and so

       E[N_t] <= t / c        for every t: at most one false alarm in c blocks, on average.

5. Bets on a beginning. What comes after a change is among those that the next block is compared
   with, so that p rises again: of a cell with m blocks, j of which have come since the change, p_t
   is about uniform on (0, q), q = (j + 1) / (m + 1). Each of the last `BEGINNINGS` blocks counts as
   such a beginning s, and bets half of what it has on f and half on just that,

       E_s,t = E_s,t-1 (f(p_t) / 2 + [p_t <= q_s,t] / (2 q_s,t)),

   which has an expectation <= E_s,t-1 given the past, as q is known before p. Their sum is a
   detector as well: a new beginning adds 1, one that is too old to count takes something away. M_t
   is the mean of this and of the detector in 4, which has no end to its memory.

With J detectors, each with c = J / (rate per block), the rate of all together is kept (sums of
expectations; nothing is asked of how they hang together).

What is not covered: blocks that hang together beyond the tolerance (`learning` lengthens the
blocks until they do not, or says that it cannot), and a change that comes with the first blocks of
a cell, which are then what it takes for healthy.
"""

import bisect
from collections.abc import Mapping
import math
from typing import Any

import numpy as np

CENTRING = 8
"""Blocks of a cell that tell its centre, and nothing else."""

FEWEST = 30
"""Blocks of a cell to compare with below which the detector is as good as blind there."""

BEGINNINGS = 100
"""Blocks back to which a change is taken to have begun by those who bet on its beginning."""

STAKES = np.array([0.5, 0.9])
"""Shares that are bet on a beginning: much of it where few blocks were learnt, as then each tells
little; less of it where a change does not show in every block."""

MOST = 20_000
"""Scores kept of a cell; then each new one takes the place of one at random, so that those kept are
a random sample of all."""


def evidence(p: float) -> float:
    """
    Return the e-value of a p-value in (0, 1]: the mixture of all bets k p^(k-1), 0 < k < 1.

    >>> round(evidence(0.001), 1), round(evidence(1.0), 1)
    (20.8, 0.5)
    """
    if p > 1.0 - 1e-6:
        return 0.5
    p = max(p, 1e-12)
    log = math.log(p)
    return (1.0 - p + p * log) / (p * log * log)


class Cell:
    """The scores of one operating cell, and the centre that they are counted from."""

    def __init__(self) -> None:
        self._first: list[float] = []
        self._scores: list[float] = []
        self._seen = 0
        self.centre = math.nan

    @property
    def size(self) -> int:
        """How many blocks there are to compare with."""
        return len(self._scores)

    @property
    def seen(self) -> int:
        """How many there have been, of which so many are kept."""
        return self._seen

    def as_values(self) -> dict[str, Any]:
        """Return all that is known as plain values, for `restored`."""
        return {'first': self._first, 'scores': self._scores, 'seen': self._seen,
                'centre': self.centre}

    @classmethod
    def restored(cls, values: Mapping[str, Any]) -> 'Cell':
        """Return the cell that `as_values` told of."""
        cell = cls()
        cell._first = [float(x) for x in values['first']]
        cell._scores = sorted(float(x) for x in values['scores'])
        cell._seen, cell.centre = int(values['seen']), float(values['centre'])
        return cell

    def p_value(self, x: float, tolerance: float, random: np.random.Generator) -> float | None:
        """Return the p-value of a block, and take it in; None while the centre is sought."""
        if len(self._first) < CENTRING:
            self._first.append(x)
            if len(self._first) == CENTRING:
                self.centre = float(np.median(self._first))
            return None
        distance = abs(x - self.centre)
        score = max(distance - tolerance, 0.0)
        # what is kept is the distance: the tolerance is added to all of them alike
        above = self.size - bisect.bisect_right(self._scores, score - tolerance)
        ties = self.size - bisect.bisect_left(self._scores, score - tolerance) - above
        p = (above + random.random() * (1 + ties)) / (self.size + 1)
        self._keep(distance, random)
        return p

    def _keep(self, distance: float, random: np.random.Generator) -> None:
        self._seen += 1
        if self.size >= MOST:
            if random.random() >= MOST / self._seen:
                return
            self._scores.pop(int(random.integers(self.size)))
        bisect.insort(self._scores, distance)


class Beginnings:
    """Bets on that a change began with one of the last blocks; a sum of e-processes."""

    def __init__(self) -> None:
        self._cells = np.empty((0, 2), dtype=int)
        self._worth = np.empty((0, len(STAKES)))
        """E of each, by stake, the oldest first: it lives for so few blocks that it neither over-
        nor underflows."""

    def as_values(self) -> list[Any]:
        """Return all that is known as plain values, for `restored`."""
        return [[*cell, *worth]
                for cell, worth in zip(self._cells.tolist(), self._worth.tolist())]

    @classmethod
    def restored(cls, values: list[Any]) -> 'Beginnings':
        """Return those that `as_values` told of."""
        made = cls()
        for third, activity, *worth in values:
            made._add((int(third), int(activity)), [float(one) for one in worth])
        return made

    def _add(self, cell: tuple[int, int], worth: list[float]) -> None:
        self._cells = np.concatenate([self._cells[1 - BEGINNINGS:], [cell]])
        self._worth = np.concatenate([self._worth[1 - BEGINNINGS:], [worth]])

    def note(self, cell: tuple[int, int], seen: int, p: float, fixed: float) -> None:
        """Take a block's p-value, `seen` blocks of its cell before it; `fixed` is f(p)."""
        self._add(cell, [1.0] * len(STAKES))
        same = (self._cells == cell).all(axis=1)
        q = np.minimum(np.cumsum(same[::-1])[::-1] / (seen + 1.0), 1.0)
        self._worth *= np.outer((p <= q) / q, STAKES) + fixed * (1.0 - STAKES)

    @property
    def sum(self) -> float:
        """The sum of all, each the mean over its stakes."""
        return float(self._worth.sum()) / len(STAKES)


class Detector:
    """Watches one number; `threshold` is c above, a mean number of blocks from alarm to alarm."""

    def __init__(self, tolerance: float, threshold: float, seed: int = 0) -> None:
        self.tolerance, self.threshold = tolerance, threshold
        self._random = np.random.default_rng(seed)
        self._cells: dict[tuple[int, int], Cell] = {}
        self._log = -math.inf
        self._beginnings = Beginnings()
        self._excursion = 0.0
        self._since = math.nan
        self._moved: list[float] = []
        self.shift = 0.0
        """Mean of the number less its centre since `since`."""

    def as_values(self) -> dict[str, Any]:
        """Return all that is known as plain values, for `restore`."""
        return {
            'cells': [[*place, cell.as_values()] for place, cell in self._cells.items()],
            'log': self._log, 'beginnings': self._beginnings.as_values(),
            'excursion': self._excursion, 'since': self._since, 'moved': self._moved,
            'random': self._random.bit_generator.state}

    def restore(self, values: Mapping[str, Any]) -> None:
        """Go on from where `as_values` was asked: with the same chance to come as well."""
        self._cells = {(int(third), int(activity)): Cell.restored(cell)
                       for third, activity, cell in values['cells']}
        self._log, self._excursion = float(values['log']), float(values['excursion'])
        self._beginnings = Beginnings.restored(values['beginnings'])
        self._since = float(values['since'])
        self._moved = [float(x) for x in values['moved']]
        self._random.bit_generator.state = values['random']

    @property
    def log_evidence(self) -> float:
        """Natural logarithm of M: an alarm where it reaches that of the threshold."""
        bets = self._beginnings.sum
        return float(np.logaddexp(self._log, math.log(bets) if bets else -math.inf)) - math.log(2.0)

    @property
    def since(self) -> float:
        """Begin, s, of the block from which on the evidence has grown (E. S. Page's maximum)."""
        return self._since

    def compared_with(self, cell: tuple[int, int]) -> int:
        """Return how many blocks of a cell there are to compare with."""
        return self._cells[cell].size if cell in self._cells else 0

    def note(self, begin: float, cell: tuple[int, int], x: float) -> bool:
        """Take the number of a block that began at `begin` s; tell whether this is an alarm."""
        there = self._cells.setdefault(cell, Cell())
        seen = there.seen
        p = there.p_value(x, self.tolerance, self._random)
        if p is None:
            return False
        bet = evidence(p)
        e = math.log(bet)
        self._log = (math.log1p(math.exp(self._log)) if self._log < 30.0 else self._log) + e
        self._beginnings.note(cell, seen, p, bet)
        if self._excursion <= 0.0:
            self._since, self._excursion, self._moved = begin, 0.0, []
        self._excursion += e
        self._moved = [*self._moved[-200:], x - there.centre]
        if self.log_evidence < math.log(self.threshold):
            return False
        self.shift = float(np.mean(self._moved))
        self._log, self._excursion = -math.inf, 0.0
        self._beginnings = Beginnings()
        return True
