# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the report says, checked against the diagnosis it was made from."""

from dataclasses import replace
from html.parser import HTMLParser
import json
import re

from made_diagnosis import (
    BENT,
    FRICTION,
    STICKING,
    diagnosis_of,
    friction_found,
    friction_found_in_a_sweep,
    friction_judged,
    judged_on,
    nothing_found,
    refused_found,
    swept_columns,
    timed_columns,
    unknown_found,
)
import numpy as np
import pytest

from booster_ros.diagnosis.result import (
    Change,
    ChannelError,
    FoundEffect,
    Interval,
    Moved,
    Refitted,
    Suspect,
    UnknownTerm,
)
from booster_ros.model import discrepancy
from booster_ros.model.parameters import from_values
from booster_ros.parameters.file import read_parameter_file
from booster_ros.report.engineering import digits_apart, number, scale_of, si_text, side_by_side
from booster_ros.report.explanation import best_explanation, explained_share
from booster_ros.report.figure_style import envelope, over_time
from booster_ros.report.html_report import html_page
from booster_ros.report.json_report import json_text
from booster_ros.report.parameter_files import write_parameter_files
from booster_ros.report.provenance import Provenance
from booster_ros.report.tables import declared_table, effect_table
from booster_ros.report.view import View
from booster_ros.report.errors import error_scale
from booster_ros.report.wording import verdict_sentences, verdict_title

FROM = Provenance('plant.csv', 'declared.yaml')
JUDGED = Provenance('plant.csv', 'declared.yaml', 'other.csv')
VOID = {'meta', 'link', 'br', 'img', 'input', 'hr'}


class Page(HTMLParser):
    """A page taken apart: its texts, ids and what it refers to; fails where tags do not match."""

    def __init__(self, text):
        super().__init__()
        self.open, self.texts, self.ids, self.references, self.tags = [], [], [], [], []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        for name, value in attributes:
            if name == 'id':
                self.ids.append(value)
            if name in ('href', 'src', 'xlink:href'):
                self.references.append(value)
            self.references += re.findall(r'url\(([^)]*)\)', value or '')
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.handle_starttag(tag, attributes)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] != 'style':
            self.texts.append(' '.join(data.split()))

    @property
    def text(self):
        return ' '.join(filter(None, self.texts))


MADE = {
    'effect': friction_found,
    'judged': friction_judged,
    'none': nothing_found,
    'unknown': unknown_found,
    'sweep': friction_found_in_a_sweep,
    'pressure only': lambda: without('valve_position'),
    'position only': lambda: without('chamber_pressure'),
}


def without(column):
    """Return a diagnosis of a record that lacks a column."""
    columns = timed_columns(STICKING)
    del columns[column]
    return diagnosis_of(columns, 'effect', STICKING, (FRICTION,))


@pytest.fixture(scope='module', params=MADE)
def made(request):
    """Return a diagnosis and its page."""
    diagnosis = MADE[request.param]()
    return diagnosis, html_page(diagnosis, FROM)


def test_a_page_is_whole_self_contained_and_light(made):
    _, text = made
    page = Page(text)
    assert len(page.ids) == len(set(page.ids))
    local = {f'#{name}' for name in page.ids}
    for reference in page.references:
        assert reference in local or reference.startswith('data:image/png;base64,')
    assert not {'script', 'link', 'iframe', 'img'} & set(page.tags)
    assert len(text.encode()) < 1.5e6
    assert not re.search(r'\bnan\b|\binf\b|None', page.text)


def test_a_page_begins_with_the_verdict_and_shows_every_error(made):
    diagnosis, text = made
    page = Page(text)
    assert page.texts.index(verdict_title(diagnosis)) < page.texts.index(
        'How far off, before and after')
    for sentence in verdict_sentences(diagnosis):
        assert sentence in page.text
    stages = ['declared', 'before'] + ['after'] * (diagnosis.verdict != 'none')
    for errors in (diagnosis.error, diagnosis.held_out, diagnosis.validation):
        for error in errors.values():
            for stage in (*stages, 'noise'):
                assert error_scale(error).text(getattr(error, stage)) in page.texts


def test_a_page_shows_the_other_record_where_there_is_one():
    page = Page(html_page(friction_judged(), JUDGED))
    assert 'plant.csv explained by declared.yaml, judged on other.csv' in page.texts
    assert page.texts.count('validation record') == 1  # in the table
    assert page.texts.count('validation') == 2  # in the figure, once for each channel
    alone = Page(html_page(friction_found(), FROM))
    assert 'judged on' not in alone.text
    assert 'validation' not in alone.text


def test_a_page_says_what_was_dropped_how_it_was_split_and_what_scaling_hides(made):
    diagnosis, text = made
    page = Page(text)
    for note in diagnosis.notes:
        assert note in page.text
    for role in ('fit', 'select', 'test'):
        rows = sum(s.last - s.first for s in diagnosis.segments if s.role == role)
        assert f'({rows} rows)' in page.text
    assert 'leaves every pressure and position unchanged' in page.text


def test_the_page_shows_suspects_intervals_and_what_is_not_told_apart():
    page = Page(html_page(friction_found(), FROM))
    assert '41 times the squared error of the choice' in page.texts
    assert '480 to 520 N' in page.texts
    assert 'This record cannot tell stem friction from position backlash.' in page.texts
    assert 'slow triangle with dither' in page.text


@pytest.mark.parametrize(('name', 'shown'), [
    ('effect', True), ('pressure only', False), ('position only', False)])
def test_the_signature_is_shown_where_pressure_and_position_are_known(name, shown):
    assert ('Valve signature' in Page(html_page(MADE[name](), FROM)).texts) == shown


def test_a_sweep_is_not_drawn_over_a_time_that_it_does_not_have():
    page = Page(html_page(friction_found_in_a_sweep(), FROM))
    assert 'time, s' not in page.texts
    assert 'chamber pressure, kPa' in page.texts


def test_rows_of_a_commanded_sweep_are_drawn_over_the_current_that_had_stood():
    current = np.linspace(0.42e-3, 0.46e-3, 30)
    pressure = np.linspace(180e3, 260e3, 30)
    made = diagnosis_of({'control_current': current, 'chamber_pressure': pressure}, 'none')
    view = View(made)
    assert view.driver == 'control_current'
    drawn = view.drive('control_current')
    compared = np.isfinite(made.experiment.measured['chamber_pressure'])
    np.testing.assert_allclose(drawn[compared], 1e3 * current[compared])
    assert np.array_equal(np.isnan(drawn), ~compared)
    assert 'control current, mA' in Page(html_page(made, FROM)).texts


def test_an_unnamed_term_is_shown_with_its_variable_place_and_range():
    diagnosis = unknown_found()
    page = Page(html_page(diagnosis, FROM))
    assert 'something in the stem' in verdict_title(diagnosis)
    # the outermost of twelve knots lie beyond what was seen
    assert 'function of the valve position from 1.45 mm to 14.5 mm' in page.text
    assert 'vary the valve position alone' in page.text


def test_an_unnamed_term_over_time_is_not_to_be_varied():
    diagnosis = unknown_found()
    term = UnknownTerm(diagnosis.unknown.table._replace(variable=discrepancy.TIME))
    page = Page(html_page(replace(diagnosis, unknown=term), FROM))
    assert 'record the same currents again' in page.text
    assert 'vary the time' not in page.text
    elsewhere = 'and the model is the declared one, refitted'
    assert elsewhere in page.text
    assert elsewhere not in Page(html_page(diagnosis, FROM)).text


def unknown_over(table):
    """Return the unknown found with another table in the model."""
    return replace(unknown_found(), after=BENT._replace(discrepancy=table),
                   unknown=UnknownTerm(table))


def test_an_unnamed_term_over_a_change_says_what_it_forgets_and_asks_for_a_step():
    table = BENT.discrepancy._replace(
        variable=discrepancy.POSITION_CHANGE, low=-0.008, high=0.008, memory=12.0)
    diagnosis = unknown_over(table)
    page = Page(html_page(diagnosis, FROM))
    assert 'depends on the recent change of the valve position' in page.text
    assert 'what was is forgotten over 12.0 s' in page.text
    assert 'make one step and let it stand ten times 12.0 s' in page.text
    assert 'recent change of the valve position, mm' in page.texts
    assert json.loads(json_text(diagnosis, FROM))['unknown']['memory'] == 12.0
    assert json.loads(json_text(unknown_found(), FROM))['unknown']['memory'] is None


def test_an_unnamed_term_over_a_play_says_how_wide_it_is_and_asks_for_a_loop():
    values = (0.0, *np.linspace(0.03, 0.026, 10), 0.0)
    table = discrepancy.Discrepancy(
        discrepancy.BOOSTER, discrepancy.FORCE_PLAY, -11.0 / 9.0, 11.0 / 9.0, values, reach=0.018)
    diagnosis = unknown_over(table)
    page = Page(html_page(diagnosis, FROM))
    assert 'through a play 0.0360 N wide' in page.text
    assert '0.0200 N of friction' in page.text
    assert 'chamber pressure over the back pressure is a loop' in page.text
    assert 'place of the booster force in a play' in page.texts
    assert 'nothing is beyond' in page.text
    assert 'Dotted' not in page.text
    assert 'Dotted' in Page(html_page(unknown_found(), FROM)).text
    written = json.loads(json_text(diagnosis, FROM))['unknown']
    assert (written['reach'], written['memory']) == (0.018, None)
    assert written['values'][1:-1] == pytest.approx(np.linspace(0.048, 0.008, 10))
    assert json.loads(json_text(unknown_found(), FROM))['unknown']['reach'] is None


def page_of(columns):
    """Return the text of the page on a record of these columns."""
    return Page(html_page(diagnosis_of(columns, 'none'), FROM)).text


def test_a_page_says_of_a_drive_whether_it_was_measured():
    columns = timed_columns()
    assert 'Driven by the control current; compared' in page_of(columns)
    supply = np.full(len(columns['time']), 400e3)
    assert 'Driven by the control current and the measured supply pressure; compared' in page_of(
        columns | {'supply_pressure': supply})
    assert 'Driven by the measured chamber pressure; compared' in page_of(swept_columns())
    isolated = replace(nothing_found().experiment, current=np.zeros(len(supply)))
    assert 'Driven by nothing: the chamber is shut off, as declared; compared' in Page(
        html_page(replace(nothing_found(), experiment=isolated), FROM)).text


def test_a_page_says_where_the_noise_is_from():
    columns = timed_columns()
    assert 'Noise, from the record alone: ' in page_of(columns)
    late = columns | {'time': columns['time'] + 0.01 * np.random.default_rng(4).random(
        len(columns['time']))}
    assert ('Noise, from the record, and from what commands late by part of a row would do to the '
            'declared model: ') in page_of(late)
    del columns['control_current']
    assert ('Noise, from the record, and from what noise of the measured drives would do to the '
            'declared model: ') in page_of(columns)


def test_two_parallel_lines_may_be_lost_motion_as_well():
    assert ('Two parallel lines are friction of the stem, or lost motion of the position sensor.'
            in page_of(timed_columns()))


def test_a_page_is_the_same_when_made_again():
    diagnosis = friction_found()
    assert html_page(diagnosis, FROM) == html_page(diagnosis, FROM)


def test_a_name_of_a_file_cannot_break_the_page():
    text = html_page(nothing_found(), Provenance('<b>&"$x.csv', 'p$.yaml'))
    assert '<b>&"$x.csv explained by p$.yaml' in Page(text).texts


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


def off_by(diagnosis, part, before, after, name=None):
    """Return the diagnosis with these errors, in noises, in one or every channel of a part."""
    errors = {channel: replace(error, before=before * error.noise, after=after * error.noise)
              if name in (None, channel) else error
              for channel, error in getattr(diagnosis, part).items()}
    return replace(diagnosis, **{part: errors})


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
    worse = off_by(sticks, 'held_out', 3.0, 3.0)
    assert 'this record does not show' not in verdict_sentences(worse)[-1]


def test_a_term_that_did_not_stand_is_said_and_is_in_no_model(tmp_path):
    diagnosis = refused_found()
    assert verdict_title(diagnosis) == 'The model lacks something that no named effect explains'
    said = ' '.join(verdict_sentences(diagnosis))
    assert 'A smooth term in the stem over the valve position' in said
    assert 'that had a say in the verdict speak against it: there the error goes with it in' in said
    assert 'no step of this analysis had seen' not in said
    assert 'It is not in the model' in said
    assert '4 % of these data go beyond the range in which it was seen' in said
    within = replace(diagnosis, refused=replace(diagnosis.refused, beyond=0.0))
    assert 'go beyond' not in ' '.join(verdict_sentences(within))
    assert 'with the unnamed term' not in html_page(diagnosis, FROM)
    values = json.loads(json_text(diagnosis, FROM))
    assert values['unknown'] is None
    assert values['refused']['location'] == 'stem'
    assert values['refused']['beyond'] == 0.04
    write_parameter_files(tmp_path, diagnosis, FROM, {})
    assert 'ADDED' not in (tmp_path / 'positioner.yaml').read_text()


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


def test_what_only_the_locked_part_shows_is_not_said_to_have_been_sought():
    """Data that were fitted to the noise call for nothing, so nothing was tried on the others."""
    diagnosis = nothing_found()
    diagnosis = replace(diagnosis, held_out={
        name: replace(error, before=3.0 * error.noise, after=3.0 * error.noise)
        for name, error in diagnosis.held_out.items()})
    text = ' '.join(verdict_sentences(diagnosis))
    assert 'shows in the unseen ones alone' in text
    assert 'no smooth term' not in text


def test_a_locked_part_that_is_met_is_not_all_of_the_record():
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
def test_a_locked_part_that_had_a_say_is_not_said_to_be_unseen(decided):
    diagnosis = replace(friction_found(), decided=decided)
    page = Page(html_page(diagnosis, FROM))
    assert ('had a say in the verdict' in page.text) is decided
    assert ('no step has seen these data' in page.text) is not decided
    assert ('no step of this analysis had seen' in page.text) is not decided


@pytest.mark.parametrize(('left', 'said'), [(3, True), (200, False)])
def test_a_locked_part_of_few_values_is_said_to_be_that(left, said):
    found = friction_found()
    first = next(one.first for one in found.segments if one.role == 'test')
    rows = np.arange(len(found.experiment.time)) < first + left
    measured = {name: np.where(rows, values, np.nan)
                for name, values in found.experiment.measured.items()}
    found = replace(found, experiment=replace(found.experiment, measured=measured))
    words = ', of which there are 3 in a channel at the most'
    assert any(words in sentence for sentence in verdict_sentences(found)) is said


CHANGE = Change(60.07, 1.01, 2500.0, cut=True)
FALLEN = Moved('supply.pressure', 'Pa', 400e3, 392e3, 1.4)
DRIFTED = Moved('ep_converter.offset', 'Pa', 0.0, 3.6e3, 2.1)


def changed(change, found):
    """Return the diagnosis as one of what came after a change, where it was cut there."""
    begins = change.time if change.cut else 0.0
    return replace(found, change=change, experiment=replace(found.experiment, begins=begins))


def test_when_the_valve_changed_is_said_before_what_is_of_what_came_after():
    found = changed(CHANGE, friction_found())
    first, after, *rest = verdict_sentences(found)
    assert first.startswith('Up to 60.07 s the declared model, refitted to that part, meets')
    assert 'misses by 50 times the noise' in first
    assert after == 'All that follows is of the record from 60.07 s on.'
    assert rest == verdict_sentences(friction_found())
    assert verdict_title(found) == verdict_title(friction_found())
    page = html_page(found, FROM)
    assert page.count('time from 60.07 s on, s') == 2
    assert 'time from' not in html_page(friction_found(), FROM)


@pytest.mark.parametrize(('moved', 'said'), [
    ((FALLEN,), 'supply.pressure from 400 kPa to 392 kPa (1.2 times the noise left).'),
    ((FALLEN, DRIFTED), 'supply.pressure from 400 kPa to 392 kPa (1.2 times the noise left) or '
     'ep_converter.offset from 0 kPa to 3.60 kPa (1.4 times the noise left).'),
    ((replace(FALLEN, left=9.0),), '(3.0 times the noise left); more than one has changed.'),
])
def test_declared_parameters_that_changed_are_told_by_their_values(moved, said):
    effect = FoundEffect('unknown', 'supply', {}, (), '', {})
    found = replace(changed(replace(CHANGE, moved=moved), nothing_found()),
                    verdict='unknown', effects=(effect,))
    assert verdict_title(found) == 'The valve changed at 60.07 s'
    assert verdict_sentences(found)[-1].endswith(said)
    assert Page(html_page(found, FROM)).texts
    written = json.loads(json_text(found, FROM))
    assert written['record']['begins'] == 60.07
    assert [one['name'] for one in written['change']['moved']] == [one.name for one in moved]


def test_of_a_late_clock_and_a_small_change_every_digit_that_counts_is_told():
    change = replace(CHANGE, time=5000166.02, moved=(
        Moved('supply.pressure', 'Pa', 600.3e3, 599.8e3, 1.4),))
    effect = FoundEffect('unknown', 'supply', {}, (), '', {})
    found = replace(changed(change, nothing_found()), verdict='unknown', effects=(effect,))
    assert verdict_title(found) == 'The valve changed at 5000166.02 s'
    assert 'from 600.3 kPa to 599.8 kPa' in verdict_sentences(found)[-1]
    assert 'time from 5000166.02 s on, s' in html_page(found, FROM)


def test_a_number_that_json_has_no_word_for_is_null_wherever_it_stands():
    lost = replace(FALLEN, left=float('nan'))
    found = changed(replace(CHANGE, moved=(lost,)), nothing_found())
    assert json.loads(json_text(found, FROM))['change']['moved'][0]['left'] is None


def test_a_reading_that_stands_still_is_said_to_be_that():
    silent = replace(CHANGE, silent=('valve_position',))
    effect = FoundEffect('unknown', 'sensor', {}, (), '', {})
    found = replace(changed(silent, nothing_found()), verdict='unknown', effects=(effect,))
    assert verdict_title(found) == 'From 60.07 s on the valve position stands still'
    assert 'the sensor is dead or cut off' in ' '.join(verdict_sentences(found))
    assert Page(html_page(found, FROM)).texts
    assert json.loads(json_text(found, FROM))['change']['silent'] == ['valve_position']
    whole = changed(replace(silent, cut=False), friction_found())
    assert verdict_title(whole) == verdict_title(friction_found())
    assert 'the sensor is dead or cut off' in ' '.join(verdict_sentences(whole))


def test_a_change_after_which_nothing_is_told_is_no_claim_that_the_model_is_enough():
    found = changed(replace(CHANGE, cut=False), nothing_found())
    assert verdict_title(found) == 'Something changed at 60.07 s'
    assert 'is of the whole record' in verdict_sentences(found)[1]


def test_residuals_are_drawn_over_the_run_that_is_reported():
    """It begins where the fit found the valve, which is not where its first row reads."""
    made = friction_found()
    start = replace(made.experiment.initial, chamber_pressure=3e5)
    view = View(replace(made, start=start))
    expected = made.experiment.simulate(made.after, start)
    np.testing.assert_array_equal(view.states['chamber_pressure'], expected['chamber_pressure'])
    assert abs(View(made).states['chamber_pressure'][0] - 3e5) > 1e4


def test_what_is_reported_is_among_the_suspects_wherever_it_ranks():
    diagnosis = friction_found()
    better = tuple(Suspect(('stem_friction', f'other_{k}'), 1.0, 'not enough') for k in range(20))
    page = html_page(replace(diagnosis, suspects=(*better, *diagnosis.suspects)), FROM)
    assert 'class="chosen"' in page
    assert 'declared model, refitted</td>' in page


def test_json_holds_what_others_rely_on(made):
    diagnosis, _ = made
    report = json.loads(json_text(diagnosis, FROM))
    assert report['verdict'] == diagnosis.verdict
    for part in ('error', 'held_out', 'validation'):
        for name, error in getattr(diagnosis, part).items():
            assert report[part][name] == {
                'unit': error.unit, 'declared': error.declared, 'before': error.before,
                'after': error.after, 'noise': error.noise}
    for effect, found in zip(report['effects'], diagnosis.effects, strict=True):
        assert effect['name'] == found.name
        assert effect['location'] == found.location
        assert effect['confused_with'] == list(found.confused_with)
        expected = 'vary the valve position alone' if diagnosis.unknown else (
            found.separating_experiment)
        assert effect['separating_experiment'].startswith(expected)
        for name, interval in found.parameters.items():
            assert effect['parameters'][name] == {
                'value': interval.value, 'low': interval.low, 'high': interval.high,
                'unit': interval.unit}
    for one in diagnosis.refitted:
        assert report['declared_parameters'][one.name]['after'] == one.after
        assert report['declared_parameters'][one.name]['at_limit'] is one.at_limit
        assert report['declared_parameters'][one.name]['spread'] == one.spread


def test_declared_parameters_say_how_far_they_were_moved():
    known = Refitted('actuator.stop_stiffness', 'N/m', 5e8, 6e8, 4.5e8, 1.5e8, 0.56, -0.37)
    free = Refitted('booster.opening_gain', 'm^2/N', 2.75e-6, 6.2e-6, 6.2e-6, None, 0.0, 0.0)
    text = declared_table((known, free), {'before': 'refitted', 'after': 'with the effect'})
    assert '+0.6 σ' in text
    assert '−0.4 σ' in text
    assert text.count('free') == 2
    assert text.count('σ') == 2


def test_json_writes_null_for_what_is_no_number():
    diagnosis = replace(nothing_found(), validation={
        'chamber_pressure': ChannelError('Pa', 1.0, float('nan'), float('inf'), 2.0)})
    error = json.loads(json_text(diagnosis, FROM))['validation']['chamber_pressure']
    assert error == {'unit': 'Pa', 'declared': 1.0, 'before': None, 'after': None, 'noise': 2.0}


NODE = {'publish_rate': 50.0, 'start_paused': True, 'step_ticks': 5, 'invalid_current': 'limit',
        'current_limits': (0.0, 0.022), 'initial_state.chamber_pressure': 2e5,
        'initial_state.control_current': 0.012}


def test_the_parameter_files_are_the_models_of_the_diagnosis(tmp_path):
    for diagnosis in (friction_found(), unknown_found()):
        write_parameter_files(tmp_path, diagnosis, FROM, NODE)
        for file, model in (('positioner.yaml', diagnosis.after),
                            ('positioner_before.yaml', diagnosis.before)):
            written = read_parameter_file(tmp_path / file)
            assert from_values(written.physical) == model
            assert written.node == NODE
            assert [type(value) for value in written.node.values()] == [
                type(value) for value in NODE.values()]


def test_the_parameter_file_marks_what_was_added(tmp_path):
    write_parameter_files(tmp_path, friction_found(), FROM, {})
    after = (tmp_path / 'positioner.yaml').read_text()
    assert re.search(r'coulomb_friction: 500\.0 +# N; ADDED: stem_friction, 95 % between', after)
    assert 'ADDED' not in (tmp_path / 'positioner_before.yaml').read_text()


@pytest.mark.parametrize(('value', 'digits', 'text'), [
    (0.0, 3, '0'), (151.26, 3, '151'), (0.99999, 3, '1.00'), (-0.01234, 3, '−0.0123'),
    (123456.7, 4, '123\u202f500'), (2.75e-6, 3, '2.75 × 10⁻⁶'), (5.4034e8, 4, '5.403 × 10⁸'),
    (float('nan'), 3, '–'), (9.996, 3, '10.0'),
])
def test_numbers_have_significant_digits(value, digits, text):
    assert number(value, digits) == text


@pytest.mark.parametrize(('value', 'unit', 'people', 'physics'), [
    (2.703e5, 'Pa', '270 kPa', '270\u202f000 Pa'), (8.1e-6, 'm', '8.10 µm', '8.10 × 10⁻⁶ m'),
    (0.0128, 'm', '12.8 mm', '0.0128 m'), (0.4524e-3, 'A', '0.452 mA', '0.000452 A'),
    (2.75e-6, 'm^2/N', '2.75 mm²/N', '2.75 × 10⁻⁶ m²/N'), (2e7, 'Pa s/kg', '20.0 kPa/(g/s)',
     '2.00 × 10⁷ Pa·s/kg'), (1.3, '-', '1.30', '1.30'), (550.0, 'N', '550 N', '550 N'),
])
def test_units_are_those_of_the_plant_beside_those_of_physics(value, unit, people, physics):
    assert scale_of(unit).text(value) == people
    assert si_text(value, unit) == physics


@pytest.mark.parametrize(('unit', 'values', 'read'), [
    ('m', (5.34e-4, 12e-6, 7.96e-6), ('534 µm', '12.0 µm', '7.96 µm')),
    ('m', (0.0128, 7.96e-6), ('12.8 mm', '7.96 µm')), ('m', (2e-3, 0.0), ('2.00 mm', '0 mm')),
    ('Pa', (5050.0, 149.0), ('5.05 kPa', '0.149 kPa')),
    ('m', (float('nan'),), ('– mm',)),
])
def test_values_that_are_compared_have_one_unit(unit, values, read):
    assert tuple(side_by_side(unit, values).text(value) for value in values) == read


def test_the_ends_of_a_narrow_interval_look_different():
    assert digits_apart(480.0, 520.0) == 3
    assert [number(end, digits_apart(192.97, 193.12)) for end in (192.97, 193.12)] == [
        '193.0', '193.1']
    assert digits_apart(1.0, 1.0) == 3
    assert digits_apart(1.0, 1.0 + 1e-9) == 6


def test_a_short_interval_of_a_length_is_in_one_unit():
    backlash = replace(
        FRICTION, parameters={'sensors.position_backlash': Interval(6e-5, 5e-5, 8e-5, 'm')})
    page = Page(effect_table(backlash))
    assert '50.0 to 80.0 µm' in page.texts


def test_the_variable_that_a_residual_depends_on_is_found():
    rng = np.random.default_rng(3)
    x, y = rng.uniform(-1.0, 1.0, (2, 2000))
    residual = x**2 + 0.1 * rng.standard_normal(2000)
    found = best_explanation(residual, {'x': x, 'y': y, 'constant': np.ones(2000)})
    assert found.variable == 'x'
    # bins cost a little
    assert found.share == pytest.approx(np.var(x**2) / np.var(residual), abs=0.05)
    assert explained_share(residual, y) < 0.05
    assert best_explanation(rng.standard_normal(2000), {'x': x, 'y': y}) is None


@pytest.mark.parametrize('rows', [200, 100_000])
def test_a_line_over_time_is_not_drawn_across_a_gap(rows):
    time = 0.01 * np.arange(float(rows))
    time[rows // 2:] += 50.0
    x, y = over_time(time, np.sin(time))
    here, = np.flatnonzero(np.isnan(y))
    assert x[here - 1] < time[rows // 2 - 1] + 1e-9
    assert x[here] == time[rows // 2] <= x[here + 1]
    assert np.all(np.diff(x) >= 0.0)
    x, y = over_time(0.01 * np.arange(float(rows)), np.sin(time))
    assert np.isfinite(y).all()


def test_a_thinned_line_keeps_its_peaks_and_its_gaps():
    y = np.zeros(100_000)
    y[41_234], y[77_001] = 5.0, -3.0
    y[50_000:60_000] = np.nan
    x, thinned = envelope(np.arange(100_000.0), y)
    assert len(x) < 2000
    assert (np.nanmax(thinned), np.nanmin(thinned)) == (5.0, -3.0)
    assert np.isnan(thinned[(x > 51_000) & (x < 59_000)]).all()
    assert (np.diff(x) >= 0.0).all()
