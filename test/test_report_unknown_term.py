# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a report says of a term without a name, and of one that did not stand."""

from dataclasses import replace
import json

from made_diagnosis import BENT, DECLARED, refused_found, unknown_found
from made_report import FROM, Page, made_page, undrawn_page
import numpy as np
import pytest

from booster_ros.model import discrepancy
from booster_ros.model.simulation import simulate
from booster_ros.report.html_report import html_page
from booster_ros.report.json_report import json_text
from booster_ros.report.names import positive_is
from booster_ros.report.notes import notes
from booster_ros.report.parameter_files import write_parameter_files
from booster_ros.report.unknown_term import unknown_rivals
from booster_ros.report.wording import verdict_sentences, verdict_title


def test_an_unnamed_term_is_shown_with_its_variable_place_and_range():
    page = Page(made_page('unknown'))
    assert 'something in the stem' in verdict_title(unknown_found())
    # the outermost of twelve knots lie beyond what was seen
    assert 'function of the valve position from 1.45 mm to 14.5 mm' in page.text
    assert 'vary the valve position alone' in page.text


@pytest.mark.parametrize('location', range(1, len(discrepancy.LOCATIONS)))
def test_which_way_a_term_counts_is_said_as_the_model_takes_it(location):
    place = discrepancy.LOCATIONS[location]
    variable = {
        discrepancy.CHAMBER_VOLUME: discrepancy.VALVE_POSITION,
        discrepancy.EP_CONVERTER_LAG: discrepancy.BACK_PRESSURE_ERROR,
    }.get(location, discrepancy.TIME)
    size = {'ep_converter': 1e4, 'booster': 0.1, 'supply': 1e4, 'chamber': 1e-5, 'stem': 300.0,
            'pressure_sensor': 1e3, 'position_sensor': 1e-4, 'chamber_volume': 1e-4,
            'ep_converter_lag': 3.0}[place]
    last = 50e3 if variable == discrepancy.BACK_PRESSURE_ERROR else 40.0
    knots = tuple(np.linspace(-1.0, last, discrepancy.KNOTS))
    table = discrepancy.Discrepancy(location, variable, knots, (size,) * discrepancy.KNOTS)
    time = np.arange(0.0, 30.0, 0.1)
    current = np.where(time < 10.0, 3.8e-4, 4.4e-4)
    without, with_it = (simulate(p, time, current) for p in (
        DECLARED, DECLARED._replace(discrepancy=table)))
    channel, sign = {
        'towards more back pressure': ('back_pressure', 1.0),
        'towards filling the chamber': ('measured_chamber_pressure', 1.0),
        'towards more supply pressure': ('supply_pressure', 1.0),
        'out of the chamber': ('measured_chamber_pressure', -1.0),
        'towards open': ('measured_valve_position', 1.0),
        'added to the reading': ('measured_chamber_pressure' if place == 'pressure_sensor'
                                 else 'measured_valve_position', 1.0),
        'slower, 1 being 2.7 times as slow': ('back_pressure', -1.0),  # of one that rises
        'more volume': ('measured_chamber_pressure', -1.0),  # later: the same air in more space
    }[positive_is(place)]
    rising = (time > 10.0) & (time < 14.0)
    moved = sign * (with_it[channel] - without[channel])[rising]
    assert moved.mean() > 0.0
    assert f'(positive: {positive_is(place)})' in ' '.join(
        verdict_sentences(unknown_over(table)))


def test_an_unnamed_term_over_time_is_not_to_be_varied():
    diagnosis = unknown_found()
    term = diagnosis.unknown._replace(variable=discrepancy.TIME)
    page = Page(undrawn_page(replace(diagnosis, unknown=term)))
    assert 'record the same currents again' in page.text
    assert 'vary the time' not in page.text
    elsewhere = 'and the model is the declared one, refitted'
    assert elsewhere in page.text
    assert elsewhere not in Page(made_page('unknown')).text


def unknown_over(table):
    """Return the unknown found with another table in the model."""
    return replace(unknown_found(), after=BENT._replace(discrepancy=table),
                   unknown=table)


def test_an_unnamed_term_over_a_change_says_what_it_forgets_and_asks_for_a_step():
    table = BENT.discrepancy._replace(
        variable=discrepancy.POSITION_CHANGE, knots=tuple(np.linspace(-0.008, 0.008, 12)),
        memory=12.0)
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
        discrepancy.BOOSTER, discrepancy.FORCE_PLAY, tuple(np.linspace(-11.0, 11.0, 12) / 9.0),
        values, reach=0.018)
    diagnosis = unknown_over(table)
    page = Page(html_page(diagnosis, FROM))
    assert 'through a play 0.0360 N wide' in page.text
    assert '0.0200 N of friction' in page.text
    assert 'chamber pressure over the back pressure is a loop' in page.text
    assert 'place of the booster force in a play' in page.texts
    assert 'nothing is beyond' in page.text
    assert 'Dotted' not in page.text
    assert 'Dotted' in Page(made_page('unknown')).text
    written = json.loads(json_text(diagnosis, FROM))['unknown']
    assert (written['reach'], written['memory']) == (0.018, None)
    assert written['values'][1:-1] == pytest.approx(np.linspace(0.048, 0.008, 10))
    assert json.loads(json_text(unknown_found(), FROM))['unknown']['reach'] is None


def test_an_unnamed_term_in_the_lag_says_how_slow_it_is_and_asks_for_steps():
    table = discrepancy.Discrepancy(
        discrepancy.EP_CONVERTER_LAG, discrepancy.BACK_PRESSURE_ERROR,
        tuple(np.linspace(-33e3, 33e3, 12)), (0.0,) * 6 + (2.0, 2.0, 3.0, 3.0, 3.0, 0.0))
    page = Page(html_page(unknown_over(table), FROM))
    assert 'At the most the converter is 20.1 times as slow as its time constant says' in page.text
    assert 'Added in the lag of the E/P converter (positive: slower' in page.text
    assert 'step the control current by little and by much' in page.text
    assert 'vary the way' not in page.text
    assert 'term' in page.texts
    quick = table._replace(values=(0.0, *(-1.5,) * 10, 0.0))
    quicker = ' '.join(verdict_sentences(unknown_over(quick)))
    assert 'At the most the converter is 4.48 times as quick' in quicker
    assert 'times as slow as its time constant' not in Page(made_page('unknown')).text


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


def test_a_term_that_explains_too_little_is_said_to_do_so():
    refused = replace(refused_found(), decided=False)
    diagnosis = replace(refused, refused=replace(refused.refused, error=None))
    said = ' '.join(verdict_sentences(diagnosis))
    assert ('A smooth term in the stem over the valve position comes nearest, but explains too '
            'little of what is missing: it is not in the model.') in said
    assert 'speak against it' not in said
    assert 'That the stem is the place is a guess.' in said
    assert 'comes nearest, but explains too little' in undrawn_page(diagnosis)
    assert json.loads(json_text(diagnosis, FROM))['refused']['error'] is None


def test_terms_that_do_as_well_are_said():
    found = unknown_found()
    assert unknown_rivals(found) == []
    effect = replace(found.effects[0], confused_with=('supply over time',))
    rivalled = replace(found, effects=(effect,))
    said = 'A term in supply over time explains this record as well.'
    assert said in verdict_sentences(rivalled)
    assert said in undrawn_page(rivalled)


def test_a_declared_term_that_gave_way_to_another_is_named():
    bare = DECLARED
    declared, another = (bare._replace(discrepancy=discrepancy.Discrepancy(
        place, values=(size,) * discrepancy.KNOTS)) for place, size in (
            (discrepancy.STEM, 9.0), (discrepancy.CHAMBER, 1e-6)))

    def said(given, found):
        return [note for note in notes(replace(unknown_found(), declared=given, after=found))
                if 'took its place' in note]

    assert said(bare, another) == said(declared, declared) == []
    (note,) = said(declared, another)
    assert 'stem over time' in note
