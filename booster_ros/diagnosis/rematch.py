# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The choice between models that the search could hardly tell apart.

The search fits to a thinned part of the record, and stops early; that blurs scores by more than
what lies between two similar effects. So the close ones meet again:

1. the choice, and those of as many effects whose score is near its own, are fitted to every row of
   the fit and select segments, until that no longer pays;
2. of those that this does not make unlikely beside the best, the plainest is taken.
"""

from booster_ros.diagnosis.search import Candidate, Search, plainness
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
    if not rivals:
        return [chosen]
    again = [search.on_both(one, 1) for one in (chosen, *list(rivals.values())[:RIVALS])]
    least = min(one.fit.cost for one in again)
    return sorted(again, key=lambda one: plainness(one, one.fit.cost - least))
