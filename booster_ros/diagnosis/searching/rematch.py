# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The choice between models that the search could hardly tell apart.

The search fits to a thinned part of the record, and stops early; that blurs scores by more than
the difference between two similar effects. So close models meet again:

1. rivals of the choice are models with as many effects and a score near that of the choice,
2. and models that this record could not tell from the choice by its sensitivities (see
   indistinct), also where no fit has found that yet;
3. all are fitted to every row of the fit and select segments, to their very ends; those that then
   seem unlikely are fitted from the end of the best as well;
4. of the models whose effects these rows show, and that these fits do not make unlikely beside the
   best, the plainest is taken.

Where the stem sticks, full fits take minutes and their cost is rough. There, models that differ
from the choice in one effect, above the stem or of it, are fitted once more to the thinned rows.
They begin with what they share with the choice, or, where they differ above the stem, with what is
seen there. The plainest of those not told apart is taken; what tells them apart is the whole or,
where they differ above the stem, what is seen there. Two kinds of rival are fitted again whatever
they scored: one whose effect is contained in that of the choice (friction that is the same
everywhere, in friction that may differ), as its fit got stuck if it does not reach what the choice
does though its size is enough for that; and one that leaves less than the choice above the stem.
"""

from collections.abc import Iterable
from dataclasses import replace

from booster_ros.diagnosis.fitting.descent import SETTLED
from booster_ros.diagnosis.fitting.friction_start import best_friction
from booster_ros.diagnosis.fitting.intervals import within
from booster_ros.diagnosis.searching.candidate import (
    UNLIKELY, Candidate, best_of_each, plainness, preferred_first)
from booster_ros.diagnosis.searching.cascade import (
    as_seen_above, fitted_above, shows_above_the_stem)
from booster_ros.diagnosis.searching.indistinct import substitutes
from booster_ros.diagnosis.searching.next_effect import STILL_FAR, redundant
from booster_ros.diagnosis.searching.search import EVALUATIONS, LAST_EVALUATIONS, Search, carried

NEAR = 1.15
"""Score, relative to that of the choice, up to which a model is fitted again."""

RIVALS = 3
"""Number of rivals that are fitted again, at the most."""

ROUGHLY = 2.0
"""
Ratio of scores in the place of NEAR where the stem sticks: up to it, slips that come by chance may
be what tells models apart.
"""


def rematch(search: Search, chosen: Candidate, tried: list[Candidate]) -> list[Candidate]:
    """Return the choice and its rivals, fitted anew, plainest first; the choice alone if none."""
    if not chosen.effects:
        return [chosen]
    if chosen.fit.sticks:
        return _rematch_sticking(search, chosen, tried)
    rivals = best_of_each(
        one for one in tried
        if set(one.effects) != set(chosen.effects) and len(one.effects) == len(chosen.effects)
        and not one.fault and one.score < NEAR * chosen.score)
    for one in _indistinct(search, chosen):
        rivals.setdefault(frozenset(one.effects), one)
    if not rivals:
        return [chosen]
    again = [search.to_the_end(one) for one in (chosen, *list(rivals.values())[:RIVALS])]
    best = min(again, key=lambda one: one.fit.cost)
    again = [_from_the_end_of(best, search, one) for one in again]
    least = min(one.fit.cost for one in again)
    again = [search.judged(one) for one in again]
    return sorted(again, key=lambda one: (bool(one.fault), plainness(one, one.fit.cost - least)))


def _from_the_end_of(best: Candidate, search: Search, one: Candidate) -> Candidate:
    """
    Return the model fitted from the end of the best, if it seemed unlikely beside the best.

    It begins with the values of the best for what both have. In a flat valley one fit may end
    short of the lowest place, by as much as makes a model unlikely, and the fit of another model
    that is the same in all but name may not.
    """
    if not UNLIKELY < one.fit.cost - best.fit.cost < (NEAR - 1.0) * best.fit.cost:
        return one
    fit = one.problem.fit(carried(one.problem, one.fit, best.fit), LAST_EVALUATIONS, SETTLED)
    return search.refitted(one, fit) if fit.cost < one.fit.cost else one


def _rematch_sticking(search: Search, chosen: Candidate, tried: list[Candidate]) -> list[Candidate]:
    """Return the choice and the rivals that differ from it in one effect, the plainest first."""
    near: dict[frozenset[str], Candidate] = {}
    far: dict[frozenset[str], Candidate] = {}
    for one in sorted(tried, key=lambda c: c.score):
        swapped = set(one.effects) ^ set(chosen.effects)
        alike = len(swapped) == 2 and len({shows_above_the_stem(name) for name in swapped}) == 1
        if alike and len(one.effects) == len(chosen.effects) and not one.fault:
            close = one.score < ROUGHLY * chosen.score or _in_the_choice(one, chosen)
            (near if close else far).setdefault(frozenset(one.effects), one)
    rivals = [*_better_above(search, chosen, far.values()), *near.values()]
    known = {free.knob.parameter for free in chosen.problem.freedoms}
    again = [chosen]
    for one in rivals[:RIVALS]:
        z = carried(one.problem, one.fit, chosen.fit)
        for j, free in enumerate(one.problem.freedoms):
            if free.knob.parameter not in known and not free.knob.shape:
                z[j] = 0.0
        if any(map(shows_above_the_stem, set(one.effects) - set(chosen.effects))):
            z = as_seen_above(search, one, z, ('fit',))
        fit = replace(one.problem, fine=True).fit(z, evaluations=EVALUATIONS)
        again.append(search.refitted(one, fit))
    ranked = _by_slips(search, preferred_first(again))
    plainest = _plainest_above(search, ranked)
    return [plainest, *(one for one in ranked if one is not plainest)]


def _by_slips(search: Search, ranked: list[Candidate]) -> list[Candidate]:
    """
    Return the models, kinds of friction told by what slips do where single slips are missed.

    When each slip comes is chance then, and slips that are too small miss the rows least. Each
    kind of friction is sought anew as far as it shows through slips. Kinds that miss no more than
    NEAR times what the best one misses count as alike, and the plainest of them comes first.
    """
    best, *others = ranked
    kinds = [best, *(one for one in others if not one.fault and one.fit.sticks
                     and not any(map(shows_above_the_stem, set(one.effects) ^ set(best.effects))))]
    if len(kinds) == 1 or best.misfit < STILL_FAR:
        return ranked
    missed = []
    for one in kinds:
        fit = one.problem.fit_through_slips(best_friction(one.problem, one.fit.z), EVALUATIONS)
        held_back = search.on(one.problem, ('select',), search.thinning)
        missed.append((held_back.cost_through_slips(fit.z), search.refitted(one, fit)))
    least = min(cost for cost, _ in missed)
    near = [one for cost, one in missed if cost < NEAR * least]
    first = min(near, key=lambda one: plainness(one, 0.0))
    return [first, *(one for one in ranked if one.effects != first.effects)]


def _better_above(search: Search, chosen: Candidate, far: Iterable[Candidate]) -> list[Candidate]:
    """
    Return the models far behind the choice that leave less above the stem than it does.

    They got stuck, as they were fitted in the whole beside friction that suited another effect.
    """
    others = [one for one in far
              if any(map(shows_above_the_stem, set(one.effects) - set(chosen.effects)))]
    mine = fitted_above(search, chosen, ('fit',)) if others else None
    if mine is None:
        return []
    seen = [(fitted_above(search, one, ('fit',)), one) for one in others]
    return [one for above, one in seen if above is not None and above.score < mine.score]


def _plainest_above(search: Search, ranked: list[Candidate]) -> Candidate:
    """
    Return the first, or the plainest of those that do as well above the stem and differ only there.

    A leak of the chamber and one of the exhaust seat are the same air; in the whole, slips that
    come by chance may tell them apart.
    """
    best = ranked[0]
    alike = [best, *(one for one in ranked[1:] if not one.fault
                     and one.score < ROUGHLY * best.score and all(
                         map(shows_above_the_stem, set(one.effects) ^ set(best.effects))))]
    if len(alike) == 1:
        return best
    upper = [(fitted_above(search, one, ('fit',)), one) for one in alike]
    seen = [(above, one) for above, one in upper if above is not None]
    least = min((above.fit.cost for above, _ in seen), default=0.0)
    return min(seen, key=lambda pair: plainness(pair[0], pair[0].fit.cost - least),
               default=(None, best))[1]


def _in_the_choice(one: Candidate, chosen: Candidate) -> bool:
    """Tell whether an effect of the choice builds on a size of that which `one` has instead."""
    mine, its = set(chosen.effects) - set(one.effects), set(one.effects) - set(chosen.effects)
    return any(b in within(a) for a in mine for b in its)


def _indistinct(search: Search, chosen: Candidate) -> list[Candidate]:
    """Return models with one effect of the choice exchanged that do as well whatever the noise."""
    fitted_to = ('fit', 'select')
    problem = search.on(chosen.problem, fitted_to, search.thinning)
    whole = search.on(chosen.problem, fitted_to, 1).rows_counted()
    likely = UNLIKELY * problem.rows_counted() / whole
    fit = problem.at(chosen.fit.z)
    found = []
    for effect in chosen.effects:
        rest = chosen.but(effect)
        others = tuple(name for name in search.names
                       if name not in chosen.effects and not redundant(name, rest))
        without = search.on(search.joint(search.problem(), rest), fitted_to, search.thinning)
        for one in substitutes(problem, fit, without, others):
            if one.cost < likely:
                thin = search.on(one.problem, ('fit',), search.thinning)
                found.append(search.rate(
                    (*rest, one.effect), thin, thin.fit(one.start, evaluations=EVALUATIONS)))
    return found
