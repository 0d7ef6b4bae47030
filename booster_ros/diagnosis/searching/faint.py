# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Effects that matter little and show all the same, where all that is left could be noise.

What an effect takes away may be less than the uncertainty of the noise's level and still be beyond
doubt, as the effect's trace is not that of noise. Thinned rows hide it. So:

1. fit the model to every row;
2. simulate each effect of the catalogue in a small size, once, and reckon by how much it lowers the
   cost with all other parameters reacting (see screening.promise): a score test (C. R. Rao, 1948);
3. fit those that promise most, and those that thinned rows already call for, to every row;
4. an effect shows if it lowers the cost and the score by more than the best of a whole catalogue
   does by chance, lowers the score by two standard errors, and is told from none. It has to show
   as well beside the model without it, fitted from where the fit with it ended: a better place for
   the declared parameters is no effect.
"""

from booster_ros.diagnosis.fitting.side_by_side import side_by_side
from booster_ros.diagnosis.searching.candidate import (
    FAINTEST_COST, NEAR_NOISE, Candidate, preferred_first, shows_faintly)
from booster_ros.diagnosis.searching.screening import (
    Promise, promise, reference_at, strong_frequencies)
from booster_ros.diagnosis.searching.search import EVALUATIONS, Search, carried

PERHAPS = 15.0
"""Fall of the cost on thinned rows above which an effect is fitted to every row."""

HALF = 0.5
"""Share that an effect has to promise of the fall of the cost that is asked for."""

MOST = 3
"""Number of effects that are fitted: those that promise most."""


def shown_on_every_row(search: Search, found: Candidate, ranked: list[Candidate]
                       ) -> list[Candidate]:
    """
    Return the models with an effect that every row shows, best first.

    `ranked` are models fitted to thinned rows. No model is returned where effects were found
    already, or where `found` leaves more than noise.
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
