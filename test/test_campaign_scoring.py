# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Scoring what a diagnosis says against what is hidden."""

import json

from made_outcome import FRICTION, LEAK, UNKNOWN, found, outcome
import pytest

from booster_ros.campaign.cases import CampaignError, chosen, read_set, read_sets
from booster_ros.campaign.page import html_page, markdown_text
from booster_ros.campaign.results import add_result, line_of, read_results, write_results
from booster_ros.campaign.scoring import (
    FAILED, Interval, answer_of, is_named, is_placed, outcome_of, values_of)
from booster_ros.campaign.table import set_rows

PAIR = ['chamber_leak+stem_friction']


@pytest.mark.parametrize(('names', 'verdict', 'effects', 'right'), [
    (['none'], 'none', [], True),
    (['none'], 'effect', [LEAK], False),
    (['chamber_leak'], 'none', [], False),
    (['chamber_leak'], 'effect', [LEAK], True),
    (['exhaust_seat_leak'], 'effect', [LEAK], True),
    (['dead_time'], 'effect', [LEAK], False),
    (['dead_time', 'chamber_leak'], 'effect', [LEAK], True),
    (PAIR, 'effect', [LEAK], False),
    (PAIR, 'effect', [FRICTION, LEAK], True),
    (PAIR, 'effect', [FRICTION, LEAK, found('dead_time', 'ep_converter')], True),
    (PAIR, 'effect', [FRICTION, LEAK, *[found('dead_time', 'ep_converter')] * 2], False),
    (['dead_time', *PAIR], 'effect', [FRICTION, LEAK], True),
    (['unknown', 'seat_load'], 'unknown', [UNKNOWN], True),
    (['unknown', 'seat_load'], 'effect', [found('seat_load', 'stem')], True),
    (['stem_friction'], 'unknown', [UNKNOWN], False),
])
def test_a_name_is_right_where_it_or_what_it_is_confused_with_is(names, verdict, effects, right):
    assert is_named(names, verdict, effects) is right


@pytest.mark.parametrize(('location', 'effects', 'right'), [
    ('none', [], True),
    ('none', [LEAK], False),
    ('chamber', [], False),
    ('chamber', [LEAK], True),
    ('booster', [LEAK], False),
    ('chamber+stem', [LEAK], False),
    ('chamber+stem', [FRICTION, LEAK], True),
    ('stem|sensor', [FRICTION], True),
    ('stem|sensor', [LEAK], False),
])
def test_a_place_is_right_where_something_was_found_in_each(location, effects, right):
    assert is_placed(location, 'effect' if effects else 'none', effects) is right


@pytest.mark.parametrize(('low', 'high', 'open_above', 'holds', 'widths'), [
    (240.0, 260.0, False, True, 0.5),
    (284.0, 295.0, False, False, 10.0 / 11.0),
    (200.0, 220.0, False, False, 0.5),
    (200.0, 220.0, True, True, 0.0),
])
def test_an_error_is_counted_in_widths_of_its_interval(low, high, open_above, holds, widths):
    interval = Interval('actuator.coulomb_friction', True, 250.0, 260.0, low, high, open_above)
    assert interval.holds is holds
    assert interval.widths == pytest.approx(widths)


def test_a_report_is_read_as_far_as_the_truth_is_known():
    report = {
        'verdict': 'effect', 'summary': 'long', 'effects': [
            {**found('stem_friction', 'stem', actuator__coulomb_friction=(260, 250, 270),
                     actuator__stiction=(10, 0, 20)), 'standing': 'likely', 'explained': 0.97,
             'evidence': {'much': 1}}],
        'declared_parameters': {
            'actuator.bench_set[0]': {'given': 1.0, 'after': 2.0, 'low': 1.5, 'high': 2.5},
            'supply.pressure': {'given': 1.0, 'after': 2.0, 'low': None, 'high': None}},
        'held_out': {'chamber_pressure': {'after': 180.0, 'noise': 150.0},
                     'valve_position': {'after': 8e-6, 'noise': 8e-6}}}
    truth = {'actuator.coulomb_friction': 240.0, 'actuator.bench_set[0]': 2.1,
             'supply.pressure': 4e5, 'actuator.leak_area': 1e-8}
    answer = answer_of(report, truth)
    assert answer['intervals'] == (
        Interval('actuator.coulomb_friction', True, 240.0, 260.0, 250.0, 270.0),
        Interval('actuator.bench_set[0]', False, 2.1, 2.0, 1.5, 2.5))
    assert answer['held_out'] == pytest.approx(1.2)
    effect, = answer['found']
    assert (effect['standing'], effect['explained']) == ('likely', 0.97)
    assert 'evidence' not in effect


@pytest.mark.parametrize(('names', 'effect', 'wrong'), [
    (['chamber_leak'], found('chamber_leak', 'chamber', standing='confirmed'), ()),
    (['chamber_leak'], found('exhaust_seat_leak', 'booster', 'chamber_leak',
                             standing='confirmed'), ()),
    (PAIR, found('stem_friction', 'stem', standing='confirmed'), ()),
    (['chamber_leak'], found('dead_time', 'ep_converter', standing='likely'), ()),
    (['chamber_leak'], found('dead_time', 'ep_converter', standing='confirmed'), ('dead_time',)),
    (['none'], found('dead_time', 'ep_converter', standing='confirmed'), ('dead_time',)),
    (['chamber_leak'], found('unknown', 'stem', standing='confirmed'), ()),
    (['chamber_leak'], found('dead_time', 'ep_converter'), ()),
])
def test_a_wrong_name_counts_more_where_it_was_called_confirmed(names, effect, wrong):
    assert outcome('a', effect, names=names, location='chamber').wrongly_confirmed == wrong


def test_the_second_record_is_met_by_its_own_noise():
    after = {'chamber_pressure': 160.0, 'valve_position': 13e-6}
    assert outcome('a', after=after).near is False
    own = {'chamber_pressure': 150.0, 'valve_position': 10e-6}
    assert outcome('a', after=after, noise=own).near is True
    none = {'chamber_pressure': 0.0, 'valve_position': 0.0}
    assert outcome('a', after=after, noise=none).near is None
    assert outcome('a', after=None).near is False


def test_a_set_is_counted_in_a_row():
    one = outcome('a', after={'chamber_pressure': 150.0})
    other = outcome('b', UNKNOWN, names=['dead_time'], location='stem', seconds=30.0, intervals=[
        Interval('actuator.leak_area', True, 1.0, 3.0, 2.0, 4.0),
        Interval('supply.pressure', False, 1.0, 1.0, 0.0, 2.0)])
    none = outcome('c', names=['dead_time'], location='ep_converter', status=FAILED,
                   message='no | such file', verdict='')
    assert set_rows([one, other, none]) == [
        ('set', '3', '2', '1 of 3', '2 of 3', '1 of 1', '1 of 3', '0 of 1', '1 of 1', '1', '–',
         '10', '30', '8')]
    assert [row[0] for row in set_rows([one, other, outcome('a', set='z')])] == ['set', 'z', 'all']
    text = markdown_text([one, other, none], 4, {'program': 'p'})
    assert '3 of 4 cases have been run.' in text
    assert r'| set | c | dead_time | failed |' in text
    assert r'no \| such file |' in text
    page = html_page([outcome('<b>')], 1, {})
    assert '<td>&lt;b&gt;</td>' in page
    assert 'http' not in page


def test_outcomes_are_read_as_they_were_written(tmp_path):
    outcomes = [
        outcome('a', found('stem_friction', 'stem', standing='likely', x__y=(1.0, 0.0, 2.0)),
                after={'chamber_pressure': 150.0}, intervals=[
                    Interval('x.y', True, 1.0, 1.0, 0.0, 2.0)]),
        outcome('b', status=FAILED, verdict='')]
    for each in outcomes:
        assert outcome_of(json.loads(line_of(each))) == each
    assert read_results(tmp_path) == []
    write_results(tmp_path, outcomes[:1])
    add_result(tmp_path, outcomes[1])
    path = tmp_path / 'cases.jsonl'
    with path.open('a') as file:
        file.write('{"set": "cut o')
    assert read_results(tmp_path) == outcomes
    assert values_of(outcomes[0])['intervals'][0]['holds'] is True
    path.write_text('{"what": 1}\n')
    with pytest.raises(CampaignError, match='is not a file of outcomes'):
        read_results(tmp_path)


def test_a_set_is_read_with_its_own_noise_and_true_sizes(tmp_path):
    key = {'b': {'names': ['none'], 'location': 'none', 'effect': {}},
           'a': {'names': ['dead_time'], 'location': 'ep_converter',
                 'noise': {'chamber_pressure': 50}, 'parameters': {'ep_converter.dead_time': 0.1}}}
    (tmp_path / 'key.json').write_text(json.dumps(key))
    one, other = read_set(tmp_path)
    assert (one.name, other.name) == ('a', 'b')
    assert one.truth.noise == {'chamber_pressure': 50.0, 'valve_position': 8e-6}
    assert one.truth.parameters == {'ep_converter.dead_time': 0.1}
    assert other.truth.is_clean
    digest = one.digest()
    one.record.write_text('time\n1\n')
    assert one.digest() != digest
    with pytest.raises(CampaignError, match='rename one'):
        read_sets([tmp_path, tmp_path])
    assert [case.name for case in chosen([one, other], ['a*'], quick=True)] == ['a']
    with pytest.raises(CampaignError, match='no case is called z'):
        chosen([one, other], ['z'], quick=False)
    many = chosen([one, other] * 45, [], quick=True)
    assert len(many) == 60
    assert many.count(one) == 30


@pytest.mark.parametrize(('text', 'why'), [
    (None, 'No such file'), ('{', 'is not JSON'), ('{}', 'has no cases'), ('[]', 'has no cases'),
    ('{"a": 1}', 'a: is no entry'), ('{"a": {"names": "x", "location": "y"}}', 'names has to be'),
    ('{"a": {"names": ["x"]}}', 'location has to be'),
    ('{"a": {"names": ["x"], "location": "y", "noise": [1]}}', 'noise has to be'),
    ('{"a": {"names": ["x"], "location": "y", "parameters": {"b": "c"}}}', 'parameters has to be'),
])
def test_a_folder_that_is_no_set_is_named(tmp_path, text, why):
    if text is not None:
        (tmp_path / 'key.json').write_text(text)
    with pytest.raises(CampaignError, match=why) as raised:
        read_set(tmp_path)
    assert str(tmp_path / 'key.json') in str(raised.value)
