# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
From a prepared experiment to a verdict.

The order of work is that of `search`; here it is driven to its end, the locked test part is opened
once, and everything is put into words and numbers.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from booster_ros.diagnosis.experiment import UNITS, Experiment, rmse
from booster_ros.diagnosis.fit import Fit, Problem, declared_freedom, get
from booster_ros.diagnosis.intervals import block_bootstrap, interval_of
from booster_ros.diagnosis.result import (
    ChannelError, Diagnosis, FoundEffect, Interval, Refitted, Suspect, UnknownTerm)
from booster_ros.diagnosis.search import (
    MOST_EFFECTS, Candidate, Search, at, clearly_better, gain)
from booster_ros.diagnosis.segments import rows_of, split
from booster_ros.diagnosis.unknown import LOCATION_NAMES, linear_reach, terms
from booster_ros.model import discrepancy as term
from booster_ros.model.catalogue import EFFECTS
from booster_ros.model.parameters import DESCRIPTIONS
from booster_ros.model.system import PositionerParameters

Array = np.ndarray
Progress = Callable[[str, float], None]

NEAR_NOISE = 1.06
"""Mean square misfit below which no further effect is looked for."""

WELL_EXPLAINED = 1.5
"""Mean square misfit up to which named effects count as the whole explanation."""

BEAM = 2
"""Models that are carried to the next round: the first effect found need not be a true one."""

TOO_SIMILAR = 0.02
"""Models whose misfits differ by less than this share cannot be told apart by the record."""


@dataclass(frozen=True)
class _Tried:
    """All models that were fitted, and the one that was chosen."""

    refit: Candidate
    chosen: Candidate
    all: tuple[Candidate, ...]
    reasons: dict[tuple[str, ...], str]


def diagnose(
    experiment: Experiment, declared: PositionerParameters, progress: Progress | None = None,
    notes: tuple[str, ...] = (),
) -> Diagnosis:
    """
    Return what the model lacks, judged by this experiment.

    `progress` is called with a phrase and the share done. ValueError where there is too little
    data to fit.
    """
    tell = progress or (lambda phrase, share: None)
    drive = next(iter(experiment.pinned.values()), experiment.current) if np.ptp(
        experiment.current) == 0.0 else experiment.current
    segments = split(experiment.time, drive)
    search = Search(experiment, segments, declared, tuple(declared_freedom(declared)))
    tell('refitting the declared parameters', 0.02)
    tried = _forward(search, tell)
    tell('looking for a discrepancy without a name', 0.8)
    unnamed = _unnamed(search, tried)
    tell('final fit and intervals', 0.92)
    result = _conclude(search, tried, unnamed, notes)
    tell('done', 1.0)
    return result


def _forward(search: Search, tell: Progress) -> _Tried:
    """Steps 1 to 7 of the search."""
    refit = search.refit()
    everything = [refit]
    reasons: dict[tuple[str, ...], str] = {(): 'the declared model, refitted'}
    chosen = refit
    beam = [refit]
    for level in range(MOST_EFFECTS):
        if chosen.misfit < NEAR_NOISE and chosen.prior < 10.0:
            break
        found: dict[frozenset[str], Candidate] = {}
        for k, parent in enumerate(beam):
            done = [0]

            def tick(parent_index: int = k, count: list[int] = done) -> None:
                count[0] += 1
                share = (parent_index + min(count[0] / 33.0, 1.0)) / len(beam)
                tell(f'trying effect {level + 1}', 0.05 + 0.25 * (level + share))

            for candidate in search.extend(parent, tick):
                key = frozenset(candidate.effects)
                if key not in found or candidate.score < found[key].score:
                    found[key] = candidate
        ranked = sorted(found.values(), key=lambda c: c.score)
        everything += ranked
        if not ranked or not clearly_better(ranked[0], chosen):
            break
        chosen = ranked[0]
        beam = ranked[:BEAM]
    chosen = _backward(search, chosen, everything)
    for candidate in everything:
        reasons.setdefault(candidate.effects, _reason(candidate, chosen))
    reasons[chosen.effects] = 'chosen' if chosen.effects else reasons[()]
    return _Tried(refit, chosen, tuple(everything), reasons)


def _backward(search: Search, chosen: Candidate, everything: list[Candidate]) -> Candidate:
    """Leave out every effect that the others do not need."""
    if len(chosen.effects) < 2:
        return chosen
    for name in chosen.effects[:-1]:
        rest = tuple(e for e in chosen.effects if e != name)
        problem = search.problem()
        problem = search.joint(problem, rest)
        z = search.carried(chosen, problem)
        smaller = search.rate(rest, problem, problem.fit(z, evaluations=12))
        everything.append(smaller)
        if not clearly_better(chosen, smaller):
            return _backward(search, smaller, everything)
    return chosen


def _reason(candidate: Candidate, chosen: Candidate) -> str:
    fall, error = gain(candidate, chosen)
    if set(chosen.effects) < set(candidate.effects):
        return 'the added effect does not lower the held-back error enough'
    if fall > max(error, TOO_SIMILAR * candidate.score):
        return f'{candidate.score / max(chosen.score, 1e-12):.3g} times the squared error of the choice'
    return 'not told apart from the choice by this record'


def _unnamed(search: Search, tried: _Tried) -> Candidate | None:
    """Return the best model with a tabulated term, None where named effects explain the record."""
    if tried.chosen.misfit < WELL_EXPLAINED:
        return None
    problem = tried.refit.problem
    thin = search.thinned(problem)
    best: Candidate | None = None
    references = [at(thin, tried.refit.fit.z), at(thin, thin.start())]
    reached = sorted(
        (linear_reach(thin, reference, one) + (one,) for reference in references
         for one in terms(search.experiment.channels)), key=lambda found: found[0])
    seen: set[str] = set()
    for cost, z, joint, one in reached:
        if one.label in seen or len(seen) >= 3:
            continue
        seen.add(one.label)
        full = Problem(search.experiment, problem.rows, joint.base, joint.freedoms)
        fit = full.fit(z, evaluations=10)
        candidate = search.rate((f'unknown: {one.label}',), full, fit)
        if best is None or candidate.score < best.score:
            best = candidate
    return best


def _conclude(search: Search, tried: _Tried, unnamed: Candidate | None, notes: tuple[str, ...]
              ) -> Diagnosis:
    """Refit on all but the locked part, open that part once, and collect the numbers."""
    experiment = search.experiment
    used, size = ('fit', 'select'), len(experiment.time)
    rows, locked = rows_of(search.segments, used, size), rows_of(search.segments, ('test',), size)
    before = _final(tried.refit, rows)
    verdict, best = 'none', tried.refit
    if tried.chosen.effects:
        verdict, best = 'effect', tried.chosen
    if unnamed is not None and clearly_better(unnamed, best, 0.1):
        verdict, best = 'unknown', unnamed
    after = before if verdict == 'none' else _final(best, rows)
    effects: tuple[FoundEffect, ...] = ()
    table = None
    if verdict == 'effect':
        effects = _found(search, tried, best, after, rows)
    elif verdict == 'unknown':
        effects, table = _found_unknown(best, after)
    runs = {
        'declared': experiment.predict(search.declared),
        'before': experiment.predict(before.parameters, before.initial),
        'after': experiment.predict(after.parameters, after.initial),
    }
    suspects = [Suspect(c.effects, c.misfit, tried.reasons[c.effects])
                for c in sorted(tried.all, key=lambda c: c.score)]
    if unnamed is not None:
        fate = 'chosen: structure that no named effect predicts' if verdict == 'unknown' else (
            'not clearly better than the named effects')
        suspects.insert(0, Suspect(unnamed.effects, unnamed.misfit, fate))
    return Diagnosis(
        verdict, effects, table, _errors(experiment, runs, rows),
        _errors(experiment, runs, locked), tuple(suspects), _refitted(before, after, search),
        search.declared, before.parameters, after.parameters, experiment,
        tuple(search.segments), runs, notes)


def _final(candidate: Candidate, rows: Array) -> Fit:
    problem = replace(candidate.problem, rows=rows)
    return problem.fit(candidate.fit.z, evaluations=12)


def _errors(experiment: Experiment, runs: dict[str, dict[str, Array]], rows: Array
            ) -> dict[str, ChannelError]:
    return {
        name: ChannelError(
            UNITS[name], *(rmse(measured, runs[stage][name], rows)
                           for stage in ('declared', 'before', 'after')),
            experiment.noise[name])
        for name, measured in experiment.measured.items()
    }


def _found(search: Search, tried: _Tried, best: Candidate, after: Fit, rows: Array
           ) -> tuple[FoundEffect, ...]:
    problem = replace(best.problem, rows=rows)
    draws = block_bootstrap(problem, after, search.segments)
    found = []
    for name in best.effects:
        effect = EFFECTS[name]
        parameters = {}
        for knob in effect.knobs:
            index = next(j for j, free in enumerate(problem.freedoms)
                         if free.knob.parameter == knob.parameter)
            value, low, high = interval_of(problem, draws, after, index)
            parameters[knob.parameter] = Interval(
                value, low, high, DESCRIPTIONS[knob.parameter].unit)
        rest = tuple(e for e in best.effects if e != name)
        rivals = _rivals(name, rest, tried, best)
        without = min((c for c in tried.all if set(c.effects) <= set(rest)),
                      key=lambda c: c.score)
        fall, error = gain(without, best)
        found.append(FoundEffect(
            name, effect.location, parameters, rivals, effect.separating_experiment,
            {'misfit_without': without.misfit, 'misfit_with': best.misfit,
             'score_fall': fall, 'score_fall_standard_error': error}))
    return tuple(found)


def _rivals(name: str, rest: tuple[str, ...], tried: _Tried, best: Candidate) -> tuple[str, ...]:
    """Return the effects that could stand in the place of this one for all this record says."""
    rivals = []
    for candidate in tried.all:
        others = set(candidate.effects) - set(rest)
        if len(others) != 1 or not set(rest) <= set(candidate.effects) or name in others:
            continue
        fall, error = gain(candidate, best)
        if fall < max(error if fall < 0.2 * best.score else 0.0, TOO_SIMILAR * best.score):
            rivals += sorted(others)
    return tuple(dict.fromkeys(rivals))


def _found_unknown(best: Candidate, after: Fit) -> tuple[tuple[FoundEffect, ...], UnknownTerm]:
    table = after.parameters.discrepancy
    location = term.LOCATIONS[table.location]
    knots = np.linspace(table.low, table.high, term.KNOTS)
    unknown = UnknownTerm(
        location, term.VARIABLES[table.variable], term.VARIABLE_UNITS[table.variable],
        term.LOCATION_UNITS[table.location], knots, np.array(table.values))
    name = LOCATION_NAMES.get(location, location)
    effect = FoundEffect(
        'unknown', name, {}, (),
        f'vary {term.VARIABLES[table.variable]} alone, with the channels on both sides of '
        f'{name} recorded', {'misfit_with': best.misfit})
    return (effect,), unknown


def _refitted(before: Fit, after: Fit, search: Search) -> tuple[Refitted, ...]:
    rows = []
    for free in search.freedoms:
        name = free.knob.parameter
        label = name if free.element is None else f'{name}[{free.element}]'

        def value(p: PositionerParameters) -> float:
            if free.element is None:
                return get(p, name)
            component, attribute = name.split('.')
            return float(getattr(getattr(p, component), attribute)[free.element])

        rows.append(Refitted(
            label, DESCRIPTIONS[name].unit, value(search.declared), value(before.parameters),
            value(after.parameters), free.scale))
    return tuple(rows)
