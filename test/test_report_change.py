# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a report says of a valve that changed while it was recorded."""

from dataclasses import replace
import json

from made_diagnosis import friction_found, nothing_found
from made_report import FROM, Page

from booster_ros.diagnosis.result import Change, FoundEffect
from booster_ros.report.html_report import html_page
from booster_ros.report.json_report import json_text
from booster_ros.report.wording import verdict_sentences, verdict_title

CHANGE = Change(60.07, 1.01, 2500.0, cut=True)


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


def test_a_valve_that_lacks_nothing_since_it_changed_is_said_to_have_changed():
    found = changed(CHANGE, nothing_found())
    assert verdict_title(found) == 'The valve changed at 60.07 s'
    assert verdict_sentences(found)[2:] == verdict_sentences(nothing_found())
    assert Page(html_page(found, FROM)).texts
    written = json.loads(json_text(found, FROM))
    assert written['record']['begins'] == 60.07
    assert written['change'] == {
        'time': 60.07, 'met': 1.01, 'missed': 2500.0, 'cut': True, 'silent': []}


def test_of_a_late_clock_every_digit_that_counts_is_told():
    found = changed(replace(CHANGE, time=5000166.02), nothing_found())
    assert verdict_title(found) == 'The valve changed at 5000166.02 s'
    assert 'time from 5000166.02 s on, s' in html_page(found, FROM)


def test_a_number_that_json_has_no_word_for_is_null_wherever_it_stands():
    found = changed(replace(CHANGE, missed=float('nan')), nothing_found())
    assert json.loads(json_text(found, FROM))['change']['missed'] is None


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
