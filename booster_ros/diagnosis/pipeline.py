# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
From a prepared experiment to a verdict: select, estimate, test, report.

1. `select`: effects, and terms without a name, step by step on the training blocks.
2. `final_fit`: the chosen model to every training row and to the very end, with intervals.
3. The test set is opened once: a term without a name that does not stand there is refused.
4. `Diagnosis`: the outcome as data.
"""

from collections.abc import Collection

import numpy as np

from booster_ros.diagnosis.data.blocks import rows_of, split, split_sweep, training_blocks
from booster_ros.diagnosis.data.experiment import Array, Experiment
from booster_ros.diagnosis.estimation.fit import Fit
from booster_ros.diagnosis.estimation.final_fit import FinalFit, final_fit
from booster_ros.diagnosis.estimation.parametrisation import get, label
from booster_ros.diagnosis.estimation.two_steps import in_two_steps
from booster_ros.diagnosis.estimation.uncertainty import at_bound, interval_of
from booster_ros.diagnosis.hypotheses.applicable import applicable, free_to_refit
from booster_ros.diagnosis.hypotheses.discrepancy import UNNAMED, beyond, place_of, with_gentle_ends
from booster_ros.diagnosis.judging.prediction_uncertainty import models_alike, with_left_open
from booster_ros.diagnosis.judging.test_set import stands, without_test_set
from booster_ros.diagnosis.result import (
    ChannelError, Diagnosis, FoundEffect, Refitted, Refused, Suspect, errors_of)
from booster_ros.diagnosis.selection.decide import TIE, Comparison, compare, standing
from booster_ros.diagnosis.selection.equivalence import alike
from booster_ros.diagnosis.selection.score import LARGE
from booster_ros.diagnosis.selection.stepwise import Progress, Selection, comparison, select
from booster_ros.diagnosis.selection.task import (
    PLACES, Model, Task, explained, near_best, seen_above, upstream_task)
from booster_ros.model.catalogue import EFFECTS
from booster_ros.model.discrepancy import VARIABLES, covered
from booster_ros.model.parameters import DESCRIPTIONS
from booster_ros.model.system import PositionerParameters
from booster_ros.records import RecordError

Runs = dict[str, dict[str, Array]]


def diagnose(experiment: Experiment, declared: PositionerParameters,
             progress: Progress | None = None, notes: tuple[str, ...] = (),
             names: Collection[str] = tuple(EFFECTS), places: frozenset[str] = PLACES) -> Diagnosis:
    """
    Return what the model lacks, judged by this experiment.

    `progress` is called with a phrase and the share done; `names` are the effects to try, `places`
    those of terms without a name. RecordError where there is too little to fit and to judge by.
    """
    tell = progress or (lambda phrase, share: None)
    task = _task(experiment, declared, names, places)
    selection = select(task, tell)
    tell('final fit and intervals', 0.9)
    block = training_blocks(task.segments, len(experiment.time))
    chosen, after, runs, refused = _tested(task, selection, block)
    result = _diagnosis(task, selection, chosen, after, runs, refused, notes)
    tell('done', 1.0)
    return result


def _task(experiment: Experiment, declared: PositionerParameters, names: Collection[str],
          places: frozenset[str]) -> Task:
    drive = experiment.current
    if np.ptp(drive) == 0.0:
        drive = next(iter(experiment.pinned.values()), drive)
    segments = split_sweep(len(experiment.time)) if experiment.quasi_static else split(
        experiment.time, drive)
    for role, purpose in (('train', 'fit'), ('test', 'judge')):
        rows = rows_of(segments, role, len(experiment.time))
        if not any(np.isfinite(values[rows]).any() for values in experiment.measured.values()):
            raise RecordError(
                f'the record has no row to {purpose} by: those meant for it, '
                f'{int(rows.sum())} of {len(rows)}, have no value that can be compared')
    tried = applicable(without_test_set(experiment, segments), declared)
    return Task(experiment, segments, declared, free_to_refit(declared, experiment),
                tuple(name for name in tried if name in names),
                frozenset() if experiment.is_slow else places)


def _tested(task: Task, selection: Selection, block: Array
            ) -> tuple[Model, FinalFit, Runs, Refused | None]:
    """Return the model that stands in the test set, its last fit, all runs, and what is refused."""
    experiment = task.experiment
    test = rows_of(task.segments, 'test', len(experiment.time))
    declared = experiment.predict(task.declared)

    def judged(model: Model) -> tuple[FinalFit, Runs, dict[str, ChannelError]]:
        last = _last_fit(task, model, block)
        if _unnamed(model):
            last = final_fit(with_gentle_ends(last.problem, last.fit), last.fit.z, block)
        runs = {'declared': declared, **{
            stage: experiment.predict(one.parameters, one.initial)
            for stage, one in (('before', _before(selection, model, last)), ('after', last.fit))}}
        return last, runs, errors_of(experiment, runs, test)

    chosen = selection.chosen
    after, runs, errors = judged(chosen)
    while unseen := [name for name in chosen.effects if _is_none(after, name)]:
        chosen = _without(selection, chosen, unseen[0])
        after, runs, errors = judged(chosen)
    if not _unnamed(chosen) or stands(errors):
        return chosen, after, runs, None
    table = after.fit.parameters.discrepancy
    outside = beyond(covered(table), experiment, after.fit.parameters, after.fit.initial)
    refused = Refused(
        place_of(table.location), VARIABLES[table.variable],
        {name: error.after for name, error in errors.items() if np.isfinite(error.after)},
        float(np.mean(outside[test])))
    return selection.named, *judged(selection.named)[:2], refused


def _last_fit(task: Task, model: Model, block: Array) -> FinalFit:
    """Return the last fit of a model, in two steps where its stem sticks and is seen as it is."""
    problem = task.on_every_row(model.problem)
    misread = any(name in EFFECTS and EFFECTS[name].reading == 'valve_position'
                  for name in model.effects)
    above = upstream_task(task) if problem.observation.summary and not misread else None
    if above is None:
        return final_fit(problem, model.fit.z, block)
    subsystem, seen = seen_above(above, model.effects, model.fit)
    told = final_fit(above.on_every_row(subsystem), seen.z, block)
    return in_two_steps(problem, model.fit.z, block, told)


def _before(selection: Selection, model: Model, last: FinalFit) -> Fit:
    """Return the fit of the declared model alone: to the very end where nothing is added to it."""
    return selection.root.fit if model.effects else last.fit


def _is_none(last: FinalFit, name: str) -> bool:
    """Tell whether the fit to the very end puts all sizes of an effect back to none."""
    own = EFFECTS[name].knobs if name in EFFECTS else ()
    sizes = {knob.parameter for knob in own if not knob.shape}
    return bool(sizes) and not any(z for free, z in zip(last.problem.freedoms, last.fit.z)
                                   if free.knob.parameter in sizes)


def _unnamed(model: Model) -> bool:
    return bool(model.effects) and model.effects[0].startswith(UNNAMED)


def _diagnosis(task: Task, selection: Selection, chosen: Model, after: FinalFit,
               runs: Runs, refused: Refused | None, notes: tuple[str, ...]) -> Diagnosis:
    experiment = task.experiment
    size = len(experiment.time)
    test = rows_of(task.segments, 'test', size)
    before = _before(selection, chosen, after).parameters
    errors, held_out = (errors_of(experiment, runs, rows) for rows in (
        rows_of(task.segments, 'train', size), test))
    unknown = after.fit.parameters.discrepancy if _unnamed(chosen) else None
    decided, suspect = refused is not None, selection.chosen
    if not chosen.effects and refused is None and chosen.reduced_chi2 > LARGE:
        refused, suspect = _pointed_at(selection)
    verdict = 'effect' if chosen.effects else 'none'
    effects: tuple[FoundEffect, ...] = ()
    if unknown is not None:
        verdict, place = 'unknown', place_of(unknown.location)
        effects = (_nameless(place, selection, chosen, held_out),)
    elif chosen.effects:
        effects = tuple(_found(task, selection, chosen, after, held_out, name)
                        for name in chosen.effects)
    elif refused is not None:  # what the term was made for is there all the same
        verdict, effects = 'unknown', (_nameless(
            refused.location, selection, suspect, held_out),)
    # where the record is not met, what is missing would pass for left open
    told = all(one.met for one in errors.values() if np.isfinite(one.after))
    models = models_alike(after) if told else None
    return Diagnosis(
        verdict, effects, unknown, errors,
        with_left_open(held_out, experiment, runs['after'], models, test),
        _suspects(selection, chosen), _refitted(task, before, after), task.declared,
        before, after.fit.parameters, experiment, tuple(task.segments), runs, notes,
        refused=refused, start=after.fit.initial, decided=decided, alike=models,
        trace=selection.trace)


def _pointed_at(selection: Selection) -> tuple[Refused | None, Model]:
    """Return the term that comes nearest to what is missing, though too little speaks for it."""
    terms = [one for one in selection.models if _unnamed(one)]
    if not terms:
        return None, selection.chosen
    nearest = min(terms, key=lambda one: one.reduced_chi2)
    table = nearest.fit.parameters.discrepancy
    return Refused(place_of(table.location), VARIABLES[table.variable], None, 0.0), nearest


def _suspects(selection: Selection, chosen: Model) -> tuple[Suspect, ...]:
    """Return the models that were fitted, each once, by what they leave, with what became of it."""
    outcome = {step.effects: step.outcome for step in selection.trace}
    outcome = {effects: 'not told apart from the choice' if words == 'accepted' else words
               for effects, words in outcome.items()}
    outcome |= {(): 'the declared model, refitted', chosen.effects: 'chosen'}
    best: dict[frozenset[str], Suspect] = {}
    for one in sorted(selection.models, key=lambda one: one.reduced_chi2):
        best.setdefault(frozenset(one.effects), Suspect(
            one.effects, one.reduced_chi2,
            outcome.get(one.effects, 'less evidence than another of its round')))
    return tuple(best.values())


def _found(task: Task, selection: Selection, chosen: Model, after: FinalFit,
           held_out: dict[str, ChannelError], name: str) -> FoundEffect:
    effect = EFFECTS[name]
    own = {knob.parameter for knob in effect.knobs}
    parameters, cornered = {}, False
    for index, free in enumerate(after.problem.freedoms):
        if free.knob.parameter in own:
            parameters[free.knob.parameter] = interval_of(
                after.problem, after.draws, after.fit, index)
            cornered |= not free.knob.shape and at_bound(free, after.fit.z[index])
    without = _without(selection, chosen, name)
    share = min(max(explained(chosen, selection.root) - explained(without, selection.root), 0.0),
                1.0)
    return FoundEffect(
        name, effect.location, parameters, alike(task, selection, chosen, name),
        effect.separating_experiment,
        _evidence(chosen, without, comparison(task, chosen, without, [])),
        standing(share, chosen.reduced_chi2, cornered, stands(held_out),
                 beside=len(chosen.effects) > 1), share)


def _evidence(chosen: Model, without: Model, said: Comparison) -> dict[str, float]:
    """Return the figures on which a finding rests."""
    return {'misfit_without': without.reduced_chi2, 'misfit_with': chosen.reduced_chi2,
            **said.figures()}


def _without(selection: Selection, chosen: Model, name: str) -> Model:
    """Return the best model that was fitted with no effects beyond the others of the choice."""
    rest = set(chosen.but(name))
    return min((one for one in selection.models if set(one.effects) <= rest),
               key=lambda one: one.reduced_chi2)


def _nameless(place: str, selection: Selection, term: Model, held_out: dict[str, ChannelError]
              ) -> FoundEffect:
    """Return a finding without a name in this place, with the terms that tell of it as well."""
    rivals = tuple(
        one.effects[0].removeprefix(UNNAMED) for one in near_best(
            [one for one in selection.models if _unnamed(one)], TIE) if one is not term)
    share = min(max(explained(term, selection.root), 0.0), 1.0)
    return FoundEffect(
        'unknown', place, {}, rivals, '',
        _evidence(term, selection.root, compare(
            term.score, selection.root.score, term.score.dispersion)),
        standing(share, term.reduced_chi2, False, stands(held_out)), share)


def _refitted(task: Task, before: PositionerParameters, after: FinalFit) -> tuple[Refitted, ...]:
    rows = []
    for j, free in enumerate(task.freedoms):
        name, element = free.knob.parameter, free.element
        looser = after.problem.freedoms[j]  # its prior may be looser beside an effect
        z = looser.variable(get(after.fit.parameters, name, element))
        at_limit = at_bound(looser, z)
        low = high = np.nan
        if not at_limit:
            interval = interval_of(after.problem, after.draws, after.fit, j)
            low, high = interval.low, interval.high
        width = abs(looser.variable(high) - looser.variable(low)) / (2.0 * 1.96 * looser.sigma)
        given, first, last = (get(p, name, element) for p in (
            task.declared, before, after.fit.parameters))
        rows.append(Refitted(
            label(free), DESCRIPTIONS[name].unit, given, first, last, looser.spread,
            free.away(free.variable(first)), looser.away(z), at_limit, low, high, width))
    return tuple(rows)
