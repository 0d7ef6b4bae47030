# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The page of a report is whole, and shows what the diagnosis says that it is made from."""

from dataclasses import replace
import re

from made_diagnosis import (
    MADE, diagnosis_of, friction_found, friction_judged, nothing_found, timed_columns)
from made_report import FROM, Page, made_page, undrawn_page
import numpy as np
import pytest

from booster_ros.report.errors import error_scale
from booster_ros.report.html_report import html_page
from booster_ros.report.interactive import measured_and_models, residuals_over_time
from booster_ros.report.provenance import Provenance
from booster_ros.report.templating import plot_library
from booster_ros.report.view import View
from booster_ros.report.wording import verdict_sentences, verdict_title

JUDGED = Provenance('plant.csv', 'declared.yaml', 'other.csv')


@pytest.fixture(scope='module', params=MADE)
def made(request):
    """Return a diagnosis and its page."""
    return MADE[request.param](), made_page(request.param)


def test_a_page_is_whole_self_contained_and_light(made):
    _, text = made
    page = Page(text)
    assert len(page.ids) == len(set(page.ids))
    local = {f'#{name}' for name in page.ids}
    for reference in page.references:
        assert reference in local or reference.startswith('data:image/png;base64,')
    assert not {'link', 'iframe', 'img'} & set(page.tags)
    assert len(text.encode()) < 5e6
    assert not re.search(r'\bnan\b|\binf\b|None', page.text)


def test_the_plots_of_a_page_have_what_was_measured_and_the_noise(made):
    diagnosis, text = made
    plots = Page(text).plots
    first = 'sweep' if diagnosis.experiment.quasi_static else 'curves'
    names = [trace['name'] for trace in plots[first]['data']]
    assert names.count('measured') == len(diagnosis.experiment.channels)
    shapes = plots['sweep' if first == 'sweep' else 'residuals']['layout']['shapes']
    assert any(shape.get('y1') == -shape.get('y0') > 0 for shape in shapes)


def test_a_page_of_a_long_record_with_all_channels_stays_small():
    rows = 100_000
    rng = np.random.default_rng(1)
    diagnosis = nothing_found()
    runs, measured, noise, error = {}, {}, {}, {}
    for name in ('back_pressure', 'mass_flow', 'chamber_pressure', 'valve_position'):
        measured[name] = rng.standard_normal(rows)
        noise[name], error[name] = 1.0, diagnosis.error['chamber_pressure']
        runs[name] = rng.standard_normal(rows)
    experiment = replace(diagnosis.experiment, time=np.arange(rows) / 100.0, noise=noise,
                         current=rng.random(rows), measured=measured)
    figures = [drawn(View(replace(diagnosis, experiment=experiment,
                                  runs=dict.fromkeys(diagnosis.runs, runs))))
               for drawn in (measured_and_models, residuals_over_time)]
    drawn = sum(len(figure.to_json()) for figure in figures)
    assert drawn + len(plot_library()) < 5e6
    assert sum(len(trace['x']) for trace in figures[0].traces) > 40_000  # to zoom into


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
    alone = Page(made_page('effect'))
    assert 'judged on' not in alone.text
    assert 'validation' not in alone.text


def test_a_page_says_what_was_dropped_how_it_was_split_and_what_scaling_hides(made):
    diagnosis, text = made
    page = Page(text)
    for note in diagnosis.notes:
        assert note in page.text
    for role in ('train', 'test'):
        rows = sum(s.last - s.first for s in diagnosis.segments if s.role == role)
        assert f'({rows} rows)' in page.text
    assert 'leaves every pressure and position unchanged' in page.text


def test_a_page_says_what_chance_changes_where_it_does():
    found = friction_found()
    effect, = found.effects
    lucky = replace(found, effects=(replace(effect, evidence=effect.evidence | {'luck': 12.5}),))
    assert 'Chance alone changes it by 12.5' in Page(undrawn_page(lucky)).text
    assert 'Chance alone' not in Page(made_page('effect')).text


def test_the_page_shows_suspects_intervals_and_what_is_not_told_apart():
    page = Page(made_page('effect'))
    assert '41 times the squared error of the choice' in page.texts
    assert '480 to 520 N' in page.texts
    assert 'This record cannot tell stem friction from position backlash.' in page.texts
    assert 'slow triangle with dither' in page.text


@pytest.mark.parametrize(('name', 'shown'), [
    ('effect', True), ('pressure only', False), ('position only', False)])
def test_the_signature_is_shown_where_pressure_and_position_are_known(name, shown):
    assert ('Valve signature' in Page(made_page(name)).texts) == shown


def test_a_sweep_is_not_drawn_over_a_time_that_it_does_not_have():
    page = Page(made_page('sweep'))
    assert 'time, s' not in page.texts
    assert 'chamber pressure, kPa' in page.texts


def page_of(columns):
    """Return the text of the page on a record of these columns."""
    return Page(undrawn_page(diagnosis_of(columns, 'none'))).text


@pytest.fixture(scope='module')
def page_of_timed():
    """Return the text of the page on a record that nothing is the matter with."""
    return Page(made_page('none')).text


def test_a_page_says_of_a_drive_whether_it_was_measured(page_of_timed):
    columns = timed_columns(seconds=30.0)
    assert 'Driven by the control current; compared' in page_of_timed
    supply = np.full(len(columns['time']), 400e3)
    assert 'Driven by the control current and the measured supply pressure; compared' in page_of(
        columns | {'supply_pressure': supply})
    assert 'Driven by the measured chamber pressure; compared' in Page(made_page('sweep')).text
    whole = nothing_found().experiment
    isolated = replace(whole, current=np.zeros(len(whole.time)))
    assert 'Driven by nothing: the chamber is shut off, as declared; compared' in Page(
        undrawn_page(replace(nothing_found(), experiment=isolated))).text


def test_a_page_says_where_the_noise_is_from(page_of_timed):
    columns = timed_columns(seconds=30.0)
    assert 'Noise, from the record alone: ' in page_of_timed
    late = columns | {'time': columns['time'] + 0.01 * np.random.default_rng(4).random(
        len(columns['time']))}
    assert ('Noise, from the record, and from what commands late by part of a row would do to the '
            'declared model: ') in page_of(late)
    del columns['control_current']
    assert ('Noise, from the record, and from what noise of the measured drives would do to the '
            'declared model: ') in page_of(columns)


def test_two_parallel_lines_may_be_lost_motion_as_well(page_of_timed):
    assert ('Two parallel lines are friction of the stem, or lost motion of the position sensor.'
            in page_of_timed)


def test_a_page_is_the_same_when_made_again():
    assert html_page(friction_found(), FROM) == made_page('effect')


def test_a_name_of_a_file_cannot_break_the_page():
    text = undrawn_page(nothing_found(), Provenance('<b>&"$x.csv', 'p$.yaml'))
    assert '<b>&"$x.csv explained by p$.yaml' in Page(text).texts
