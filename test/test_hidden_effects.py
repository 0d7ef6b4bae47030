# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Effects that the catalogue does not have, and two at once, hidden in a plant of other equations.

Each is a whole diagnosis: they belong to the campaign.
"""

import json

from hidden_plant import cases
from hidden_plant.cases import Case, write_case
from hidden_plant.effects import EFFECTS
import numpy as np
import pytest

from booster_ros.programs.close_loop import main

pytestmark = pytest.mark.campaign


def diagnosis_of(effects, seconds, folder, monkeypatch, size='medium', seed=11):
    """Return the report on a record with these effects of this size, judged on another."""
    monkeypatch.setattr(cases, 'FIT_SECONDS', seconds)
    monkeypatch.setattr(cases, 'VALIDATION_SECONDS', 40.0)
    case = Case('hidden', tuple((key, EFFECTS[key].size(size)) for key in effects), seed=seed)
    write_case(case, folder)
    status = main([
        '--record', str(folder / 'hidden_fit.csv'), '--params', str(folder / 'hidden.yaml'),
        '--validation', str(folder / 'hidden_val.csv'), '--out', str(folder / 'out')])
    assert status == 0
    return json.loads((folder / 'out' / 'report.json').read_text())


def errors_fall_to_the_noise(report, much=1.3):
    """Assert that on the test set little more than noise is left, and more was before."""
    for channel in report['held_out'].values():
        assert channel['after'] <= much * channel['noise']
    assert any(c['before'] > 1.4 * c['after'] for c in report['held_out'].values())


@pytest.mark.parametrize(('effect', 'size', 'seconds', 'variable'), [
    ('leak_opens_with_travel', 'large', 60.0, 'valve_position or chamber_pressure'),
    ('bulging_diaphragm', 'medium', 60.0, 'valve_position'),
    ('converter_creep', 'large', 90.0, 'control_current_change'),
    ('slow_venting', 'medium', 90.0, 'back_pressure_error'),
    ('spring_creep', 'medium', 150.0, 'valve_position_change'),
    ('spool_holes', 'medium', 150.0, 'booster_force'),
    ('relay_friction', 'medium', 90.0, 'booster_force_play'),
])
def test_what_has_no_name_is_unknown_in_its_place(
        effect, size, seconds, variable, tmp_path, monkeypatch):
    report = diagnosis_of((effect,), seconds, tmp_path, monkeypatch, size)
    assert report['verdict'] == 'unknown'
    assert [e['name'] for e in report['effects']] == ['unknown']
    assert report['effects'][0]['location'] == EFFECTS[effect].location
    assert report['unknown']['variable'] in variable.split(' or ')
    errors_fall_to_the_noise(report)
    below, *slopes, above = np.abs(
        np.diff(report['unknown']['values']) / np.diff(report['unknown']['at']))
    assert max(below, above) < 1.3 * max(slopes)


@pytest.mark.parametrize('effects', [
    ('tubing_laminar',),
    ('tubing_laminar', 'ep_hysteresis'),
])
def test_a_tube_whose_flow_is_laminar_is_a_tube(effects, tmp_path, monkeypatch):
    report = diagnosis_of(effects, 60.0, tmp_path, monkeypatch, 'large')
    names = {effect['name'] for effect in report['effects']}
    assert names == {'tubing_restriction', *effects[1:]}
    tube, = (one for one in report['effects'] if one['name'] == 'tubing_restriction')
    assert tube['parameters']['tubing.laminar_share']['value'] > 0.8
    errors_fall_to_the_noise(report)


@pytest.mark.parametrize(('effect', 'place', 'width'), [
    ('galled_stem', 6e-3, 1.35e-3),
    ('galled_stem_above', 11.5e-3, 2.2e-3),
])
def test_a_galled_stem_is_told_with_its_place(effect, place, width, tmp_path, monkeypatch):
    """The peak put in is a parabola squared, whose width is that of a bell as near as can be."""
    report = diagnosis_of((effect,), 90.0, tmp_path, monkeypatch)
    assert [one['name'] for one in report['effects']] == ['position_dependent_friction']
    found = {name: value['value'] for name, value in report['effects'][0]['parameters'].items()}
    assert found['actuator.friction_peak'] == pytest.approx(200.0, rel=0.15)
    assert found['actuator.friction_peak_position'] == pytest.approx(place, abs=5e-4)
    assert found['actuator.friction_peak_width'] == pytest.approx(width, rel=0.25)
    errors_fall_to_the_noise(report, 1.5)


@pytest.mark.parametrize(('pair', 'seconds'), [
    (('booster_dead_band', 'position_backlash'), 60.0),
    (('tubing_restriction', 'ep_hysteresis'), 150.0),
    (('supply_ripple', 'chamber_leak'), 150.0),
    (('ep_hysteresis', 'spring_nonlinearity'), 150.0),
])
def test_two_effects_are_both_named(pair, seconds, tmp_path, monkeypatch):
    report = diagnosis_of(pair, seconds, tmp_path, monkeypatch)
    assert report['verdict'] == 'effect'
    assert len(report['effects']) == 2
    for key in pair:
        assert any(set(EFFECTS[key].names) & {e['name'], *e['confused_with']}
                   for e in report['effects'])
        assert EFFECTS[key].location in {e['location'] for e in report['effects']}
    errors_fall_to_the_noise(report)
