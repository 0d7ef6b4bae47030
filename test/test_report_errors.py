# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a report says of what the models miss, and of what speaks against the choice."""

from dataclasses import replace

from made_diagnosis import friction_found, friction_judged, off_by
import numpy as np
import pytest

from booster_ros.report.wording import verdict_sentences


def test_what_an_effect_leaves_above_the_noise_is_said_and_only_that():
    diagnosis = friction_found()

    def said(share):
        errors = {name: replace(error, after=error.noise) for name, error in
                  diagnosis.held_out.items()}
        pressure = errors['chamber_pressure']
        errors['chamber_pressure'] = replace(pressure, after=share * pressure.noise)
        return [one for one in verdict_sentences(replace(diagnosis, held_out=errors))
                if 'not explained' in one]

    assert said(1.2) == []
    assert said(4.0) == [
        'It leaves 4.0 times the noise in chamber pressure: that is not explained.']


def with_open(diagnosis, part, left_open, beyond, channel=None):
    """Return the diagnosis with so much, in noises, left open and missed beyond that in a part."""
    return replace(diagnosis, **{part: {
        name: replace(error, left_open=left_open * error.noise, unforeseen=beyond * error.noise)
        if channel in (None, name) else error
        for name, error in getattr(diagnosis, part).items()}})


def test_what_the_record_leaves_open_need_be_no_sign_of_anything_missing():
    diagnosis = off_by(friction_judged(), 'validation', 9.0, 1.0)
    left = off_by(diagnosis, 'held_out', 9.0, 2.0)
    unexplained = ('It leaves 2.0 times the noise in chamber pressure and 2.0 times the noise in '
                   'valve position: that is not explained.')
    need_be = ('What is left in chamber pressure and valve position need be no sign of anything '
               'missing: models that meet the fitted part of this record as well differ from this '
               'one there by 1.5 times the noise in chamber pressure and 1.5 times the noise in '
               'valve position.')

    def said(found):
        return [one for one in verdict_sentences(found) if 'no sign of' in one
                or 'not explained' in one or 'hardly told' in one]

    assert said(left) == said(with_open(left, 'held_out', 0.4, 2.0)) == [unexplained]
    assert said(with_open(left, 'held_out', 1.5, 1.0)) == [need_be]
    assert said(with_open(left, 'held_out', 1.5, 2.0)) == [
        unexplained,
        'Of what is left in chamber pressure and valve position a part may come of parameters '
        'that are hardly told: models that meet the fitted part of this record as well differ from '
        'this one there by 1.5 times the noise in chamber pressure and 1.5 times the noise in '
        'valve position.']
    one = said(with_open(left, 'held_out', 1.5, 1.0, 'valve_position'))
    assert one[0] == 'It leaves 2.0 times the noise in chamber pressure: that is not explained.'
    assert one[1].startswith('What is left in valve position need be no sign')
    assert said(with_open(off_by(left, 'held_out', 9.0, 1.2), 'held_out', 5.0, 1.0)) == []


def test_of_the_other_record_it_is_the_first_that_leaves_open_unless_that_speaks_against_it():
    missed = off_by(friction_judged(), 'validation', 9.0, 2.0)
    *_, misses, open_there = verdict_sentences(with_open(missed, 'validation', 1.5, 1.0))
    assert misses.startswith('With it the model misses the other record by 2.0 times the noise')
    assert 'models that meet the first record as well' in open_there
    assert 'no sign of' not in ' '.join(verdict_sentences(missed))
    rises = with_open(off_by(missed, 'validation', 1.5, 2.0), 'validation', 1.5, 1.0)
    assert verdict_sentences(rises)[-1].startswith('There the error rises with it')


@pytest.mark.parametrize('part', ['held_out', 'validation'])
@pytest.mark.parametrize(('before', 'after', 'said'), [
    (10.0, 12.0, 'There the error rises with it in chamber pressure and valve position: trust it '
                 'less.'),
    (10.0, 9.5, 'There as much is missing with it as without: that does not confirm it.'),
    (1.0, 1.2, 'There the error rises with it in chamber pressure and valve position: trust it '
               'less.'),
    (10.0, 2.0, None), (1.0, 1.0, None),
])
def test_what_speaks_against_the_choice_is_said_under_the_headline(part, before, after, said):
    found = verdict_sentences(off_by(friction_judged(), part, before, after))
    assert [one for one in found if one.startswith('There')] == ([said] if said else [])


@pytest.mark.parametrize(('away', 'before', 'said'), [
    (-4.5, 1.02, True), (-4.5, 1.2, False), (2.0, 1.02, False)])
def test_where_a_parameter_far_off_would_do_as_well_that_is_said(away, before, said):
    diagnosis = off_by(off_by(friction_found(), 'held_out', before, 1.0), 'error', 1.0, 1.0)
    gain, bench_set = diagnosis.refitted
    diagnosis = replace(diagnosis, refitted=(gain, replace(
        bench_set, before=147.3e3, away_before=away)))
    assert [one for one in verdict_sentences(diagnosis) if 'if that can be' in one] == [
        'The declared model alone leaves no more than noise in this record, with '
        'actuator.bench_set[0] at 147 kPa instead of 150 kPa (4.5 times its tolerance): if that '
        'can be, nothing is missing.'] * said


def test_only_the_channels_that_speak_against_the_choice_are_named():
    diagnosis = off_by(friction_found(), 'held_out', 10.0, 2.0)
    rises = off_by(diagnosis, 'held_out', 10.0, 12.0, 'valve_position')
    assert 'There the error rises with it in valve position: trust it less.' in verdict_sentences(
        rises)
    same = off_by(diagnosis, 'held_out', 10.0, 10.0, 'valve_position')
    assert not any(one.startswith('There') for one in verdict_sentences(same))


def test_data_that_need_nothing_added_do_not_confirm_what_was():
    diagnosis = friction_found()
    assert any(one.startswith('With it the error falls') for one in verdict_sentences(diagnosis))
    text = ' '.join(verdict_sentences(off_by(diagnosis, 'held_out', 1.2, 1.0)))
    assert 'need nothing added, and so do not confirm it: there the error goes' in text
    assert 'With it the error' not in text
    one_needs = off_by(off_by(diagnosis, 'held_out', 1.2, 1.0), 'held_out', 4.0, 1.0,
                       'valve_position')
    assert 'With it the error falls' in ' '.join(verdict_sentences(one_needs))


def test_how_the_choice_does_on_the_other_record_is_said_under_the_headline():
    diagnosis = friction_judged()

    def said(before, after):
        sentences = verdict_sentences(off_by(diagnosis, 'validation', before, after))
        return [one for one in sentences if 'the other record' in one]

    meets = 'With it the model meets chamber pressure and valve position of the other record'
    assert said(10.0, 1.2) == [f'{meets}.']
    assert said(1.2, 1.0) == [f'{meets}, which needs nothing added.']
    assert said(20.0, 4.0) == [
        'With it the model misses the other record by 4.0 times the noise in chamber pressure (20 '
        'without it) and 4.0 times the noise in valve position (20 without it).']
    assert not any('other record' in one for one in verdict_sentences(friction_found()))


@pytest.mark.parametrize(('left', 'said'), [(3, True), (200, False)])
def test_a_test_set_of_few_values_is_said_to_be_that(left, said):
    found = friction_found()
    first = next(one.first for one in found.segments if one.role == 'test')
    rows = np.arange(len(found.experiment.time)) < first + left
    measured = {name: np.where(rows, values, np.nan)
                for name, values in found.experiment.measured.items()}
    found = replace(found, experiment=replace(found.experiment, measured=measured))
    words = ', of which there are 3 in a channel at the most'
    assert any(words in sentence for sentence in verdict_sentences(found)) is said
