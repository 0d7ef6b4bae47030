# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The locked part, by which nothing is chosen: it is opened once, and what does not stand falls.

1. Named effects that left much where they were chosen and leave much in the locked part as well
   have explained little, and give way to the best term without a name. Not where the stem sticks:
   there the right friction may miss single slips by more than no friction does.
2. A term without a name that makes the error of the locked part larger is refused.
3. Named effects to which a refused term had been preferred count if they do not leave much there.

Where much is left of what was fitted, something is missing even if nothing stands: a term that the
held-back segments call for tells where it seems to be, though that term explains too little of
all.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from booster_ros.diagnosis.experiment.experiment import Experiment
from booster_ros.diagnosis.experiment.segments import USED, Segment, rows_of
from booster_ros.diagnosis.last_fit import LastFit, verdict_of
from booster_ros.diagnosis.result import ChannelError, Refused, UnknownTerm, errors_of
from booster_ros.diagnosis.searching.candidate import Candidate
from booster_ros.diagnosis.searching.course import beyond
from booster_ros.diagnosis.searching.nameless import FAITHFUL, FORESEEN, leave_less
from booster_ros.diagnosis.searching.search import Search
from booster_ros.diagnosis.searching.selection import Tried
from booster_ros.diagnosis.searching.unknown import place_of

Array = np.ndarray

STANDS = 1.1
"""Squared error of the locked part, relative to that without a term, up to which the term
stands."""

DOES_NOT_STAND = 'does not stand: the locked part is missed by more with it'
EXPLAINS_LITTLE = 'leaves much of what is missing, in the locked part as well'


@dataclass(frozen=True, eq=False)
class Opened:
    """
    A verdict (none, effect, unknown) with its fit, and what the locked part says of it.

    `tried` are the models tried, the chosen one as far as it stands; `runs` are predictions by
    stage, `errors` the errors of the locked part by channel. `decided` tells whether the verdict
    would be another one without the locked part.
    """

    verdict: str
    tried: Tried
    last: LastFit
    runs: dict[str, dict[str, Array]]
    errors: dict[str, ChannelError]
    refused: Refused | None = None
    decided: bool = False


def less_the_locked_part(experiment: Experiment, segments: list[Segment]) -> Experiment:
    """Return the experiment without the locked part's values, by which nothing may be chosen."""
    rows = rows_of(segments, USED, len(experiment.time))
    return replace(experiment, measured={
        name: np.where(rows, values, np.nan) for name, values in experiment.measured.items()})


def opened(search: Search, tried: Tried, unnamed: list[Candidate], refit: LastFit) -> Opened:
    """Return the verdict that stands in the locked part; `unnamed` are terms, the best first."""
    experiment = search.experiment
    locked = rows_of(search.segments, ('test',), len(experiment.time))
    first = {
        'declared': experiment.predict(search.declared),
        'before': experiment.predict(refit.fit.parameters, refit.fit.initial)}

    def judged(tried: Tried, unnamed: list[Candidate]) -> Opened:
        verdict, tried, last = verdict_of(search, tried, unnamed, refit)
        runs = {**first, 'after': experiment.predict(last.fit.parameters, last.fit.initial)}
        return Opened(verdict, tried, last, runs, errors_of(experiment, runs, locked))

    found = judged(tried, unnamed)
    if unnamed and _explain_little(found):
        term = judged(_none_of(found.tried), unnamed)
        found = found if term.verdict == 'none' else replace(term, decided=True)
    if found.verdict == 'none' and unnamed and _misses_much(refit):
        little = UnknownTerm(unnamed[0].fit.parameters.discrepancy)
        return replace(found, verdict='unknown', refused=Refused(
            place_of(little.table.location), little.variable, None, 0.0))
    if found.verdict != 'unknown' or stands(found.errors):
        return found
    refused = _refused(experiment, found, locked)
    found = judged(found.tried, [])
    if found.verdict == 'effect' and leave_much(found.errors):
        found = judged(_none_of(found.tried), [])
    return replace(found, refused=refused, decided=True,
                   verdict='unknown' if found.verdict == 'none' else found.verdict)


def stands(errors: Mapping[str, ChannelError]) -> bool:
    """Tell whether what was added makes the error in data that were not fitted no larger."""
    before, after, noise = _squares(errors)
    return after <= STANDS * max(before, noise)


def leave_much(errors: Mapping[str, ChannelError]) -> bool:
    """Tell whether what was added leaves a good share of what is missing, and more than noise."""
    before, after, noise = _squares(errors)
    enough = max((FAITHFUL - 1.0) * noise, FORESEEN * (before - noise))
    return not after - noise <= enough  # true also where the model did not come to the end


def _squares(errors: Mapping[str, ChannelError]) -> tuple[float, float, float]:
    """Return sums of squares over channels, in multiples of the noise's: before, after, noise."""
    seen = [error for error in errors.values() if np.isfinite(error.before)]
    return (sum((error.before / error.noise)**2 for error in seen),
            sum((error.after / error.noise)**2 for error in seen), float(len(seen)))


def _explain_little(found: Opened) -> bool:
    """Tell whether named effects leave much both where they were chosen and in the locked part."""
    if found.verdict != 'effect' or found.last.fit.sticks:
        return False
    return (found.tried.held_out.misfit > FAITHFUL and not leave_less(found.tried, FORESEEN)
            and leave_much(found.errors))


def _misses_much(refit: LastFit) -> bool:
    """Tell whether the declared model leaves much of what it was fitted to."""
    return refit.problem.mean_square(refit.fit) > FAITHFUL


def _none_of(tried: Tried) -> Tried:
    """Return the models tried with nothing chosen, as what was chosen has explained little."""
    return replace(tried, chosen=tried.refit, reasons={
        **tried.reasons, frozenset(tried.chosen.effects): EXPLAINS_LITTLE})


def _refused(experiment: Experiment, found: Opened, locked: Array) -> Refused:
    fit = found.last.fit
    term = UnknownTerm(fit.parameters.discrepancy)
    outside = beyond(term.seen, experiment, fit.parameters, fit.initial)
    return Refused(
        place_of(term.table.location), term.variable,
        {name: error.after for name, error in found.errors.items() if np.isfinite(error.after)},
        float(np.mean(outside[locked])))
