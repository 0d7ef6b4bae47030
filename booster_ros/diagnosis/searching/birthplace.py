# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Where a discrepancy is born: what the chamber pressure says before any effect is tried.

Model: the part of the positioner above the stem, driven by the measured current and the measured
stem (see cascade), with its declared parameters refitted. What is missing in this part shows in
its pressure as much as in that of the whole model. What is missing in the stem or in its sensor
shows in the whole model alone, where whatever bends the pressure can imitate it.

1. Refit the part above the stem to the measured pressure.
2. Where the whole model leaves far more than this part, try only what belongs to the stem or to a
   sensor, with a name or without one.
3. Where no effect alone helps the whole model, as two are missing (one above the stem, and
   friction, say), find the one above the stem in this part, without the other.
"""

from dataclasses import replace

from booster_ros.diagnosis.searching.candidate import Candidate, clearly_better
from booster_ros.diagnosis.searching.cascade import search_above, shows_above_the_stem
from booster_ros.diagnosis.searching.next_effect import extend
from booster_ros.diagnosis.searching.search import EVALUATIONS, Search, carried
from booster_ros.model.catalogue import EFFECTS

HARDLY = 0.02
"""
Share of the whole model's excess over noise: if the part above the stem leaves no more than this,
hardly anything is missing there. What is missing above the stem leaves 0.4 or more; beside
something missing in the stem, 0.04 or more.
"""

SMOOTHED = 3.5
"""
Mean square misfit up to which the part above the stem counts as right: smoothing the measured stem
may leave as much.
"""

_BELOW = frozenset({'stem', 'sensor'})


def where_born(search: Search, refit: Candidate) -> Search:
    """Return the search without the effects of places that can have no part in what is missing."""
    above = search_above(search)
    if above is None:
        return search
    left = _left(above.refit())
    if left > SMOOTHED or left - 1.0 > HARDLY * (_left(refit) - 1.0):
        return search
    names = tuple(name for name in search.names if EFFECTS[name].location in _BELOW)
    return replace(search, names=names, places=_BELOW)


def called_for_above(search: Search, refit: Candidate) -> Candidate | None:
    """Return the whole model with the effect that the part above the stem calls for, or None."""
    above = search_above(search)
    if above is None:
        return None
    above = replace(above, names=tuple(filter(shows_above_the_stem, search.names)))
    without = above.refit()
    found = next((one for one in extend(above, without, lambda: None)
                  if not one.fault and clearly_better(one, without)), None)
    if found is None:
        return None
    problem = search.joint(search.problem(), found.effects)
    fit = problem.fit(carried(problem, refit.fit, found.fit), evaluations=EVALUATIONS)
    return search.judged(search.rate(found.effects, problem, fit))


def _left(fitted: Candidate) -> float:
    """Return the mean square misfit of the fit or the select segments, whichever is larger."""
    return max(fitted.misfit, fitted.fitted_misfit)
