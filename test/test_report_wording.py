# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The sentences of a verdict claim no more than its errors bear out."""

from dataclasses import replace

from made_diagnosis import STICKING, friction_found, judged_on, nothing_found, off_by, timed_columns
from made_report import FROM, Page
import numpy as np
import pytest

from booster_ros.diagnosis.result import ChannelError
from booster_ros.report.html_report import html_page
from booster_ros.report.wording import verdict_sentences, verdict_title


def test_the_declared_model_is_enough_only_if_the_other_record_says_so_too():
    enough = 'The declared model, refitted, is enough for this record'
    clean = judged_on(timed_columns(seed=2), nothing_found())
    assert verdict_title(nothing_found()) == verdict_title(clean) == enough
    assert verdict_sentences(clean)[-1] == (
        'The refitted model meets chamber pressure and valve position of the other record.')
    sticks = judged_on(timed_columns(STICKING, seed=2), nothing_found())
    sticks.validation['mass_flow'] = ChannelError('kg/s', *[float('nan')] * 3, 1e-6)
    assert verdict_title(sticks) == 'Nothing to add'
    last = verdict_sentences(sticks)[-1]
    assert last.startswith('The refitted model misses the other record by ')
    assert last.endswith('times the noise in valve position: something is missing there that this '
                         'record does not show.')
    assert 'mass flow' not in last
    unsure = replace(sticks, validation={
        name: replace(error, left_open=error.after, unforeseen=error.noise)
        for name, error in sticks.validation.items()})
    assert verdict_title(unsure) == (
        'Nothing to add, but this record leaves a part of the model open')
    assert 'this record does not show' not in ' '.join(verdict_sentences(unsure))
    worse = off_by(sticks, 'held_out', 3.0, 3.0)
    assert 'this record does not show' not in verdict_sentences(worse)[-1]


def test_none_short_of_the_noise_does_not_claim_that_the_model_is_enough():
    diagnosis = nothing_found()
    worse = {name: replace(error, before=3.0 * error.noise, after=3.0 * error.noise)
             for name, error in diagnosis.held_out.items()}
    text = ' '.join([verdict_title(diagnosis), *verdict_sentences(diagnosis)])
    assert 'enough' in text
    diagnosis = replace(diagnosis, held_out=worse)
    text = ' '.join([verdict_title(diagnosis), *verdict_sentences(diagnosis)])
    assert 'enough' not in text
    assert 'more than noise' in text


def test_the_headline_says_so_where_far_more_than_noise_is_left_that_nothing_leaves_open():
    lacks = 'The model lacks stem friction'
    found = friction_found()
    assert verdict_title(found) == verdict_title(off_by(found, 'held_out', 40.0, 2.9)) == lacks
    much = off_by(found, 'held_out', 40.0, 3.1, 'valve_position')
    assert verdict_title(much) == f'{lacks}, and more than that'
    for unforeseen, more in ((2.9, False), (3.1, True)):
        left_open = replace(much, held_out={
            name: replace(error, after=5.0 * error.noise, left_open=4.0 * error.noise,
                          unforeseen=unforeseen * error.noise)
            for name, error in much.held_out.items()})
        assert verdict_title(left_open).endswith(', and more than that') == more


def test_a_test_set_missed_by_what_the_record_leaves_open_calls_for_nothing():
    diagnosis = off_by(nothing_found(), 'held_out', 3.0, 3.0)
    diagnosis = replace(diagnosis, held_out={
        name: replace(error, left_open=2.0 * error.noise, unforeseen=1.1 * error.noise)
        for name, error in diagnosis.held_out.items()})
    text = ' '.join([verdict_title(diagnosis), *verdict_sentences(diagnosis)])
    assert 'this record leaves a part of the model open' in text
    assert 'need be no sign of anything missing: models that meet the fitted part' in text
    assert 'more than noise' not in text
    more = replace(diagnosis, held_out={name: replace(error, unforeseen=error.after)
                                        for name, error in diagnosis.held_out.items()})
    text = ' '.join([verdict_title(more), *verdict_sentences(more)])
    assert 'leaves a part of the model open' not in text
    assert 'more than noise' in text
    assert 'a part may come of parameters that are hardly told' in text


def test_what_only_the_test_set_shows_is_not_said_to_have_been_sought():
    """Data that were fitted to the noise call for nothing, so nothing was tried on the others."""
    diagnosis = nothing_found()
    diagnosis = replace(diagnosis, held_out={
        name: replace(error, before=3.0 * error.noise, after=3.0 * error.noise)
        for name, error in diagnosis.held_out.items()})
    text = ' '.join(verdict_sentences(diagnosis))
    assert 'shows in the unseen ones alone' in text
    assert 'no smooth term' not in text


def test_a_test_set_that_is_met_is_not_all_of_the_record():
    found = off_by(nothing_found(), 'error', 5.0, 5.0)
    assert verdict_title(found) == 'Nothing to add'
    text = ' '.join(verdict_sentences(found))
    assert 'Of the data that were fitted it leaves 5.0 times the noise in chamber pressure' in text
    assert 'No effect of the catalogue improves on that' not in text
    other = off_by(replace(found, validation=found.held_out), 'validation', 4.0, 4.0)
    assert 'this record does not show' not in verdict_sentences(other)[-1]


def test_loud_noise_under_which_nothing_was_found_is_said_to_hide_what_is_smaller():
    assert 'may be there all the same' not in ' '.join(verdict_sentences(nothing_found()))
    quiet = nothing_found()
    position = quiet.experiment.measured['valve_position']
    loud = 0.2 * float(np.nanmax(position) - np.nanmin(position))
    noisy = {**quiet.held_out, 'valve_position': ChannelError('m', loud, loud, loud, loud)}
    text = ' '.join(verdict_sentences(replace(quiet, held_out=noisy)))
    assert 'The noise of the valve position is 20 % of its range' in text
    assert 'noise of the chamber pressure' not in text


@pytest.mark.parametrize('decided', [True, False])
def test_a_test_set_that_had_a_say_is_not_said_to_be_unseen(decided):
    diagnosis = replace(friction_found(), decided=decided)
    page = Page(html_page(diagnosis, FROM))
    assert ('had a say in the verdict' in page.text) is decided
    assert ('no step has seen these data' in page.text) is not decided
    assert ('no step of this analysis had seen' in page.text) is not decided


def test_what_two_effects_explain_only_together_is_said_of_each():
    found = friction_found()
    alone = replace(found.effects[0], explained=0.812, standing='likely')
    one = verdict_sentences(replace(found, effects=(alone,)))
    assert 'Explained: 81.2 % of what the declared model misses (likely).' in one
    leak = replace(alone, name='chamber_leak', location='chamber', standing='confirmed')
    both = verdict_sentences(replace(found, effects=(leak, alone)))
    assert ('Explained: 81.2 % of what the declared model misses only with chamber leak '
            '(confirmed) and 81.2 % only with stem friction (likely).') in both
