# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Terms without a name: when they compete with named effects, which is best, and its last fit."""

from dataclasses import replace

import numpy as np

from booster_ros.diagnosis.experiment.segments import USED
from booster_ros.diagnosis.fitting.fit import Fit, Problem
from booster_ros.diagnosis.searching.candidate import (
    NEAR_NOISE, TOO_SIMILAR, WORTH_ADDING, Candidate, clearly_better, explains, told_apart)
from booster_ros.diagnosis.searching.knots import looking_closer
from booster_ros.diagnosis.searching.next_effect import FIRST_EVALUATIONS
from booster_ros.diagnosis.searching.search import (
    EVALUATIONS, WORTH_A_LAST_POLISHING, Search, polished)
from booster_ros.diagnosis.searching.forward import WELL_EXPLAINED
from booster_ros.diagnosis.searching.selection import Tried
from booster_ros.diagnosis.searching.teaching import fitted_to_noise, taught_what_it_missed
from booster_ros.diagnosis.searching.unknown import (
    UNNAMED, linear_reach, moved, terms, with_free_past)
from booster_ros.model import discrepancy as term

Array = np.ndarray

MOSTLY = 0.03
"""
Share of the declared model's excess over noise: where named effects leave less, no term without a
name competes with a single one, nor with several where the stem sticks.
"""

FORESEEN = 0.2
"""
Share of the same excess: where named effects leave less, a term over time must do more than other
terms, as it says what was, not what comes. A single name that leaves more has explained little.
"""

FAITHFUL = 3.0
"""
Mean square misfit that a term over time must stay below in that case, in which none counts where
nothing drives the record.
"""

WITHIN_REACH = 5.0
POINTED_AT = 2.0
"""
Multiples of the least cost that a term reaches by linear reckoning: terms up to the first are
tried, and up to the second they begin where the reckoning points. For the others, the reckoning is
far off where much is missing. What a lag does is far from straight: it is tried whatever the
reckoning says, and does not begin where that points.
"""

TOO_LITTLE = 'fitted to all but the locked part, it explains too little'
"""Reason why a term without a name is not added that comes nearest to what is missing."""

UNFELT = 1e-9
"""Largest value of a term, in sizes that show, that is rounding where nothing asks for any."""

_NEED_A_CLOCK = (*term.CHANGE_OF, term.BACK_PRESSURE_ERROR)

LIKELY_TERMS = 4
"""Terms that are fitted to their end: those that the first steps of a fit take furthest."""

LOOKS = 3
"""How often the knots of a term go to where it bends."""

BEYOND = 0.5
"""
Share of what several named effects leave: a term that leaves less settles the matter without an
exchange of them, which takes as long as all that went before.
"""


def best_terms(search: Search, tried: Tried) -> list[Candidate]:
    """
    Return the best model with a tabulated term, then those that this record cannot tell from it.

    No model is returned where named effects explain the record. Of terms that score nearly the
    same, the first is the one whose kind comes first in unknown.terms: converters creep and drift
    more often than supplies sag. Where there are named effects, the select segments may teach a
    term over a state what the fit segments could not, as they may teach the named effects: those
    that compete here left more than noise where they were fitted, or still did when taught.

    Where no named effect helps and no term scores clearly better, they compete on fit and select
    segments together.
    """
    if not compete(tried):
        return []
    foreseen = bool(tried.chosen.effects) and leave_less(tried, FORESEEN)
    candidates = [_fitted(search, label, joint, z)
                  for label, joint, z in _likely(search, tried.refit, foreseen)]
    if tried.chosen.effects:
        candidates = [one if over_time(one) else taught_what_it_missed(search, one) or one
                      for one in candidates]
    if foreseen:
        candidates = [one for one in candidates
                      if not over_time(one) or one.misfit < FAITHFUL]
    if not candidates:
        return []
    best = min(candidates, key=lambda c: c.score)
    if tried.chosen.effects or clearly_better(best, tried.refit):
        return as_good(candidates, best)
    return _best_on_both(search, tried.refit, candidates)


def _best_on_both(search: Search, refit: Candidate, candidates: list[Candidate]
                  ) -> list[Candidate]:
    """
    Return the terms that explain fit and select segments together best, of nearly the same cost.

    Those over time come last, as in `as_good`. Where much is left, noise is no explanation, and
    what is missing may show in some segments only. Each term has to explain as much as a named
    effect has to; one over time, which bends to all it is fitted to, also has to come near the
    noise. Where none does and much is left, the one that comes nearest is returned with its fault:
    it tells a place, and is not to be added.
    """
    refit = search.on_both(refit, search.thinning)
    together = [search.on_both(candidate, search.thinning) for candidate in candidates]
    rows = refit.problem.rows_counted()
    enough = [one for one in together if explains(one.fit, refit.fit, rows)
              and not (over_time(one) and one.fit.cost >= FAITHFUL * rows)]
    nearest = min(enough or together, key=lambda one: one.fit.cost)
    if enough:
        near = [one for one in enough if one.fit.cost < (1.0 + TOO_SIMILAR) * nearest.fit.cost]
        return sorted(near, key=over_time)
    much = refit.fit.cost > FAITHFUL * rows
    return [replace(nearest, fault=TOO_LITTLE)] if much else []


def compete(tried: Tried) -> bool:
    """
    Tell whether the named effects leave so much that terms without a name compete.

    A single effect may leave a small share of what was missing, as the law behind a name is never
    quite the valve's. Several together bend to what none of them is: they leave noise, or terms
    compete with them. Friction is idealised, so where the stem sticks several effects may leave
    that share, too, and a single one may leave WELL_EXPLAINED, as may the declared model where
    nothing was chosen.
    """
    chosen = tried.chosen
    sticks, several = chosen.fit.sticks, len(chosen.effects) > 1
    enough = NEAR_NOISE if several or (chosen.effects and not sticks) else WELL_EXPLAINED
    nearly_all = chosen.effects and leave_less(tried, MOSTLY) and (sticks or not several)
    return chosen.misfit >= enough and not nearly_all


def leave_less(tried: Tried, share: float) -> bool:
    """Tell whether named effects leave less than this share of the declared model's excess."""
    return tried.held_out.misfit - 1.0 < share * (tried.refit.misfit - 1.0)


def as_good(candidates: list[Candidate], best: Candidate) -> list[Candidate]:
    """
    Return those scoring nearly as well as the best, in their order, then those not told from it.

    A term over time follows whatever happens and says nothing of what comes: it stands behind a
    term over a state that does as well.
    """
    equal = [one for one in candidates if one.score < (1.0 + TOO_SIMILAR) * best.score]
    equal.sort(key=over_time)
    others = [one for one in candidates if one not in equal and not told_apart(one, best)]
    return equal + sorted(others, key=lambda c: c.score)


def preferable(unnamed: Candidate, tried: Tried) -> bool:
    """
    Tell whether the term without a name is the verdict, and not the named effects chosen.

    Several effects together bend to much that none of them is, and a single one that leaves a good
    share of what is missing has explained little. Where such effects leave structure, one term in
    one place that leaves less is the more honest answer.
    """
    named = tried.held_out
    if not tried.chosen.effects or clearly_better(unnamed, named):
        return True
    weak = len(tried.chosen.effects) > 1 or not leave_less(tried, FORESEEN)
    return weak and named.misfit > FAITHFUL and unnamed.score < named.score


def beyond_names(unnamed: list[Candidate], tried: Tried) -> bool:
    """
    Tell whether no exchange of named effects is likely to do as well as a term does.

    Either it leaves several of them far behind, or it alone leaves noise and is clearly better.
    """
    if not unnamed or not tried.chosen.effects:
        return False
    term_alone_explains = unnamed[0].misfit < NEAR_NOISE and clearly_better(
        unnamed[0], tried.held_out)
    far_behind = unnamed[0].misfit < BEYOND * tried.held_out.misfit
    return term_alone_explains or (len(tried.chosen.effects) > 1 and far_behind)


def over_time(candidate: Candidate) -> bool:
    """Tell whether a term without a name that follows the time alone was added."""
    return any(one.endswith(f' over {term.VARIABLES[term.TIME]}') for one in candidate.effects)


def term_alone(search: Search, candidate: Candidate, before: Fit) -> tuple[Problem, Fit]:
    """
    Return a term over time fitted with all else as the refit left it.

    The term says what was, not what comes: at any other time the model is what is left without it.
    Fitted jointly with the term, the declared parameters go to where they are right only as long
    as it lasts.
    """
    joint = search.on(candidate.problem, USED, 1)
    declared = len(search.freedoms)
    base = before.parameters._replace(discrepancy=joint.base.discrepancy)
    problem = replace(joint, base=base, freedoms=joint.freedoms[declared:])
    z = np.concatenate([np.zeros(len(problem.freedoms)), before.z[declared:]])
    fit = problem.fit(z, evaluations=EVALUATIONS)
    return problem, polished(problem, fit, WORTH_A_LAST_POLISHING)


def _fitted(search: Search, label: str, joint: Problem, z: Array) -> Candidate:
    """
    Return the model with a term, fitted to its end.

    Its knots are as `with_term` lays them at first. Where that leaves more than noise, they go to
    where the term bends, as long as it scores better by a share that matters.
    """
    def rated(problem: Problem, begin: Array) -> Candidate:
        # terms in different places differ little in cost
        fit = polished(problem, problem.fit(begin, evaluations=EVALUATIONS))
        return search.rate((UNNAMED + label,), problem, fit)

    best = rated(joint, z)
    if fitted_to_noise(best):
        return best
    for _ in range(LOOKS):
        closer = rated(*looking_closer(best.problem, best.fit))
        gains = closer.score < (1.0 - WORTH_ADDING) * best.score
        best = min(best, closer, key=lambda c: c.score)
        if not gains:
            break
    return best


def _felt(joint: Problem, move: Array) -> bool:
    """
    Tell whether a term moves anything compared; `move` is what linear reckoning makes of it.

    What lies upstream of a measured drive moves nothing.
    """
    return any(abs(step) > UNFELT for free, step in zip(joint.freedoms, move)
               if free.knob.parameter == 'discrepancy.values')


def _likely(search: Search, refit: Candidate, foreseen: bool) -> list[tuple[str, Problem, Array]]:
    """
    Return the terms worth a whole fit, in the order of unknown.terms: label, problem, first z.

    Linear reckoning ranks terms badly where a stem sits on its seat until it jumps, or where the
    refit of the declared parameters has gone far to imitate what is missing. So the first steps of
    a fit decide; those of a term that ranks badly begin at the parameters as given. In a sweep, no
    term over a change and none of a lag is tried: its rows are no time in which anything could be
    forgotten, or come late.
    """
    experiment, thin = search.experiment, refit.problem
    still = np.ptp(experiment.current) == 0.0 and all(
        np.ptp(drive) == 0.0 for drive in experiment.pinned.values())
    likely = [one for one in terms(experiment.channels, search.declared)
              if one.place in search.places
              and not (foreseen and still and one.variable == term.TIME)
              and not (experiment.quasi_static and one.variable in _NEED_A_CLOCK)]
    seen, _ = search.rows_and_experiment(USED, search.thinning)
    reference = thin.at(refit.fit.z)
    reached: dict[str, tuple[float, Array, Array, Problem]] = {}
    for one in likely:  # the same term may be there with several pasts
        reach = linear_reach(thin, reference, one, seen)
        if not _felt(reach[3], reach[2]):
            continue
        if one.label not in reached or reach[0] < reached[one.label][0]:
            reached[one.label] = reach
    least = min((cost for cost, *_ in reached.values()), default=0.0)
    begun: dict[str, tuple[float, Problem, Array]] = {}
    for label, (cost, z, move, joint) in reached.items():
        bends = joint.base.discrepancy.location == term.EP_CONVERTER_LAG
        if bends or cost < WITHIN_REACH * least:
            pointed = cost < POINTED_AT * least and not bends
            start = moved(joint, z, move) if pointed else joint.start()
            problem, start = with_free_past(joint, start)
            first = problem.fit(start, evaluations=FIRST_EVALUATIONS)
            begun[label] = (first.cost, problem, first.z)
    furthest = sorted(begun, key=lambda label: begun[label][0])[:LIKELY_TERMS]
    return [(label, *begun[label][1:]) for label in reached if label in furthest]
