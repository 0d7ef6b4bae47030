# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""`report.html`: one self-contained page that a plant engineer understands in a minute."""

from html import escape
import math
from pathlib import PurePath

import numpy as np

from booster_ros.diagnosis.data.experiment import COMMANDS, Experiment
from booster_ros.diagnosis.prepare.timing import commands_may_be_late
from booster_ros.diagnosis.result import Diagnosis, FoundEffect
from booster_ros.report import figures, interactive
from booster_ros.report.engineering import number, scale_of, si_text
from booster_ros.report.explanation import best_explanation, explained_share
from booster_ros.report.figure_style import styled, svg
from booster_ros.report.markup import bullets, figure, paragraph, section
from booster_ros.report.provenance import Provenance
from booster_ros.report.tables import (
    declared_table, effect_table, error_table, shown_suspects, suspect_table)
from booster_ros.report.templating import plot, plot_library, rendered
from booster_ros.report.tones import ROLE_SHADES
from booster_ros.report.view import VARIABLES, View
from booster_ros.report.errors import scored
from booster_ros.report.names import (
    capital, channel_label, effect_label, listing, place_label, positive_is)
from booster_ros.report.notes import either, notes
from booster_ros.report.unknown_term import unknown_experiment, unknown_of, unknown_rivals
from booster_ros.report.wording import (
    SCALING, verdict_sentences, verdict_title, with_what_was_added)

_ROLES = {
    'train': 'training: fitted, and chose between models',
    'test': 'test set: opened once, at the end'}

_STAGE_MEANINGS = {
    'declared': 'As declared: the model with the parameters that were given.',
    'before': 'Refitted: the same model, its parameters moved within their tolerances.',
    'after': 'Last: refitted together with what was added.'}


def html_page(diagnosis: Diagnosis, provenance: Provenance) -> str:
    """Return the page as HTML text."""
    view = View(diagnosis)
    with styled():
        sections = [
            _errors(view), _curves(view), _residuals(view), _signature(view), _unknown(view),
            _effects(diagnosis), _undecided(diagnosis), _suspects(diagnosis), _declared(view),
            _record(view, provenance)]
    validation = f', judged on {provenance.validation}' if provenance.validation else ''
    headline = verdict_title(diagnosis)
    return rendered(
        'page.html', title=f'{PurePath(provenance.record).name}: {headline}',
        source=f'{provenance.record} explained by {provenance.parameters}{validation}',
        verdict=diagnosis.verdict, headline=headline,
        sentences=[paragraph(text) for text in verdict_sentences(diagnosis)],
        sections=[text for text in sections if text], library=plot_library())


def _stages(diagnosis: Diagnosis) -> dict[str, str]:
    """Return the models whose errors are shown, and words for them."""
    stages = {'declared': 'as declared', 'before': 'refitted'}
    if diagnosis.added:
        stages['after'] = with_what_was_added(diagnosis)
    return stages


def _errors(view: View) -> str:
    diagnosis = view.diagnosis
    held_out = 'held out: nothing was fitted to them, but they had a say in the verdict' \
        if diagnosis.decided else 'held out: no step has seen these data'
    parts = {
        held_out: scored(diagnosis.held_out),
        'validation record': scored(diagnosis.validation),
        'data used for the analysis': scored(diagnosis.error),
    }
    parts = {words: errors for words, errors in parts.items() if errors}
    short = {held_out: 'held out', 'validation record': 'validation',
             'data used for the analysis': 'used data'}
    rows = [(f'{channel_label(name)}\n{short[words]}', error)
            for words, errors in parts.items() for name, error in errors.items()]
    stages = _stages(diagnosis)
    drawing = svg(figures.error_ladder(rows, stages), 'errors') if rows else ''
    return section(
        'How far off, before and after',
        paragraph(' '.join(_STAGE_MEANINGS[stage] for stage in stages), 'hint'),
        figure(drawing, 'Errors of each model as multiples of the noise') if drawing else '',
        error_table(parts, stages))


def _curves(view: View) -> str:
    if view.diagnosis.experiment.quasi_static:
        return section(
            'Measured and model',
            paragraph('A sweep without time: each row stood until everything had settled. '
                      'Open points were held out.', 'hint'),
            plot(interactive.sweep(view), 'sweep',
                 'Sweep, measured and by both models'))
    keys = ''.join(
        f'<span><i class="key" style="background:{shade}"></i>{_ROLES[role]}</span>'
        for role, shade in ROLE_SHADES.items())
    return section(
        'Measured and model',
        f'<p class="hint keys">Strip on top: {keys}</p>',
        plot(interactive.measured_and_models(view), 'curves',
             'Measured signals and both models over time'))


def _residuals(view: View) -> str:
    variables = {}
    sentences = []
    worse, better = view.stages
    for name in view.channels:
        variable = _explaining(view, name)
        if variable is None:
            continue
        variables[name] = variable
        before, after = (explained_share(view.residual(stage, name), view.states[variable])
                         for stage in (worse, better))
        sentences.append(
            f'of the {channel_label(name)} residual the {channel_label(variable)} explains '
            f'{_percent(before)} of the variance before and {_percent(after)} after')
    content = []
    if not view.diagnosis.experiment.quasi_static:
        content.append(plot(interactive.residuals_over_time(view), 'residuals',
                            'Residuals of both models over time'))
    if variables:
        content += [
            '<h3>Against the variable that explains it best</h3>',
            paragraph(f'{capital("; ".join(sentences))}. The line is the mean of the points.',
                      'hint'),
            plot(interactive.residuals_over_variable(view, variables), 'explained',
                 'Residuals of both models over the variable that explains them best')]
    elif (unknown := unknown_of(view.diagnosis)) is not None and unknown.variable == 'time':
        content.append(paragraph('It follows the time, over which it is drawn.', 'hint'))
    else:
        content.append(paragraph('No single variable explains a tenth of it.', 'hint'))
    return section('What the model misses', *content)


def _percent(part: float) -> str:
    if not math.isfinite(part):
        return 'nothing'
    return f'{100.0 * part:.0f} %' if part >= 0.01 else 'less than 1 %'


def _explaining(view: View, name: str) -> str | None:
    """Return the unnamed term's variable, or the one over which the residual is clearest."""
    unknown = unknown_of(view.diagnosis)
    if unknown is not None and unknown.variable != 'time':
        return unknown.variable
    states = {variable: view.states[variable] for variable in VARIABLES}
    if view.diagnosis.experiment.quasi_static:
        # a sweep has been shown over its driver already, and nothing in it has a velocity
        states = {v: x for v, x in states.items() if v not in (view.driver, 'stem_velocity')}
    found = best_explanation(view.residual(view.stages[0], name), states)
    return found.variable if found else None


def _signature(view: View) -> str:
    if not figures.has_signature(view) or view.diagnosis.experiment.quasi_static:
        return ''
    return section(
        'Valve signature',
        paragraph('Position over chamber pressure. Two parallel lines are friction of the stem, or '
                  'lost motion of the position sensor. Of friction their distance in pressure '
                  'times the diaphragm area is twice the force.', 'hint'),
        figure(svg(figures.valve_signature(view), 'signature'),
               'Position over pressure, measured and by both models'))


def _unknown(view: View) -> str:
    term = unknown_of(view.diagnosis)
    if term is None:
        return ''
    over, size = scale_of(term.variable_unit), scale_of(term.unit)
    first, last = term.seen
    seen, seen_si = (f'{words(first)} to {words(last)}' for words in (
        over.text, lambda value: si_text(value, term.variable_unit)))
    unit = f', in {size.unit}' if size.unit else ''
    also = '' if seen == seen_si else f' ({seen_si})'
    beyond = ('Dotted: beyond, where nothing was seen, it fades to zero, no more steeply than it '
              'runs.')
    if term.reach is not None:
        beyond = 'At its ends the force takes what it moves along, and nothing is beyond.'
    return section(
        'The term without a name',
        paragraph(
            f'Added in {place_label(term.location)}{unit} (positive: '
            f'{positive_is(term.location)}), as a function of the '
            f'{channel_label(term.variable)} from {seen}{also}. {beyond} Below it: how many rows '
            'of the record were where. Where there are few, the table says little.'),
        figure(svg(figures.unknown_term(view, term), 'unknown'), 'The table of the unnamed term'))


def _effects(diagnosis: Diagnosis) -> str:
    named = [effect for effect in diagnosis.effects if effect.parameters]
    if not named:
        return ''
    content = []
    for effect in named:
        content += [
            f'<h3>{escape(effect_label(effect.name))}, in '
            f'{escape(place_label(effect.location))}</h3>',
            effect_table(effect), *map(paragraph, filter(None, [either(effect)])),
            _evidence(effect)]
    return section('What was added', *content)


def _evidence(effect: FoundEffect) -> str:
    facts = effect.evidence
    if not {'misfit_without', 'misfit_with'} <= facts.keys():
        return ''
    text = (f'{capital(effect.standing)}. Without it the mean squared error of the training blocks '
            f'is {number(facts["misfit_without"])} times that of the noise, with it '
            f'{number(facts["misfit_with"])} times.')
    if 'log_evidence' in facts:
        text += (f' The logarithm of the evidence rises by {number(facts["log_evidence"])}, that '
                 f'of the likelihood by {number(facts["gain"])} ± '
                 f'{number(facts["gain_standard_error"])} (standard error over blocks).')
    if facts.get('luck'):
        text += (f' Chance alone changes it by {number(facts["luck"])}, as in a loop that ends in '
                 'its dead zone on one side or the other: so much more had to be gained.')
    return paragraph(text)


def _undecided(diagnosis: Diagnosis) -> str:
    items = []
    for effect in diagnosis.effects if diagnosis.added else ():
        rivals = listing([effect_label(name) for name in effect.confused_with], 'or')
        if (unknown := unknown_of(diagnosis)) is not None:
            items.append(' '.join([
                *unknown_rivals(diagnosis),
                f'To find its cause: {unknown_experiment(unknown)}.']))
        elif effect.confused_with:
            items.append(f'{capital(effect_label(effect.name))} or {rivals}? This record '
                         f'cannot decide. It would take: {effect.separating_experiment}.')
        else:
            items.append(f'{capital(effect_label(effect.name))}: no other effect explains as '
                         'much of the record. An experiment that would confirm it: '
                         f'{effect.separating_experiment}.')
    return section('What it may be instead, and how to find out', bullets(items)) if items else ''


def _suspects(diagnosis: Diagnosis) -> str:
    hidden = len(diagnosis.suspects) - len(shown_suspects(diagnosis))
    return section(
        'Suspects',
        paragraph('The choice, then all by misfit: mean squared error of the training blocks, in '
                  'squares of the noise. 1 is as good as can be. Bars are logarithmic.', 'hint'),
        suspect_table(diagnosis),
        paragraph(f'{hidden} more {"is" if hidden == 1 else "are"} in report.json.', 'hint')
        if hidden > 0 else '')


def _declared(view: View) -> str:
    diagnosis = view.diagnosis
    stages = {stage: words for stage, words in _stages(diagnosis).items() if stage != 'declared'}
    return section(
        'The declared parameters',
        paragraph('A parameter that is a little off is not a missing effect, so all were refitted '
                  'first. σ is the tolerance within which each was expected, and no refit goes '
                  'farther than five of them. The interval is of the last value, as far as the '
                  'record tells it.', 'hint'),
        declared_table(diagnosis.refitted, stages), paragraph(SCALING, 'hint'))


def _record(view: View, provenance: Provenance) -> str:
    experiment, diagnosis = view.diagnosis.experiment, view.diagnosis
    drives = listing([_drive(name) for name in experiment.drives]) or (
        'nothing: the chamber is shut off, as declared')
    compared = listing([channel_label(name) for name in experiment.channels])
    noise = listing([f'{scale_of(diagnosis.error[name].unit).text(level, 2)} in '
                     f'{channel_label(name)}' for name, level in experiment.noise.items()])
    rows = len(experiment.time)
    span = float(experiment.time[-1] - experiment.time[0])
    length = f'{rows} rows of a sweep without time' if experiment.quasi_static else (
        f'{rows} rows over {number(span)} s, one every {_period_text(experiment.time)}')
    facts = [
        f'{provenance.record}: {length}.',
        f'Driven by {drives}; compared: {compared}.',
        f'Noise, {_source_of_noise(experiment)}: {noise}.',
        _split(view),
    ]
    said = notes(diagnosis) or ('Nothing was dropped or mended.',)
    return section('The record', bullets(facts),
                   '<h3>What was dropped, mended or assumed</h3>', bullets(said))


def _drive(name: str) -> str:
    """Return the words for a drive: a command is what was asked for, the others were measured."""
    return f'the {"" if name in COMMANDS else "measured "}{channel_label(name)}'


def _source_of_noise(experiment: Experiment) -> str:
    causes = [words for words, present in (
        ('noise of the measured drives', experiment.drive_noise),
        ('commands late by part of a row', commands_may_be_late(experiment))) if present]
    if not causes:
        return 'from the record alone'
    return f'from the record, and from what {listing(causes)} would do to the declared model'


def _period_text(time: np.ndarray) -> str:
    period = float(np.median(np.diff(time)))
    return f'{number(1e3 * period)} ms' if period < 1.0 else f'{number(period)} s'


def _split(view: View) -> str:
    counts = []
    for role, words in _ROLES.items():
        parts = [s for s in view.diagnosis.segments if s.role == role]
        rows = sum(s.last - s.first for s in parts)
        counts.append(f'{len(parts)} segments ({rows} rows) {words}')
    return f'Split by whole segments: {"; ".join(counts)}.'
