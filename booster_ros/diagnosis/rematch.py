# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The choice between models that the search could hardly tell apart.

The search fits to a thinned part of the record, and stops early; that blurs scores by more than
what lies between two similar effects. So the close ones meet again:

1. those of as many effects whose score is near that of the choice;
2. those that this record could not tell from the choice by its sensitivities (see indistinct),
   also where no fit has found that yet;
3. all are fitted to every row of the fit and select segments, until that no longer pays;
4. of those that this does not make unlikely beside the best, the plainest is taken.
"""

from booster_ros.diagnosis.indistinct import alike
from booster_ros.diagnosis.search import (
    EVALUATIONS, UNLIKELY, Candidate, Search, plainness, redundant)
from booster_ros.model.actuator import has_dry_friction

NEAR = 1.15
"""Scores, relative to that of the choice, up to which a model is fitted again."""

RIVALS = 3
"""So many of them at the most."""


def rematch(search: Search, chosen: Candidate, tried: list[Candidate]) -> list[Candidate]:
    """
    Return the choice, then its rivals, all fitted to every row; the choice alone if it has none.

    Where the stem sticks and slips the first choice stays: full fits take minutes there, and their
    cost is rough.
    """
    if not chosen.effects or has_dry_friction(chosen.fit.parameters.actuator):
        return [chosen]
    rivals: dict[frozenset[str], Candidate] = {}
    for one in sorted(tried, key=lambda c: c.score):
        same = set(one.effects) == set(chosen.effects) or len(one.effects) != len(chosen.effects)
        if not same and not one.fault and one.score < NEAR * chosen.score:
            rivals.setdefault(frozenset(one.effects), one)
    for one in _indistinct(search, chosen):
        rivals.setdefault(frozenset(one.effects), one)
    if not rivals:
        return [chosen]
    again = [search.on_both(one, 1) for one in (chosen, *list(rivals.values())[:RIVALS])]
    least = min(one.fit.cost for one in again)
    return sorted(again, key=lambda one: plainness(one, one.fit.cost - least))


def _indistinct(search: Search, chosen: Candidate) -> list[Candidate]:
    """Return models with another effect in the place of one that are as good for any noise."""
    problem = search.on(chosen.problem, ('fit', 'select'), search.thinning)
    whole = search.on(chosen.problem, ('fit', 'select'), 1).rows_counted()
    likely = UNLIKELY * problem.rows_counted() / whole
    fit = problem.at(chosen.fit.z)
    found = []
    for effect in chosen.effects:
        rest = tuple(e for e in chosen.effects if e != effect)
        others = tuple(name for name in search.names
                       if name not in chosen.effects and not redundant(name, rest))
        for one in alike(problem, fit, effect, rest, others):
            if one.cost < likely:
                thin = search.on(one.problem, ('fit',), search.thinning)
                found.append(search.rate(
                    (*rest, one.effect), thin, thin.fit(one.start, evaluations=EVALUATIONS)))
    return found
