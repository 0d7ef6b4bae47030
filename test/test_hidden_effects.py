# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Effects that the catalogue does not have, and two at once, hidden in a plant of other equations.

One of either kind always runs; with BOOSTER_ROS_ALL_SAMPLES in the environment, all do.
"""

from dataclasses import replace
import json
import os

from hidden_plant import cases
from hidden_plant.cases import Case, write_case
from hidden_plant.effects import EFFECTS
import numpy as np
import pytest

from booster_ros.diagnosis.data.blocks import split
from booster_ros.diagnosis.hypotheses.applicable import free_to_refit
from booster_ros.diagnosis.last_fit import last_fit
from booster_ros.diagnosis.prepare.preparation import prepare
from booster_ros.diagnosis.searching.candidate import NEAR_NOISE
from booster_ros.diagnosis.hypotheses.subsystem import search_above
from booster_ros.diagnosis.searching.nameless import best_terms
from booster_ros.diagnosis.searching.forward import named
from booster_ros.diagnosis.searching.next_effect import extend, shows_in_means
from booster_ros.diagnosis.selection.screening import references, screen
from booster_ros.diagnosis.searching.search import Search, carried
from booster_ros.diagnosis.searching.selection import Tried
from booster_ros.diagnosis.searching.teaching import taught
from booster_ros.model.parameters import from_values
from booster_ros.parameters.file import read_parameter_file
from booster_ros.programs.close_loop import main
from booster_ros.records import read_record

minutes = pytest.mark.skipif(
    'BOOSTER_ROS_ALL_SAMPLES' not in os.environ, reason='minutes: BOOSTER_ROS_ALL_SAMPLES=1')


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
    """Assert that on the locked part little more than noise is left, and more was before."""
    for channel in report['held_out'].values():
        assert channel['after'] <= much * channel['noise']
    assert any(c['before'] > 1.4 * c['after'] for c in report['held_out'].values())


@pytest.mark.parametrize(('effect', 'size', 'seconds', 'variable'), [
    ('leak_opens_with_travel', 'large', 60.0, 'valve_position or chamber_pressure'),
    ('bulging_diaphragm', 'medium', 60.0, 'valve_position'),
    pytest.param('converter_creep', 'large', 90.0, 'control_current_change', marks=minutes),
    pytest.param('slow_venting', 'medium', 90.0, 'back_pressure_error', marks=minutes),
    pytest.param('spring_creep', 'medium', 150.0, 'valve_position_change', marks=minutes),
    pytest.param('spool_holes', 'medium', 150.0, 'booster_force', marks=minutes),
    pytest.param('relay_friction', 'medium', 90.0, 'booster_force_play', marks=minutes),
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
    pytest.param(('tubing_laminar', 'ep_hysteresis'), marks=minutes),
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
    pytest.param('galled_stem_above', 11.5e-3, 2.2e-3, marks=minutes),
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


def search_on(effects, seed, folder, kind='mixed', spread='samples'):
    """Return the search on a record of the hidden plant with these effects and sizes."""
    write_case(Case('hidden', effects, kind=kind, spread=spread, seed=seed), folder)
    declared = from_values(read_parameter_file(folder / 'hidden.yaml').physical)
    experiment = prepare(read_record(folder / 'hidden_fit.csv'), declared)
    return Search(experiment, split(experiment.time, experiment.current), declared,
                  free_to_refit(declared, experiment))


def refit_and_best_term(search):
    """Return the declared model refitted, and the best with a term without a name."""
    refit = search.refit()
    return refit, best_terms(search, Tried(refit, refit, (refit,), {}))[0]


def large(effect):
    return effect, EFFECTS[effect].size('large')


def test_a_term_that_linear_reckoning_ranks_far_behind_is_found(tmp_path):
    """Of a large leak: the refit of the declared parameters goes far to imitate it."""
    search = search_on((large('leak_opens_with_travel'),), 110043, tmp_path)
    _, best = refit_and_best_term(search)
    assert best.effects[0].startswith('unknown: chamber over ')
    assert best.misfit < 1.3


def test_what_follows_a_recent_change_is_found_with_the_time_it_takes(tmp_path):
    """Of a converter that creeps for 15 s: what is missing follows no state, only what was."""
    search = search_on((large('converter_creep'),), 31, tmp_path)
    refit, best = refit_and_best_term(search)
    assert best.effects == ('unknown: ep_converter over control_current_change',)
    assert best.misfit < 0.03 * refit.misfit
    assert best.fit.parameters.discrepancy.memory == pytest.approx(15.0, rel=0.1)


def test_what_is_slower_one_way_is_found_in_the_lag(tmp_path):
    """Of a converter that vents eleven times as slowly as it fills."""
    search = search_on((large('slow_venting'),), 11, tmp_path)
    refit, best = refit_and_best_term(search)
    assert best.effects == ('unknown: ep_converter_lag over back_pressure_error',)
    assert best.misfit < min(2.0, 0.03 * refit.misfit)
    lag = best.fit.parameters.discrepancy
    slower = np.exp(np.interp([-20e3, -5e3, 5e3, 20e3], lag.knots, lag.values))
    assert slower == pytest.approx([11.0, 11.0, 1.0, 1.0], rel=0.35)


def test_what_follows_a_play_is_found_with_the_width_it_has(tmp_path):
    """Of a relay that rubs with 20 mN: what is missing goes by where its force turned last."""
    search = search_on((large('relay_friction'),), 271, tmp_path)
    refit, best = refit_and_best_term(search)
    assert best.effects == ('unknown: booster over booster_force_play',)
    assert best.misfit < 0.01 * refit.misfit
    assert best.fit.parameters.discrepancy.reach == pytest.approx(0.02, rel=0.1)


def test_an_effect_whose_best_trial_is_not_the_most_promising_is_screened_as_what_it_is(tmp_path):
    """Of a large flow force on the plugs; the refit goes far to imitate it."""
    search = search_on((large('plug_flow_force'),), 110014, tmp_path)
    refit = search.refit()
    around = references(refit.problem, refit.problem.at(refit.fit.z))
    costs = {name: screen(refit.problem, around, name, np.array([0.5])).cost
             for name in ('plug_flow_force', 'dead_volume_change', 'booster_dead_band')}
    assert min(costs, key=costs.get) == 'plug_flow_force'
    assert costs['plug_flow_force'] < 0.8 * refit.fit.cost


def test_a_bend_about_another_back_pressure_than_the_terms_is_met_to_the_noise(tmp_path):
    """What is straight in it is more than gain and zero are off where the line is straight."""
    search = replace(search_on((('ep_nonlinearity_bow', -2e3),), 40931026, tmp_path, 'prbs'),
                     names=('ep_nonlinearity',))
    refit = search.refit()
    found, = extend(search, refit, lambda: None)
    assert found.misfit < 1.1 < 0.2 * refit.misfit
    assert found.fault == ''


@pytest.mark.parametrize(('hidden', 'seed', 'shows'), [
    ((('chamber_leak', 1.0e-8), ('stem_friction', 384.0)), 4507024, True),
    ((('stem_friction', 384.0),), 4507024, False),
])
def test_a_small_leak_shows_above_a_stem_that_slips(hidden, seed, shows, tmp_path):
    """Single rows show it no more than the next best thing: slips leave more in them."""
    above = search_above(search_on(hidden, seed, tmp_path))
    refit = above.refit()
    problem = above.joint(above.problem(), ('chamber_leak',))
    fit = problem.fit(carried(problem, refit.fit))
    assert fit.cost > 0.95 * refit.fit.cost
    assert shows_in_means(refit.problem, refit.fit, problem, fit) is shows


def test_a_leak_beside_slips_is_called_for_by_what_lasts(tmp_path):
    """Of single slips on the segments held back the score may rise as well as fall."""
    names = ('stem_friction', 'chamber_leak')
    hidden = (('chamber_leak', 1.105e-8), ('stem_friction', 370.0))
    search = replace(search_on(hidden, 9277028, tmp_path, 'stairs'), names=names)
    tried = named(search, search.refit(), lambda *_: None)
    assert tried.chosen.effects == names
    assert tried.chosen.lasting == {'chamber_leak'}


def test_what_a_model_learnt_may_be_what_a_second_effect_does(tmp_path):
    """With a ripple alone, and the select segments taught, little more than noise is left."""
    search = replace(search_on((('supply_ripple', 8326.0), ('chamber_leak', 8.13e-9)), 6101003,
                               tmp_path), names=('supply_ripple', 'chamber_leak'))
    tried = named(search, search.refit(), lambda *_: None)
    alone = next(one for one in tried.all if one.effects == ('supply_ripple',))
    assert taught(search, alone).misfit < NEAR_NOISE < alone.misfit
    assert set(tried.chosen.effects) == set(search.names)
    assert tried.chosen.fit.parameters.actuator.leak_area == pytest.approx(8.13e-9, rel=0.1)


IN_A_CORNER = (-0.027, 2.385, 5.0, -1.661, 0.0, -5.0, 1.54, 1.234, -0.318, 0.225, 3.578, 0.341,
               2.309, 0.472, -6.529, -1.0, 0.0, 0.0, 0.0)
"""Where a fit with hysteresis alone ends on a record of hysteresis and a throttled tube."""


def test_an_effect_is_screened_by_what_all_else_may_do_about_it_within_bounds(tmp_path):
    search = search_on((('tubing_restriction', 5.42e5), ('ep_hysteresis', 4.754e-6)), 1123001,
                       tmp_path)
    problem = search.joint(search.problem(), ('ep_hysteresis',))
    fit = problem.at(np.array(IN_A_CORNER))
    left = float(np.sum(problem.residuals(fit.z)**2))
    found = screen(problem, references(problem, fit), 'tubing_restriction', np.array([0.5]))
    low, high = found.problem.bounds()
    assert found.cost < 0.5 * left
    assert all((low <= z).all() and (z <= high).all() for z in found.starts)


NOT_AT_REST = (-0.277, 1.131, 0.167, -0.006, -1.181, -0.619, 0.83, -1.054, 0.016, -0.007, 0.225,
               0.132, 1.418, 2.513, 1.658, -0.788, 2.432, 0.0, 0.0, 0.0, 0.0)
"""Where the fit of a choice ended: offset and supply pressure one standard deviation off."""


def test_the_last_fit_goes_to_its_end_and_leaves_a_lift_that_is_never_reached_alone(tmp_path):
    names = ('exhaust_asymmetry', 'position_sensor_lag')
    search = search_on(((names[0], 0.41183), (names[1], 0.165826)), 1123013, tmp_path)
    problem = search.joint(search.problem(), names)
    chosen = search.rate(names, problem, problem.at(np.array(NOT_AT_REST)))
    last = last_fit(search, chosen)
    found = dict(zip((free.knob.parameter for free in last.problem.freedoms), last.fit.z))
    booster = last.fit.parameters.booster
    assert booster.exhaust_lift_ratio == 1.0
    assert booster.exhaust_gain_ratio == pytest.approx(1.41183, rel=0.03)
    left = float(np.sum(last.problem.residuals(last.fit.z)**2))
    assert left < 1.05 * last.problem.rows_counted()
    assert abs(found['ep_converter.offset']) < 0.3
    assert abs(found['supply.pressure']) < 0.3


@pytest.mark.parametrize(('hidden', 'name', 'seed'), [
    (('critical_pressure_ratio', 0.15), 'critical_pressure_ratio', 25117019),
    (('spring_nonlinearity', -0.0214), 'spring_nonlinearity', 25117026),
    (('dead_volume_change', 8.55e-5), 'dead_volume_change', 60317008),
    (None, None, 25117006),
])
def test_an_effect_beside_which_noise_could_be_all_is_seen_if_every_row_shows_it(
        hidden, name, seed, tmp_path):
    """What it leaves is 2 to 7 % above noise, and more where another input goes further."""
    search = search_on((hidden,) if hidden else (), seed, tmp_path, 'sines')
    search = replace(search, names=(
        'critical_pressure_ratio', 'spring_nonlinearity', 'ep_nonlinearity', 'dead_volume_change'))
    refit = search.refit()
    assert refit.misfit < 1.1
    chosen = named(search, refit, lambda phrase, share: None).chosen
    assert chosen.effects == ((name,) if name else ())


def test_a_fit_to_every_row_goes_to_the_end_of_its_valley(tmp_path):
    """
    Gain, offset and supply nearly do the same to a converter that is near its supply.

    Slopes over ten times the way have it end at 1.017, and effects seem to lower the rest.
    """
    search = search_on((), 101, tmp_path, spread='wide')
    every = search.on_every_row(search.refit())
    assert every.fit.cost < 1.008 * every.problem.rows_counted()


@pytest.mark.parametrize(('pair', 'seconds'), [
    (('booster_dead_band', 'position_backlash'), 60.0),
    pytest.param(('tubing_restriction', 'ep_hysteresis'), 150.0, marks=minutes),
    pytest.param(('supply_ripple', 'chamber_leak'), 150.0, marks=minutes),
    pytest.param(('ep_hysteresis', 'spring_nonlinearity'), 150.0, marks=minutes),
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
