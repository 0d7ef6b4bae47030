# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""When terms without a name compete with the named effects, and which of them is best."""

from booster_ros.diagnosis.search import EVALUATIONS, Candidate, Search, clearly_better
from booster_ros.diagnosis.selection import WELL_EXPLAINED, Tried
from booster_ros.diagnosis.unknown import linear_reach, moved, terms
from booster_ros.model import discrepancy as term

MOSTLY = 0.03
"""Share of the declared model's excess over noise below which no nameless term competes."""

FORESEEN = 0.2
"""Share of it below which no term over time competes: that says what was, not what comes."""

LIKELY_TERMS = 4
"""Terms without a name that are fitted: those that reach furthest by linear reckoning."""


def best_term(search: Search, tried: Tried) -> Candidate | None:
    """
    Return the best model with a tabulated term, None where named effects explain the record.

    Where no named effect helps and much is left, noise is no explanation either: then the terms
    compete on fit and select segments together, for what is missing may show in some of them only.
    """
    left, declared = tried.held_out.misfit - 1.0, tried.refit.misfit - 1.0
    if tried.chosen.misfit < WELL_EXPLAINED or (
            tried.chosen.effects and left < MOSTLY * declared):
        return None
    foreseen = tried.chosen.effects and left < FORESEEN * declared
    likely = [one for one in terms(search.experiment.channels)
              if not (foreseen and one.variable == term.TIME)]
    thin = tried.refit.problem
    references = [thin.at(tried.refit.fit.z), thin.at(thin.start())]
    reached = sorted(
        ((*linear_reach(thin, reference, one), one) for reference in references
         for one in likely), key=lambda found: found[0])
    candidates: dict[str, Candidate] = {}
    for _, z, move, joint, one in reached:
        if one.label in candidates or len(candidates) >= LIKELY_TERMS:
            continue
        fit = joint.fit(moved(joint, z, move), evaluations=EVALUATIONS)
        candidates[one.label] = search.rate((f'unknown: {one.label}',), joint, fit)
    best = min(candidates.values(), key=lambda c: c.score)
    if tried.chosen.effects or clearly_better(best, tried.refit):
        return best
    together = [search.on_both(candidate, search.thinning) for candidate in candidates.values()]
    return min(together, key=lambda c: c.fit.cost)
