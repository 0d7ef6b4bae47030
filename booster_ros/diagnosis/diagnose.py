# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
From a prepared experiment to a verdict.

The named effects are selected (selection), terms without a name compete with them (nameless), the
locked test part is opened once, and everything is put into words and numbers.
"""

from dataclasses import replace

import numpy as np

from booster_ros.diagnosis.experiment.experiment import Experiment
from booster_ros.diagnosis.experiment.segments import USED, Segment, rows_of, split, split_sweep
from booster_ros.diagnosis.fitting.applicable import applicable, free_to_refit
from booster_ros.diagnosis.fitting.fit import Fit
from booster_ros.diagnosis.fitting.freedom import Free, get, label
from booster_ros.diagnosis.fitting.intervals import interval_of, shapes_of, traded
from booster_ros.diagnosis.last_fit import LastFit, draws_of, last_fit
from booster_ros.diagnosis.left_open import models_alike, with_left_open
from booster_ros.diagnosis.locked_part import DOES_NOT_STAND, less_the_locked_part, opened
from booster_ros.diagnosis.repeatability import chance
from booster_ros.diagnosis.result import (
    Diagnosis, FoundEffect, Refitted, Refused, Suspect, UnknownTerm, either, errors_of)
from booster_ros.diagnosis.searching.backward import compared
from booster_ros.diagnosis.searching.birthplace import where_born
from booster_ros.diagnosis.searching.candidate import (
    NOT_TOLD_APART, Candidate, best_of_each, gain, told_apart)
from booster_ros.diagnosis.searching.forward import named
from booster_ros.diagnosis.searching.nameless import (
    TOO_LITTLE, best_terms, beyond_names, compete, preferable)
from booster_ros.diagnosis.searching.search import Search
from booster_ros.diagnosis.searching.selection import Progress, Tried
from booster_ros.diagnosis.searching.unknown import UNNAMED, label_of, place_of
from booster_ros.model.catalogue import EFFECTS
from booster_ros.model.discrepancy import NONE
from booster_ros.model.parameters import DESCRIPTIONS
from booster_ros.model.system import PositionerParameters
from booster_ros.records import RecordError

Array = np.ndarray

BEST_NAMED = 'the best of the named, which explain less'
"""Fate of the named effects that were chosen, where a term without a name is reported."""

NEAR_LIMIT = 0.01
"""Distance of a declared parameter from an end of its range, relative to the way there from the
given value, below which it is at that end: a fit comes near the ends of a range from the inside
and does not touch them."""


def diagnose(
    experiment: Experiment, declared: PositionerParameters, progress: Progress | None = None,
    notes: tuple[str, ...] = (),
) -> Diagnosis:
    """
    Return what the model lacks, judged by this experiment.

    `progress` is called with a phrase and the share done. RecordError where the record is too
    short, or holds too few values to compare, to be cut into parts to fit, select and judge by.
    """
    tell = progress or (lambda phrase, share: None)
    drive = next(iter(experiment.pinned.values()), experiment.current) if np.ptp(
        experiment.current) == 0.0 else experiment.current
    segments = split_sweep(len(experiment.time)) if experiment.quasi_static else split(
        experiment.time, drive)
    _check_parts(experiment, segments)
    search = Search(experiment, segments, declared, free_to_refit(declared, experiment),
                    applicable(less_the_locked_part(experiment, segments), declared))
    tell('refitting the declared parameters', 0.02)
    refit = search.refit()
    search = where_born(search, refit)
    tried, unnamed = _sought(search, refit, tell)
    tell('final fit and intervals', 0.92)
    result = _conclude(search, tried, unnamed, notes)
    tell('done', 1.0)
    return result


def _check_parts(experiment: Experiment, segments: list[Segment]) -> None:
    for role, purpose in (('fit', 'fit'), ('select', 'select between models'), ('test', 'judge')):
        rows = rows_of(segments, (role,), len(experiment.time))
        if not any(np.isfinite(values[rows]).any() for values in experiment.measured.values()):
            raise RecordError(
                f'the record has no row to {purpose} by: those meant for it, '
                f'{int(rows.sum())} of {len(rows)}, have no value that can be compared')


def _sought(search: Search, refit: Candidate, tell: Progress) -> tuple[Tried, list[Candidate]]:
    """Return the models with named effects, and the terms without a name that compete with them."""
    unnamed: list[Candidate] = []
    beside: Candidate | None = None

    def beyond(tried: Tried) -> bool:
        nonlocal unnamed, beside
        if tried.chosen is not beside:  # once for each choice: it takes as long as a round
            tell('looking for a discrepancy without a name', 0.65)
            unnamed, beside = best_terms(search, tried), tried.chosen
        return beyond_names(unnamed, tried)

    first = named(search, refit, tell, beyond)
    if beyond(first):
        return first, unnamed
    tried = compared(search, first, tell)
    if not unnamed or set(tried.chosen.effects) != set(first.chosen.effects):
        unnamed = best_terms(search, tried)
    return tried, unnamed if compete(tried) else []


def _conclude(search: Search, tried: Tried, unnamed: list[Candidate], notes: tuple[str, ...]
              ) -> Diagnosis:
    """Refit on all but the locked part, open that part once, and collect the numbers."""
    experiment = search.experiment
    rows = rows_of(search.segments, USED, len(experiment.time))
    refit = last_fit(search, tried.refit)
    found = opened(search, tried, unnamed, refit)
    tried, last = found.tried, found.last
    before, after = refit.fit, last.fit
    effects: tuple[FoundEffect, ...] = ()
    table = None
    if found.verdict == 'effect':
        effects = _found(tried, last)
    elif found.refused is not None:  # what the term was made for is there all the same
        effects = (_nameless(found.refused.location, unnamed[:1]),)
    elif found.verdict == 'unknown':
        effects, table = _found_unknown(unnamed, after)
    last = last if len(last.draws) else replace(last, draws=draws_of(search, last))
    fitted = errors_of(experiment, found.runs, rows)
    refitted = _refitted(before, last, search)
    # where the record is not met, what is missing would pass for left open; beside a term over
    # time, which is fitted alone, all else is left open
    told = all(one.met for one in fitted.values() if np.isfinite(one.after))
    whole = len(last.fit.freedoms) >= len(search.freedoms)
    models = models_alike(last, last.draws) if told and whole else None
    locked = rows_of(search.segments, ('test',), len(experiment.time))
    return Diagnosis(
        found.verdict, effects, table, fitted,
        with_left_open(found.errors, experiment, found.runs['after'], models, locked),
        _suspects(tried, unnamed, table, found.refused),
        refitted, search.declared, before.parameters, after.parameters,
        experiment, tuple(search.segments), found.runs,
        (*notes, *_cornered(refitted), *known_together(effects, last),
         *filter(None, map(either, effects)),
         *_replaced(search.declared, after.parameters),
         *chance(experiment, after.parameters, after.initial, 'this record')),
        refused=found.refused, start=after.initial, decided=found.decided, alike=models)


def _suspects(tried: Tried, unnamed: list[Candidate], added: UnknownTerm | None,
              refused: Refused | None) -> tuple[Suspect, ...]:
    """Return the models tried with their fates: terms without a name first, others by score."""
    reasons = dict(tried.reasons)
    if added is not None:
        reasons = {effects: f'not told apart from {BEST_NAMED}' if reason == NOT_TOLD_APART
                   else reason for effects, reason in reasons.items()}
        if tried.chosen.effects:
            reasons[frozenset(tried.chosen.effects)] = BEST_NAMED
    fates = [_fate(unnamed[0], tried, added, refused)] if unnamed else []
    fates += ['not told apart from the one above'] * (len(unnamed) - 1)
    return (*(Suspect(one.effects, one.misfit, fate) for one, fate in zip(unnamed, fates)),
            *(Suspect(one.effects, one.misfit, reasons[effects])
              for effects, one in best_of_each(tried.all).items()))


def _fate(term: Candidate, tried: Tried, added: UnknownTerm | None, refused: Refused | None
          ) -> str:
    """Return what became of the best term without a name."""
    if added is not None:
        return 'chosen: structure that no named effect predicts'
    if refused is not None and refused.error is not None:
        return DOES_NOT_STAND
    return TOO_LITTLE if preferable(term, tried) else 'not clearly better than the named effects'


def _cornered(refitted: tuple[Refitted, ...]) -> tuple[str, ...]:
    """Return a sentence for each declared parameter that ended at a limit of the refit."""
    return tuple(
        f'{one.name} went from {one.given:.4g} to {one.after:.4g} {one.unit}, the end of what a '
        'refit allows: its value is no measurement, and the model may lack something else'
        for one in refitted if one.at_limit)


def known_together(effects: tuple[FoundEffect, ...], last: LastFit) -> tuple[str, ...]:
    """Return a sentence for each size of an effect that the record shows only with its shapes."""
    return tuple(
        f'{size} and {" and ".join(sorted(shapes_of(effect.name)))} are known together only: this '
        'record shows one trace of them, and each may be far larger or smaller than it says'
        for effect in effects if effect.name in EFFECTS
        for size in traded(last.problem, last.fit, effect.name))


def _replaced(declared: PositionerParameters, found: PositionerParameters) -> tuple[str, ...]:
    """Return a sentence where a term without a name took the place of one that was declared."""
    had, has = declared.discrepancy, found.discrepancy
    if had.location == NONE or has == had:
        return ()
    return (f'the declared term without a name ({label_of(had.location, had.variable)}) is no '
            'longer in the model: a model holds one, and the one that was found took its place',)


def _found(tried: Tried, last: LastFit) -> tuple[FoundEffect, ...]:
    best, held_out = tried.chosen, tried.held_out
    found = []
    for name in best.effects:
        effect = EFFECTS[name]
        own = {knob.parameter for knob in effect.knobs}
        parameters = {}
        for index, free in enumerate(last.problem.freedoms):
            parameter = free.knob.parameter
            if parameter in own:
                tried_ends = last.trials.ends(index) if last.trials else None
                parameters[parameter] = interval_of(
                    last.problem, last.draws, last.fit, index, tried_ends)
        rest = best.but(name)
        rivals = _rivals(name, rest, tried, best)
        without = _best_without(rest, held_out, tried)
        fall, error = gain(without, held_out)
        found.append(FoundEffect(
            name, effect.location, parameters, rivals, effect.separating_experiment,
            {'misfit_without': without.misfit, 'misfit_with': held_out.misfit,
             'score_fall': fall, 'score_fall_standard_error': error}))
    return tuple(found)


def _best_without(rest: tuple[str, ...], best: Candidate, tried: Tried) -> Candidate:
    """
    Return the best model with no effects beyond `rest`, of those that learnt as `best` did.

    Where there is one: a score on segments that a model was fitted to (learnt) is no measure for
    the score of a model from which they were held back.
    """
    return min((c for c in tried.all if set(c.effects) <= set(rest)),
               key=lambda c: (c.learnt != best.learnt, c.score))


def _rivals(name: str, rest: tuple[str, ...], tried: Tried, best: Candidate) -> tuple[str, ...]:
    """Return the effects that could take the place of this one for all that this record says."""
    rivals = []
    for candidate in tried.all:
        others = set(candidate.effects) - set(rest)
        if len(others) != 1 or not set(rest) <= set(candidate.effects) or name in others:
            continue
        if not candidate.fault and not told_apart(candidate, best):
            rivals += sorted(others)
    return tuple(dict.fromkeys(rivals))


def _found_unknown(alike: list[Candidate], after: Fit
                   ) -> tuple[tuple[FoundEffect, ...], UnknownTerm]:
    unknown = UnknownTerm(after.parameters.discrepancy)
    return (_nameless(place_of(unknown.table.location), alike),), unknown


def _nameless(place: str, alike: list[Candidate]) -> FoundEffect:
    """Return a finding without a name in this place; terms `alike` tell of it equally well."""
    return FoundEffect(
        'unknown', place, {}, tuple(one.effects[0].removeprefix(UNNAMED) for one in alike[1:]),
        '', {'misfit_with': alike[0].misfit})


def _at_limit(free: Free, z: float) -> bool:
    """Tell whether a declared parameter ended at either end of what a refit allows."""
    return any(abs(z - end) < NEAR_LIMIT * abs(end) for end in (free.low, free.high))


def _refitted(before: Fit, last: LastFit, search: Search) -> tuple[Refitted, ...]:
    after = last.fit
    rows = []
    places = {(free.knob.parameter, free.element): j for j, free in enumerate(after.freedoms)}
    for free in search.freedoms:
        name, element = free.knob.parameter, free.element
        j = places.get((name, element))
        # its prior may be looser beside an effect; a term over time is fitted alone
        looser = free if j is None else after.freedoms[j]
        z = looser.variable(get(after.parameters, name, element))
        at_limit = _at_limit(looser, z)
        low = high = np.nan
        if j is not None and not at_limit:
            interval = interval_of(last.problem, last.draws, after, j)
            low, high = interval.low, interval.high
        width = abs(looser.variable(high) - looser.variable(low)) / (2.0 * 1.96 * looser.sigma)
        rows.append(Refitted(
            label(free), DESCRIPTIONS[name].unit,
            get(search.declared, name, element), get(before.parameters, name, element),
            get(after.parameters, name, element), looser.spread,
            free.away(free.variable(get(before.parameters, name, element))), looser.away(z),
            at_limit, low, high, width))
    return tuple(rows)
