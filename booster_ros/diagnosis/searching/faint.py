# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Effects that matter little and show all the same, where all that is left could be noise.

What an effect takes away may be less than what the level of the noise is known to, and still be
beyond doubt, as its trace is not that of noise. Thinned rows hide it. So:

1. fit the model to every row;
2. simulate each effect of the catalogue in a small size, once, and reckon by how much it lowers the
   cost with all other parameters reacting (see screening.promise): a score test (C. R. Rao, 1948);
3. fit those that promise most, and those that thinned rows already call for, to every row;
4. those show that lower the cost and the score beyond what the best of a whole catalogue does by
   chance, by two standard errors, are told from none, and do so beside the model fitted from where
   they end themselves: a better place for the declared parameters is no effect.
"""

from booster_ros.diagnosis.fitting.side_by_side import side_by_side
from booster_ros.diagnosis.searching.candidate import (
    FAINTEST_COST, NEAR_NOISE, Candidate, preferred_first, shows_faintly)
from booster_ros.diagnosis.searching.screening import (
    Promise, promise, reference_at, strong_frequencies)
from booster_ros.diagnosis.searching.search import EVALUATIONS, Search, carried

PERHAPS = 15.0
"""On thinned rows an effect has to lower the cost by so much to be fitted to every row."""

HALF = 0.5
"""Share of the fall of the cost that is asked for that a promise has to come to."""

MOST = 3
"""So many of the effects that promise most are fitted."""


def shown_on_every_row(search: Search, found: Candidate, ranked: list[Candidate]
                       ) -> list[Candidate]:
    """
    Return the models with an effect that every row shows, best first.

    `ranked` are those fitted to thinned rows. None where effects were found already, or `found`
    leaves more than noise.
    """
    if found.effects or found.misfit > NEAR_NOISE:
        return []
    before = search.on_every_row(found)
    hopeful = [search.on_every_row(one) for one in ranked
               if not one.fault and one.fit.cost < found.fit.cost - PERHAPS]
    shown = [one for one in (*hopeful, *_promising(search, before))
             if shows_faintly(one, before) and not search.faults(one)]
    for one in shown:
        again = before.problem.fit(
            carried(before.problem, before.fit, one.fit), evaluations=EVALUATIONS)
        if again.cost < before.fit.cost:
            before = search.refitted(before, again)
    return preferred_first([one for one in shown if shows_faintly(one, before)])


def _promising(search: Search, before: Candidate) -> list[Candidate]:
    """Return the models with the effects that promise most, fitted to every row."""
    problem, fit = before.problem, before.fit
    reference = reference_at(problem, problem.at(fit.z))
    frequencies = strong_frequencies(problem, fit.z)

    def promised(name: str) -> Promise | None:
        return promise(problem, reference, name, frequencies)

    hopeful = sorted(
        (one for one in side_by_side(promised, search.names)
         if one and one.cost < fit.cost - HALF * FAINTEST_COST), key=lambda one: one.cost)
    return [search.rate((one.effect,), one.problem,
                        one.problem.fit(one.start, evaluations=EVALUATIONS))
            for one in hopeful[:MOST]]
