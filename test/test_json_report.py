# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The report for other programs holds the numbers of the diagnosis."""

from dataclasses import replace
import json
import math

from made_diagnosis import MADE, nothing_found
from made_report import FROM
import pytest

from booster_ros.diagnosis.result import ChannelError, TraceStep
from booster_ros.diagnosis.selection.decide import Comparison
from booster_ros.report.json_report import VERSION, json_text


@pytest.fixture(scope='module', params=MADE)
def diagnosis(request):
    """Return a diagnosis."""
    return MADE[request.param]()


def test_json_holds_what_others_rely_on(diagnosis):
    report = json.loads(json_text(diagnosis, FROM))
    assert report['version'] == VERSION
    assert report['verdict'] == diagnosis.verdict
    assert {one['role'] for one in report['segments']} == {'train', 'test'}
    for part in ('error', 'held_out', 'validation'):
        for name, error in getattr(diagnosis, part).items():
            assert report[part][name] == {
                'unit': error.unit, 'declared': error.declared, 'before': error.before,
                'after': error.after, 'noise': error.noise,
                'left_open': None if math.isnan(error.left_open) else error.left_open,
                'unforeseen': None}
    for effect, found in zip(report['effects'], diagnosis.effects, strict=True):
        assert effect['name'] == found.name
        assert effect['location'] == found.location
        assert effect['standing'] == found.standing
        assert effect['explained'] == (
            None if math.isnan(found.explained) else found.explained)
        assert effect['evidence'] == found.evidence
        assert effect['confused_with'] == list(found.confused_with)
        expected = 'vary the valve position alone' if diagnosis.unknown else (
            found.separating_experiment)
        assert effect['separating_experiment'].startswith(expected)
        for name, interval in found.parameters.items():
            assert effect['parameters'][name] == {
                'value': interval.value, 'low': interval.low, 'high': interval.high,
                'unit': interval.unit, 'open_above': interval.open_above}
    for one in diagnosis.refitted:
        assert report['declared_parameters'][one.name]['after'] == one.after
        assert report['declared_parameters'][one.name]['at_limit'] is one.at_limit
        assert report['declared_parameters'][one.name]['spread'] == one.spread
        assert report['declared_parameters'][one.name]['low'] is None


def test_json_writes_null_for_what_is_no_number():
    diagnosis = replace(nothing_found(), validation={
        'chamber_pressure': ChannelError(
            'Pa', 1.0, float('nan'), float('inf'), 2.0, 3.0, 2.5)})
    error = json.loads(json_text(diagnosis, FROM))['validation']['chamber_pressure']
    assert error == {'unit': 'Pa', 'declared': 1.0, 'before': None, 'after': None, 'noise': 2.0,
                     'left_open': 3.0, 'unforeseen': 2.5}


def test_each_step_of_the_selection_is_written_with_its_figures():
    step = TraceStep(('chamber_leak',), (), 1.02, Comparison(812.5, 790.25, 31.5, 700.0, 1.25, 2.5),
                     'accepted')
    last = TraceStep(('chamber_leak', 'dead_time'), ('chamber_leak',), 1.01,
                     Comparison(-2.5, float('nan'), 0.5, -3.0, 1.25),
                     'the evidence for it is not enough')
    report = json.loads(json_text(replace(nothing_found(), trace=(step, last)), FROM))
    assert report['trace'][0] == {
        'effects': ['chamber_leak'], 'against': [], 'reduced_chi2': 1.02, 'log_evidence': 812.5,
        'gain': 790.25, 'gain_standard_error': 31.5, 'dispersion': 1.25, 'luck': 2.5,
        'outcome': 'accepted'}
    assert report['trace'][1]['gain'] is None
    assert report['trace'][1]['against'] == ['chamber_leak']
    assert json.loads(json_text(nothing_found(), FROM))['trace'] == []
