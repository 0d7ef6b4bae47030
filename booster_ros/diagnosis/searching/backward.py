# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Steps 6 and 7 of the selection: exchange and omit each effect, compare close models again."""

from dataclasses import replace
import itertools

from booster_ros.diagnosis.fitting.intervals import left_of, within
from booster_ros.diagnosis.searching.candidate import (
    Candidate, best_of_each, clearly_better, clears, preferred_first)
from booster_ros.diagnosis.searching.cascade import shows_above_the_stem
from booster_ros.diagnosis.searching.next_effect import extend
from booster_ros.diagnosis.searching.rematch import rematch
from booster_ros.diagnosis.searching.search import (
    FAR_BEHIND, LAST_EVALUATIONS, Search, carried, declared_as_given)
from booster_ros.diagnosis.searching.selection import Progress, Tried, tried_of

_Fewer = dict[tuple[Candidate, tuple[str, ...]], Candidate]

FEW = 3
"""
Number of single effects, and of those that explain a part beside the choice, of which each pair is
tried.
"""

STUCK = 2.0
"""
Ratio of scores, without an effect to with it, above which the fit without it got stuck: without an
effect that is not told from none, or that another one contains, a model scores as it does with it.
"""


def compared(search: Search, tried: Tried, tell: Progress) -> Tried:
    """Carry out steps 6 and 7: exchange each effect, leave each out, fit close models anew."""
    everything = list(tried.all)
    fewer: _Fewer = {}
    chosen = _two_in_its_place(search, tried.chosen, everything, tell)
    chosen = _exchanged(search, chosen, everything, tell, fewer)
    chosen = _backward(search, chosen, everything, fewer)
    tell('comparing those nearest to each other', 0.78)
    again = rematch(search, chosen, everything)
    everything += again
    chosen = _pruned(search, again[0], everything)
    return tried_of(tried.refit, chosen, everything)


def _without(search: Search, chosen: Candidate, rest: tuple[str, ...],
             everything: list[Candidate], fewer: _Fewer) -> Candidate:
    """
    Return the chosen model with only the effects `rest`, fitted once and kept in `fewer`.

    A choice that learnt from the select segments as well is compared with one that learnt from
    them, too. Where the stem sticks, the fit of an earlier round with these effects serves: another
    takes long.
    """
    if (chosen, rest) not in fewer:
        same = [one for one in everything if set(one.effects) == set(rest) and one.fit.sticks
                and one.learnt == chosen.learnt]
        fewer[chosen, rest] = min(same, key=lambda c: c.score) if same else _left_with(
            search, chosen, rest)
    return fewer[chosen, rest]


def _left_with(search: Search, chosen: Candidate, rest: tuple[str, ...]) -> Candidate:
    """Return the chosen model with only the effects `rest`, fitted to the same segments."""
    smaller = search.without(chosen, rest)
    return search.on_both(smaller, search.thinning) if chosen.learnt else smaller


def _two_in_its_place(search: Search, chosen: Candidate, everything: list[Candidate],
                      tell: Progress) -> Candidate:
    """
    Return the model with two other effects in the place of a single one that imitated both.

    Beside an effect that explains nearly all, another that takes away only a part of the rest is
    not added: a law that is not quite the valve's leaves as much. But it may be one of two that
    the single effect imitated. So it is tried beside the best few other single effects as well, all
    else as given, as alone such an effect had bent the declared parameters; and the two are taken
    if they leave hardly anything. No model of a stem that sticks is among them, as each would take
    minutes.
    """
    if len(chosen.effects) != 1 or chosen.fit.sticks:
        return chosen
    others = [one for one in everything if not one.fault and not one.fit.sticks]
    single = [one for one in others if len(one.effects) == 1 and one.effects != chosen.effects]
    beside = [one for one in others if len(one.effects) == 2
              and set(one.effects) > set(chosen.effects) and clearly_better(one, chosen)]
    pairs = []
    for first, second in itertools.product(_best(single), _best(beside)):
        (instead,), (added,) = first.effects, second.but(chosen.effects[0])
        if added != instead:
            tell(f'trying {instead} and {added} in the place of {chosen.effects[0]}', 0.69)
            problem = search.joint(search.problem(), (instead, added))
            fit = problem.fit(declared_as_given(
                problem, carried(problem, second.fit, first.fit)), LAST_EVALUATIONS)
            pairs.append(search.judged(search.rate((instead, added), problem, fit)))
    everything += pairs
    clear = [one for one in pairs if not one.fault and clearly_better(one, chosen)
             and clears(one, chosen)]
    return preferred_first([chosen, *clear])[0]


def _best(models: list[Candidate]) -> list[Candidate]:
    """Return the best model of each set of effects, a few at the most."""
    return list(best_of_each(models).values())[:FEW]


def _exchanged(search: Search, chosen: Candidate, everything: list[Candidate], tell: Progress,
               fewer: _Fewer) -> Candidate:
    """
    Try every other effect in the place of each of several effects.

    The first effect was chosen while the later ones were missing, and may have imitated them.
    Another that does as well in its place is told apart from it here, or reported beside it. In
    the place of the last effect, all others have been tried already.
    """
    for k, name in enumerate(chosen.effects[:-1]):
        tell(f'trying others in the place of {name}', 0.7 + 0.03 * k)
        parent = _without(search, chosen, chosen.but(name), everything, fewer)
        parent = replace(parent, lasting=chosen.lasting.intersection(parent.effects))
        others = extend(
            search, parent, lambda: None, _not_instead(chosen, parent, name, search.names),
            worth=FAR_BEHIND * chosen.fit.cost)
        everything += others
        best = preferred_first([chosen, *others])[0]
        if best is not chosen:
            return best
    return chosen


def _not_instead(chosen: Candidate, parent: Candidate, name: str, names: tuple[str, ...]
                 ) -> tuple[str, ...]:
    """Return the effects not to be tried in the place of `name`, which `parent` is without."""
    # effects of a stem that sticks take minutes to fit
    if parent.fit.sticks:
        return (name, *(other for other in names if not shows_above_the_stem(other)))
    return () if chosen.fit.sticks else (name,)


def _backward(search: Search, chosen: Candidate, everything: list[Candidate], fewer: _Fewer
              ) -> Candidate:
    """Leave out every effect that has a fault, or without which the others do as well."""
    if len(chosen.effects) < 2:
        return chosen
    faults = search.faults(chosen)
    for name in chosen.effects:
        fault = name in faults
        rest = left_of(chosen.effects, name) if fault else chosen.but(name)
        smaller = _without(search, chosen, rest, everything, fewer)
        contained = any(name in within(other) for other in smaller.effects)
        if (fault or contained) and smaller.fit.sticks and smaller.score > STUCK * chosen.score:
            smaller = _left_with(search, chosen, smaller.effects)
        everything.append(smaller)
        if fault or not clearly_better(chosen, smaller):
            return _backward(search, smaller, everything, fewer)
    return chosen


def _pruned(search: Search, chosen: Candidate, everything: list[Candidate]) -> Candidate:
    """Leave out every effect that the last and fullest fit does not tell from none."""
    name = next(iter(search.faults(chosen)), None)
    if name is None:
        return chosen
    smaller = search.on_both(search.without(chosen, left_of(chosen.effects, name)), 1)
    everything.append(smaller)
    return _pruned(search, smaller, everything)
