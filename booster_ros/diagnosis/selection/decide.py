# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The decisions of a selection, each a row with its reason.

| question | answer yes where | why |
|---|---|---|
| does the record call for m' beside m? | evidence, and gain of blocks (`why_not`) | below |
| is what is left noise? | reduced chi-square below NOISE | the level of noise is known so well |
| does the first of two models stand for both? | log Z within TIE | odds of 20 to 1 |
| is m' confirmed, likely, or a candidate? | `standing` | what an engineer may rely on |

m' is accepted in the place of m where, tempered by what the best candidate leaves,

    log Z(m') - log Z(m)  >  log(number of candidates) + log 20 + luck

so that of twenty records in which nothing is missing one gets something added at the most, whatever
the number of candidates (Bonferroni). Luck is what chance changes of the likelihood of m', as that
of a loop which ends in its dead zone on one side or the other. And what it explains must not rest
on a single block of the record (a step, a ramp): without the block that gains most, the others
still gain TIE. A disturbance happens once; an effect comes back with what excites it.
"""

from dataclasses import dataclass
from math import log, log1p

import numpy as np

from booster_ros.diagnosis.estimation.uncertainty import LEVEL
from booster_ros.diagnosis.selection.score import LARGE, Score

TIE = -log1p(-LEVEL)
"""Difference of log evidence, or likelihood, up to which two models are not told apart: log 20, as
odds of 19 to 1 are the usual 95 %."""

NOISE = 1.15
"""Reduced chi-square up to which what is left may be noise: its level is estimated to some 5 %,
which is 10 % in its square."""

NEARLY_ALL = 0.97
"""Share of what is missing that an effect explains if its law may be merely an idealised one: no
smooth term takes its place, and none is looked for."""

ISOLATED, SMOOTHED = 0.02, 3.5
"""Share of the whole model's excess over noise, and reduced chi-square, up to which the upstream
subsystem lacks nothing: what is missing there leaves 0.4 or more of the excess, and smoothing the
measured stem may leave the latter by itself."""

MOST = 0.8
"""Share of what was missing: a model that leaves LARGE and explains less than this is a candidate,
not a finding."""


@dataclass(frozen=True)
class Comparison:
    """
    What a record says of one model against another.

    The differences of log evidence and of log posterior density, + where the first is better, the
    standard error of the latter over blocks, the latter without the block that gains most, c, and
    what chance changes of the former.
    """

    log_evidence: float
    gain: float
    gain_standard_error: float
    without_best_block: float
    dispersion: float
    luck: float = 0.0

    def figures(self) -> dict[str, float]:
        """Return what reports say of it."""
        return {name: figure for name, figure in vars(self).items()
                if name != 'without_best_block'}


@dataclass(frozen=True)
class TraceStep:
    """
    A step of the selection: a model against another, what was found, and what came of it.

    `reduced_chi2` is what the first model leaves, in squares of the noise.
    """

    effects: tuple[str, ...]
    against: tuple[str, ...]
    reduced_chi2: float
    found: Comparison
    outcome: str


def compare(one: Score, other: Score, c: float) -> Comparison:
    """Return what the record says of `one` against `other`, both scored on the same blocks."""
    gains = 0.5 * (other.costs - one.costs) / c
    error = float(np.std(gains, ddof=1) * np.sqrt(len(gains))) if len(gains) > 1 else 0.0
    gain = float(gains.sum()) + 0.5 * (other.prior - one.prior)
    return Comparison(
        one.log_evidence(c) - other.log_evidence(c), gain, error, gain - float(gains.max()), c,
        one.luck / c)


def why_not(found: Comparison, candidates: int) -> str:
    """Return why the first model, one of so many candidates, is not accepted, '' where it is."""
    if found.log_evidence > TIE and not found.without_best_block > TIE:
        return 'its gain rests on a single block of the record'
    enough = found.log_evidence > log(max(candidates, 1)) + TIE + found.luck
    return '' if enough else 'the evidence for it is not enough'


def standing(explained: float, reduced_chi2: float, at_bound: bool, stands_in_test: bool,
             beside: bool = False) -> str:
    """
    Return what may be relied on: 'confirmed', 'likely' or 'candidate'.

    Candidate: it stands at a bound of its range, or it leaves more than three times the noise and
    explains less than four fifths of what was missing. Likely: it explains that much, but the test
    set is not met better with it, or much is left, or `beside` others it explains no more than the
    idealised law of one of them may leave. Confirmed: none of these.
    """
    if at_bound or (reduced_chi2 > LARGE and explained < MOST):
        return 'candidate'
    little = beside and explained < 1.0 - NEARLY_ALL
    return 'likely' if little or reduced_chi2 > LARGE or not stands_in_test else 'confirmed'
