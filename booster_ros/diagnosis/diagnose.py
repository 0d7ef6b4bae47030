# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
From a prepared experiment to a verdict.

The order of work is that of `search`; here it is driven to its end, the locked test part is opened
once, and everything is put into words and numbers.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
import itertools

import numpy as np

from booster_ros.diagnosis.applicable import applicable, matters
from booster_ros.diagnosis.cascade import shows_above_the_stem
from booster_ros.diagnosis.experiment import UNITS, Experiment, rmse
from booster_ros.diagnosis.fit import Fit, Free, Problem, declared_freedom, get
from booster_ros.diagnosis.intervals import block_bootstrap, interval_of
from booster_ros.diagnosis.rematch import rematch
from booster_ros.diagnosis.result import (
    ChannelError, Diagnosis, FoundEffect, Interval, Refitted, Suspect, UnknownTerm)
from booster_ros.diagnosis.search import (
    EVALUATIONS, FINALISTS, MOST_EFFECTS, NEAR_NOISE, NEGLIGIBLE, PROMISING, Candidate,
    Search, clearly_better, gain, polished, preferred_first, told_apart)
from booster_ros.diagnosis.segments import (
    rows_of, segment_of_row, split, split_sweep)
from booster_ros.diagnosis.unknown import LOCATION_NAMES, linear_reach, moved, terms
from booster_ros.model import discrepancy as term
from booster_ros.model.actuator import has_dry_friction
from booster_ros.model.catalogue import EFFECTS
from booster_ros.model.parameters import DESCRIPTIONS
from booster_ros.model.system import PositionerParameters

Array = np.ndarray
Progress = Callable[[str, float], None]

USED = ('fit', 'select')

PLAUSIBLE = 12.0
"""Sum of squared departures of the declared parameters that their priors still allow."""

WELL_EXPLAINED = 1.5
"""Mean square misfit up to which named effects count as the whole explanation."""

NEAR_LIMIT = 0.01
"""A declared parameter this near the end of its range, relative to its way there, is at it."""

WORSE = 1.05
"""Held-out error after, relative to before, from which a note warns."""

ALIKE = 10.0
"""Cost by screening, relative to the choice, up to which another effect may be its equal."""

CLEARED = 0.3
"""Of what is left above noise, the share that an effect may leave where little was left."""

MOSTLY = 0.03
"""Share of the declared model's excess over noise below which no nameless term competes."""

FORESEEN = 0.2
"""Share of it below which no term over time competes: that says what was, not what comes."""

LIKELY_TERMS = 4
"""Terms without a name that are fitted: those that reach furthest by linear reckoning."""


@dataclass(frozen=True)
class _Tried:
    """All models that were fitted, and the one that was chosen."""

    refit: Candidate
    chosen: Candidate
    all: tuple[Candidate, ...]
    reasons: dict[tuple[str, ...], str]

    @property
    def held_out(self) -> Candidate:
        """The chosen effects as they scored on segments they had not been fitted to."""
        return next(one for one in self.all if set(one.effects) == set(self.chosen.effects))


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
    segments = split_sweep(len(experiment.time)) if experiment.quasi_static else split(
        experiment.time, drive)
    freedoms = tuple(free for free in declared_freedom(declared, experiment)
                     if matters(free.knob.parameter, experiment))
    search = Search(experiment, segments, declared, freedoms, applicable(experiment, declared))
    tell('refitting the declared parameters', 0.02)
    tried = _forward(search, tell)
    tell('looking for a discrepancy without a name', 0.8)
    unnamed = _unnamed(search, tried)
    tell('final fit and intervals', 0.92)
    result = _conclude(search, tried, unnamed, notes)
    tell('done', 1.0)
    return result


def _forward(search: Search, tell: Progress) -> _Tried:
    """Carry out steps 1 to 7 of the search."""
    refit = search.refit()
    everything = [refit]
    chosen = refit
    parent = refit
    for level in range(MOST_EFFECTS):
        if _explained(chosen, refit) or _fits_all(search, chosen):
            break
        ranked = _round(search, parent, level, tell)
        everything += ranked
        if ranked and _adds(ranked[0], chosen, refit):
            chosen = ranked[0]
        elif not ranked or level + 1 - len(chosen.effects) > _patience(chosen):
            break
        parent = ranked[0]
    chosen = _exchanged(search, chosen, everything, tell)
    chosen = _backward(search, chosen, everything)
    tell('comparing those nearest to each other', 0.78)
    chosen, *rivals = rematch(search, chosen, everything)
    everything += rivals
    chosen = _pruned(search, chosen, everything)
    reasons = {c.effects: _reason(c, chosen) for c in everything}
    reasons[chosen.effects] = 'chosen'
    reasons[()] = 'the declared model, refitted'
    return _Tried(refit, chosen, tuple(everything), reasons)


def _patience(chosen: Candidate) -> int:
    """Return how many rounds may find nothing clear: of two effects each alone may not show."""
    slow = has_dry_friction(chosen.fit.parameters.actuator)
    return 1 if chosen.misfit > WELL_EXPLAINED and not slow else 0


def _explained(chosen: Candidate, refit: Candidate) -> bool:
    """
    Tell whether what is left is noise.

    Where nothing has been added yet, noise must be all that is left of the fit segments as well: an
    effect may show in few segments only. Where the stem sticks, what idealising its friction may
    leave is taken for noise: no model repeats every slip, and another round takes minutes.
    """
    if has_dry_friction(chosen.fit.parameters.actuator) and _idealised(chosen, refit):
        return True
    fitted = chosen.fit.cost < NEAR_NOISE * chosen.problem.rows_counted()
    return chosen.misfit < NEAR_NOISE and chosen.prior < PLAUSIBLE and (
        bool(chosen.effects) or fitted)


def _fits_all(search: Search, chosen: Candidate) -> bool:
    """
    Tell whether the effects so far leave noise once the select segments are fitted as well.

    Then these showed what the fit segments could not teach, a limit that none of them reached, say,
    and nothing is missing. Not where the stem sticks: that fit takes minutes.
    """
    if not chosen.effects or has_dry_friction(chosen.fit.parameters.actuator):
        return False
    both = search.on_both(chosen, search.thinning)
    return both.fit.cost < NEAR_NOISE * both.problem.rows_counted() and both.prior < PLAUSIBLE


def _idealised(chosen: Candidate, refit: Candidate) -> bool:
    """Tell whether idealising the effects so far may leave as much, beside all they explain."""
    return bool(chosen.effects) and chosen.misfit - 1.0 < NEGLIGIBLE * (refit.misfit - 1.0)


def _adds(better: Candidate, chosen: Candidate, refit: Candidate) -> bool:
    """Tell whether one effect more is called for; where little is left, only if it clears that."""
    return not better.fault and clearly_better(better, chosen) and (
        not _idealised(chosen, refit) or better.misfit - 1.0 < CLEARED * (chosen.misfit - 1.0))


def _round(search: Search, parent: Candidate, level: int, tell: Progress) -> list[Candidate]:
    """Return the models with one effect more than the parent, best first."""
    steps = len(search.names) + PROMISING + FINALISTS
    done = itertools.count(1)

    def tick() -> None:
        share = min(next(done) / steps, 1.0)
        tell(f'trying effect {level + 1}', 0.05 + 0.2 * (level + share))

    return search.extend(parent, tick)


def _exchanged(search: Search, chosen: Candidate, everything: list[Candidate], tell: Progress
               ) -> Candidate:
    """
    Try every other effect in the place of each of several.

    The first was chosen while the others were missing and may have imitated them; what does as
    well in its place is told apart from it here, or reported beside it. In the place of the last
    all others have been tried already.
    """
    for k, name in enumerate(chosen.effects[:-1]):
        rest = tuple(e for e in chosen.effects if e != name)
        tell(f'trying others in the place of {name}', 0.7 + 0.03 * k)
        parent = search.without(chosen, rest)
        others = search.extend(
            parent, lambda: None, (name, *_slow_beside(parent, search.names)),
            worth=ALIKE * chosen.fit.cost)
        everything += others
        best = preferred_first([chosen, *others])[0]
        if best is not chosen:
            return best
    return chosen


def _slow_beside(parent: Candidate, names: tuple[str, ...]) -> tuple[str, ...]:
    """Return the effects that take minutes to try beside a parent's: of a stem that sticks."""
    if not has_dry_friction(parent.fit.parameters.actuator):
        return ()
    return tuple(name for name in names if not shows_above_the_stem(name))


def _backward(search: Search, chosen: Candidate, everything: list[Candidate]) -> Candidate:
    """Leave out every effect that the others do not need."""
    if len(chosen.effects) < 2:
        return chosen
    for name in chosen.effects:
        rest = tuple(e for e in chosen.effects if e != name)
        smaller = search.without(chosen, rest)
        everything.append(smaller)
        if search.fault(chosen.problem, chosen.fit, name) or not clearly_better(chosen, smaller):
            return _backward(search, smaller, everything)
    return chosen


def _pruned(search: Search, chosen: Candidate, everything: list[Candidate]) -> Candidate:
    """Leave out every effect that the last and fullest fit does not tell from none."""
    for name in chosen.effects:
        if search.fault(chosen.problem, chosen.fit, name):
            rest = tuple(e for e in chosen.effects if e != name)
            smaller = search.on_both(search.without(chosen, rest), 1)
            everything.append(smaller)
            return _pruned(search, smaller, everything)
    return chosen


def _reason(candidate: Candidate, chosen: Candidate) -> str:
    if set(chosen.effects) < set(candidate.effects):
        return 'the added effect does not lower the held-back error enough'
    if candidate.fault:
        return candidate.fault
    if told_apart(candidate, chosen):
        ratio = candidate.score / max(chosen.score, 1e-12)
        return f'{ratio:.3g} times the squared error of the choice'
    return 'not told apart from the choice by this record'


def _unnamed(search: Search, tried: _Tried) -> Candidate | None:
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


def _conclude(search: Search, tried: _Tried, unnamed: Candidate | None, notes: tuple[str, ...]
              ) -> Diagnosis:
    """Refit on all but the locked part, open that part once, and collect the numbers."""
    experiment = search.experiment
    size = len(experiment.time)
    rows, locked = rows_of(search.segments, USED, size), rows_of(search.segments, ('test',), size)
    _, before = _final(search, tried.refit)
    verdict, best = 'none', tried.refit
    if tried.chosen.effects:
        verdict, best = 'effect', tried.chosen
    if unnamed is not None and (
            not tried.chosen.effects or clearly_better(unnamed, tried.held_out)):
        verdict, best = 'unknown', unnamed
    problem, after = _final(search, best)
    effects: tuple[FoundEffect, ...] = ()
    table = None
    if verdict == 'effect':
        effects = _found(search, tried, best, problem, after)
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
        if verdict == 'unknown':  # what was chosen among the named is not what is reported
            suspects = [replace(s, reason='the best of the named, which explain less')
                        if s.effects and s.effects == tried.chosen.effects else s
                        for s in suspects]
        suspects.insert(0, Suspect(unnamed.effects, unnamed.misfit, fate))
    held_out = _errors(experiment, runs, locked)
    refitted = _refitted(before, after, search)
    return Diagnosis(
        verdict, effects, table, _errors(experiment, runs, rows), held_out, tuple(suspects),
        refitted, search.declared, before.parameters, after.parameters,
        experiment, tuple(search.segments), runs,
        (*notes, *_doubts(held_out), *_cornered(refitted)))


def _doubts(held_out: dict[str, ChannelError]) -> tuple[str, ...]:
    """Return a sentence for each channel in which the locked part speaks against the choice."""
    return tuple(
        f'on the locked part the error of {name} rises from {error.before:.3g} to '
        f'{error.after:.3g} {error.unit} with what was added: trust it less'
        for name, error in held_out.items() if error.after > WORSE * max(error.before, error.noise))


def _cornered(refitted: tuple[Refitted, ...]) -> tuple[str, ...]:
    """Return a sentence for each declared parameter that ended where a refit has to end."""
    return tuple(
        f'{one.name} went from {one.given:.4g} to {one.after:.4g} {one.unit}, the end of what a '
        'refit allows: its value is no measurement, and the model may lack something else'
        for one in refitted if one.at_limit)


def _final(search: Search, candidate: Candidate) -> tuple[Problem, Fit]:
    """
    Return the candidate fitted to all but the locked part.

    Where that leaves more than noise, once more from the declared parameters as given and typical
    shapes: they may have ended in a corner where they imitated the effect before it was there.
    """
    problem = search.on(candidate.problem, USED, 1)
    fit = problem.fit(candidate.fit.z, evaluations=EVALUATIONS)
    if not has_dry_friction(fit.parameters.actuator):
        fit = polished(problem, fit)
    if not candidate.effects or fit.cost < NEAR_NOISE * problem.rows_counted():
        return problem, problem.without_unseen(fit)
    fresh = fit.z.copy()
    fresh[:len(search.freedoms)] = 0.0
    fresh[len(problem.freedoms):] = 0.0
    for j, free in enumerate(problem.freedoms):
        if free.knob.shape:
            fresh[j] = free.without_size
    again = problem.fit(fresh, evaluations=EVALUATIONS)
    return problem, problem.without_unseen(min(fit, again, key=lambda found: found.cost))


def _errors(experiment: Experiment, runs: dict[str, dict[str, Array]], rows: Array
            ) -> dict[str, ChannelError]:
    errors = {}
    for name, measured in experiment.measured.items():
        declared, before, after = (
            rmse(measured, runs[stage][name], rows) for stage in ('declared', 'before', 'after'))
        errors[name] = ChannelError(
            UNITS[name], declared, before, after, experiment.noise[name])
    return errors


def _found(search: Search, tried: _Tried, best: Candidate, problem: Problem, after: Fit
           ) -> tuple[FoundEffect, ...]:
    draws = block_bootstrap(
        problem, after, segment_of_row(search.segments, len(search.experiment.time)))
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
        if not candidate.fault and not told_apart(candidate, best):
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


def _at_limit(free: Free, z: float) -> bool:
    """Tell whether a declared parameter ended at either end of what a refit allows."""
    value, given = free.value(z), free.value(0.0)
    return any(abs(value - end) < NEAR_LIMIT * abs(end - given)
               for end in (free.knob.low, free.knob.high))


def _refitted(before: Fit, after: Fit, search: Search) -> tuple[Refitted, ...]:
    rows = []
    for free, z in zip(search.freedoms, after.z):
        name, element = free.knob.parameter, free.element
        rows.append(Refitted(
            name if element is None else f'{name}[{element}]', DESCRIPTIONS[name].unit,
            get(search.declared, name, element), get(before.parameters, name, element),
            get(after.parameters, name, element), free.scale,
            _at_limit(free, z)))
    return tuple(rows)
