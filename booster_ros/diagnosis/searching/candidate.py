# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A model with some effects, fitted and scored: which of two is better, which one is plainer."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from booster_ros.diagnosis.fitting.fit import Fit, Problem
from booster_ros.model.catalogue import EFFECTS

Array = np.ndarray

NEAR_NOISE = 1.15
"""Mean square misfit below which no further effect is looked for."""

WORTH_ADDING = 0.05
"""Share by which an effect must lower the score: noise and rounding hide a smaller fall."""

WORTH_EXPLAINING = 0.3
"""Share that an effect must explain, too, of what noise does not explain."""

NEARLY_ALL = 0.1
"""Share of what noise does not explain that an effect may leave if only one segment shows it."""

CLEARED = 0.3
"""Share of what is left above noise that one more effect may leave where little was left."""

FAINTEST_COST, FAINTEST_SCORE, STANDARD_ERRORS = 16.0, 8.0, 2.0
"""
Fall of the cost, fall of the score, and fall of the score in its standard errors, above which an
effect shows though it matters little. In 20 clean records the best effect of the catalogue lowers
the cost by 11 at the most, the score by 5.
"""

FAR_BEYOND_CHANCE = 40.0
"""Fall of the score that is no chance, however few segments it comes from, and so however large
its standard error is."""

TOO_SIMILAR = 0.05
"""Models whose scores differ by less than this share are not told apart by a record."""

UNLIKELY = 9.0
"""Excess of cost above which a model is unlikely beside another fitted to all the same rows."""

NOT_TOLD_APART = 'not told apart from the choice by this record'
"""Reason given for a model that is not the choice, but could as well be."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """
    A model: its effects, its fit, and how it scores on the select segments.

    `confirmed` says that its last effect explains enough of what is seen above the stem, where
    the stem's friction blurs the whole. `lasting` are those of its effects that take away, above
    the stem, what no slip explains. `fault` says why this record does not show its last effect, or
    after a rematch one of its effects. `learnt` says that it was fitted to the select segments as
    well.
    """

    effects: tuple[str, ...]
    problem: Problem
    fit: Fit
    by_segment: Array
    prior: float
    samples: int
    confirmed: bool = False
    lasting: frozenset[str] = frozenset()
    fault: str = ''
    learnt: bool = False

    @property
    def score(self) -> float:
        """Sum of squares on the select segments plus the prior's share."""
        return float(self.by_segment.sum()) + self.prior

    @property
    def misfit(self) -> float:
        """Mean square of the scaled residuals on the select segments: 1 is noise."""
        return float(self.by_segment.sum()) / max(self.samples, 1)

    @property
    def fitted_misfit(self) -> float:
        """Mean square of the scaled residuals where it was fitted, priors included."""
        return self.problem.mean_square(self.fit)

    def but(self, name: str) -> tuple[str, ...]:
        """Return its effects without this one."""
        return tuple(effect for effect in self.effects if effect != name)


def gain(worse: Candidate, better: Candidate) -> tuple[float, float]:
    """
    Return by how much the score falls, and the standard error of that fall, paired by segment.

    A model whose run did not come to the end has an infinite score, and a standard error of 0.
    """
    if not (np.isfinite(worse.score) and np.isfinite(better.score)):
        return (0.0 if worse.score == better.score else worse.score - better.score), 0.0
    difference = worse.by_segment - better.by_segment
    error = float(np.std(difference, ddof=1) * np.sqrt(len(difference))) if len(
        difference) > 1 else 0.0
    return worse.score - better.score, error


def explains(fit: Fit, before: Fit, rows: int) -> bool:
    """
    Tell whether `fit` explains a share that matters of what the fit `before` leaves.

    It has to explain more than WORTH_ADDING of the cost, and more than WORTH_EXPLAINING of what is
    above noise. `rows` is how many values of all channels both are fitted to, and so what noise
    alone costs.
    """
    fall = before.cost - fit.cost
    return fall > WORTH_ADDING * before.cost and fall > WORTH_EXPLAINING * (before.cost - rows)


def clearly_better(better: Candidate, worse: Candidate) -> bool:
    """
    Tell whether the score falls by more than one standard error and by a share that matters.

    Or whether `better` has a lasting effect that `worse` lacks. Such an effect shows where slips
    do not decide; where a stem sticks, slips are what scores are made of.
    """
    if better.lasting.difference(worse.effects):
        return True
    if not np.isfinite(worse.score):  # its run was lost, and any that was not is better
        return bool(np.isfinite(better.score))
    fall, error = gain(worse, better)
    excess = max(worse.score - worse.samples, 0.0)
    enough = better.confirmed or fall > WORTH_EXPLAINING * excess
    return enough and fall > WORTH_ADDING * worse.score and (
        fall > error or _seen_twice(better, worse))


def clears(better: Candidate, worse: Candidate) -> bool:
    """Tell whether `worse` leaves more than noise, and `better` hardly anything of that."""
    return worse.misfit > 1.0 and better.misfit - 1.0 < CLEARED * (worse.misfit - 1.0)


def shows_faintly(better: Candidate, worse: Candidate) -> bool:
    """
    Tell whether score and cost fall beyond doubt, even by a share too small to matter elsewhere.

    For models without a fault that were fitted to every row. The share that the effect explains of
    what noise does not is not asked: the level of the noise is known to some percent only.
    """
    fall, error = gain(worse, better)
    return worse.fit.cost - better.fit.cost > FAINTEST_COST and fall > max(
        FAINTEST_SCORE, min(STANDARD_ERRORS * error, FAR_BEYOND_CHANCE))


def _seen_twice(better: Candidate, worse: Candidate) -> bool:
    """
    Tell whether fit and select segments show the same fall, and no select segment the reverse.

    A fall in one select segment only (the stem reaches its seat there, say) has a standard error
    as large as itself. It counts if the better model takes away nearly all that noise does not
    explain, in the select segments and in the fit segments as well.
    """
    falls = worse.by_segment - better.by_segment
    return (better.fitted_misfit - 1.0 < NEARLY_ALL * (worse.fitted_misfit - 1.0)
            and better.misfit - 1.0 < NEARLY_ALL * (worse.misfit - 1.0)
            and float(falls.min()) > -NEARLY_ALL * float(falls.max()))


def preferred_first(candidates: list[Candidate]) -> list[Candidate]:
    """
    Return the candidates by score; of those not told apart from the best, the plainest first.

    Those with a fault come last.
    """
    ranked = sorted(candidates, key=lambda c: (bool(c.fault), c.score))
    if not ranked:
        return ranked
    ties = [c for c in ranked if c.fault == ranked[0].fault and not told_apart(c, ranked[0])]
    ties.sort(key=lambda c: plainness(c, 0.0))
    return ties + [c for c in ranked if c not in ties]


def best_of_each(candidates: Iterable[Candidate]) -> dict[frozenset[str], Candidate]:
    """Return the best model of each set of effects, by that set; the best score comes first."""
    best: dict[frozenset[str], Candidate] = {}
    for one in sorted(candidates, key=lambda c: c.score):
        best.setdefault(frozenset(one.effects), one)
    return best


def plainness(candidate: Candidate, behind: float) -> tuple[bool, int, int]:
    """
    Return the key by which models that a record does not tell apart are ranked, plainest first.

    `behind` is how much more the model costs than the best; models that this makes unlikely come
    last. Among the others, the fewest sizes come first; then the order of the catalogue counts,
    which lists common causes first.
    """
    order = list(EFFECTS)
    return (behind > UNLIKELY, _sizes_shown(candidate),
            sum(order.index(e) for e in candidate.effects))


def _sizes_shown(candidate: Candidate) -> int:
    """Return how many sizes of effects move the record by more than its noise."""
    return sum(not free.knob.shape and not np.isfinite(free.sigma) and bool(seen)
               for free, seen in zip(candidate.problem.freedoms, candidate.fit.seen))


def told_apart(worse: Candidate, better: Candidate) -> bool:
    """Tell whether the record prefers `better`, by a standard error and a share that matters."""
    fall, error = gain(worse, better)
    return fall > TOO_SIMILAR * better.score and fall > error


def why_dropped(candidate: Candidate, chosen: Candidate) -> str:
    """Return why another model is not the chosen one; its own fault comes before any comparison."""
    if candidate.fault:
        return candidate.fault
    lasting = chosen.lasting.difference(candidate.effects)
    if lasting:
        return f'without {" and ".join(sorted(lasting))} more is left of what no slip explains'
    if set(chosen.effects) < set(candidate.effects):
        return 'the added effect does not lower the held-back error enough'
    if told_apart(candidate, chosen):
        ratio = candidate.score / max(chosen.score, 1e-12)
        return f'{ratio:.3g} times the squared error of the choice'
    return NOT_TOLD_APART
