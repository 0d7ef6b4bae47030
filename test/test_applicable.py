# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Effects are tried where they can show, and left alone where a drive has cut them off."""

from dataclasses import replace
from functools import cache

from made_diagnosis import DECLARED, record_of, swept_columns, timed_columns
from made_effect import add_effect
import numpy as np
import pytest

from booster_ros.diagnosis.data.blocks import rows_of, split
from booster_ros.diagnosis.hypotheses.applicable import applicable, free_to_refit, matters
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.diagnosis.estimation.parametrisation import declared_freedom, put
from booster_ros.diagnosis.judging.test_set import without_test_set
from booster_ros.diagnosis.prepare.preparation import prepare
from booster_ros.diagnosis.hypotheses.compose import with_effect
from booster_ros.model.actuator import VESSEL
from booster_ros.model.booster import NO_BOOSTER
from booster_ros.model.catalogue import EFFECTS, Knob
from booster_ros.model.gas import ISENTROPIC

TIME = np.arange(0.0, 30.0, 0.05)
BACK = {'back_pressure': 244e3 + 5e3 * np.sin(TIME)}
SUPPLY = {'supply_pressure': np.full(len(TIME), 400e3)}
FLOW = {'mass_flow': 1e-4 * np.cos(TIME)}
DROP = {'pressure_drop': 2e5 + 1e5 * np.sin(0.3 * TIME)}


@cache
def timed():
    """Return the columns of a record with a current, which are simulated once."""
    return timed_columns(seconds=30.0)


def bench():
    """Return the columns of a flow bench."""
    back = np.tile(np.linspace(180e3, 200e3, 20), 2)
    return {'back_pressure': back, 'supply_pressure': np.repeat([300e3, 400e3], 20),
            'chamber_pressure': np.zeros(40), 'mass_flow': np.linspace(0.0, 1e-3, 40)}


def only(*names):
    return {name: timed()[name] for name in names}


RECORDS = {
    'commanded': timed,
    'commanded, supply known': lambda: timed() | SUPPLY,
    'pressure only': lambda: only('time', 'control_current', 'chamber_pressure'),
    'from the back pressure': lambda: only(
        'time', 'chamber_pressure', 'valve_position') | BACK | FLOW,
    'signature in time': lambda: only('time', 'chamber_pressure', 'valve_position'),
    'signature': swept_columns,
    'commanded, drop known': lambda: timed() | DROP,
    'signature, drop known': lambda: swept_columns() | {
        'pressure_drop': np.repeat([1e5, 3e5], 30)},
    'bench': bench,
    'isolated': lambda: only('time', 'chamber_pressure'),
}


@cache
def prepared(kind):
    """Return a prepared record; what nothing drives is of a chamber that is declared shut."""
    declared = put(DECLARED, 'booster.opening_gain', 0.0) if kind == 'isolated' else DECLARED
    return prepare(record_of(RECORDS[kind]()), declared)


@pytest.fixture(params=RECORDS)
def experiment(request):
    """Return a prepared record."""
    return prepared(request.param)


def test_an_effect_that_is_left_out_would_have_changed_nothing(experiment):
    cut_off = set(EFFECTS) - set(applicable(experiment, DECLARED))
    if experiment.quasi_static or not experiment.drives:
        # cut off for what they mean (no clock, an isolated chamber), not because nothing happens
        kept_upstream = {name for name in applicable(experiment, DECLARED)
                         if EFFECTS[name].location == 'ep_converter'}
        assert not kept_upstream
        return
    still = experiment.predict(DECLARED)
    for name in cut_off:
        changed = DECLARED
        for knob in EFFECTS[name].knobs:
            changed = put(changed, knob.parameter, knob.typical)
        moved = experiment.predict(changed)
        for channel, values in still.items():
            assert np.allclose(moved[channel], values, rtol=0.0,
                               atol=0.2 * experiment.noise[channel]), (name, channel)


def names(key):
    return set(applicable(prepared(key), DECLARED))


def located(*locations):
    return {name for name, effect in EFFECTS.items() if effect.location in locations}


IN_OPEN_LOOP = set(EFFECTS) - located('position_controller') - {'process_force'}


def test_a_full_record_may_show_every_effect():
    assert names('commanded') == IN_OPEN_LOOP
    assert IN_OPEN_LOOP - names('commanded, supply known') == located('supply')
    assert names('commanded, drop known') - IN_OPEN_LOOP == {'process_force'}


def test_the_isentropic_law_has_no_critical_ratio_to_look_for():
    experiment = prepared('commanded')
    nozzle = put(DECLARED, 'booster.orifice_law', ISENTROPIC)
    assert IN_OPEN_LOOP - set(applicable(experiment, nozzle)) == {'critical_pressure_ratio'}
    refitted = {free.knob.parameter for free in free_to_refit(nozzle, experiment)}
    left = {free.knob.parameter for free in free_to_refit(DECLARED, experiment)} - refitted
    assert left == {'booster.critical_pressure_ratio'}


@pytest.mark.parametrize(('parameter', 'kind', 'part'), [
    ('booster.kind', NO_BOOSTER, 'booster'), ('actuator.kind', VESSEL, 'stem')])
def test_no_effect_is_looked_for_in_a_part_that_is_not_there(parameter, kind, part):
    experiment, less = prepared('commanded'), put(DECLARED, parameter, kind)
    sensor = {name for name in located('sensor') if 'position' in name}
    assert IN_OPEN_LOOP - set(applicable(experiment, less)) == (located(part) | (
        sensor if part == 'stem' else set())) - {'process_force'}
    refitted = [{free.knob.parameter for free in free_to_refit(p, experiment)}
                for p in (DECLARED, less)]
    assert refitted[0] - refitted[1] == {
        'booster': {'booster.opening_gain', 'booster.max_area', 'booster.critical_pressure_ratio'},
        'stem': {'actuator.bench_set', 'actuator.viscous_friction', 'actuator.stop_stiffness'},
    }[part]


def test_a_signature_shows_the_stem_and_its_sensor():
    timed = (located('stem') - {'process_force'}) | {
        'position_backlash', 'position_sensor_lag', 'position_sensor_bias'}
    assert names('signature in time') == timed
    assert names('signature') == timed - {'position_sensor_lag', 'stem_damping'}
    assert names('signature, drop known') - names('signature') == {'process_force'}


@pytest.mark.parametrize(('kind', 'clocked', 'shows'), [
    ('commanded', True, True), ('bench', False, True), ('bench', True, False)])
def test_a_new_effect_that_acts_through_time_is_not_for_a_sweep(monkeypatch, kind, clocked, shows):
    knob = Knob('booster.intake_preload', 0.02, 0.0, 1.0, clocked=clocked)
    shape = Knob('booster.knee_softness', 0.3, 0.0, 1.0, shape=True)
    add_effect(monkeypatch, 'sluggish_seat', 'booster', knob, shape)
    assert ('sluggish_seat' in names(kind)) == shows


@pytest.mark.parametrize(('reading', 'kinds'), [
    ('chamber_pressure', {'commanded', 'isolated'}),
    ('valve_position', {'commanded', 'signature in time', 'signature'}),
])
def test_a_new_effect_of_a_sensor_shows_where_its_reading_is_compared(monkeypatch, reading, kinds):
    knob = Knob('sensors.position_bias', 1e-4, -5e-3, 5e-3)
    add_effect(monkeypatch, 'loose_screw', 'sensor', knob, reading=reading)
    for kind in ('commanded', 'isolated', 'signature in time', 'signature', 'bench'):
        assert ('loose_screw' in names(kind)) == (kind in kinds), kind


def test_effects_of_sensors_and_no_others_have_a_reading():
    assert {name for name, effect in EFFECTS.items() if effect.reading} == located('sensor')


def test_a_bench_shows_the_booster():
    assert names('bench') == located('booster', 'tubing')


def test_an_isolated_chamber_shows_itself():
    assert names('isolated') == (located('chamber', 'stem') - {'process_force'}) | {
        'pressure_sensor_lag', 'pressure_sensor_bias'}


def test_a_stem_far_below_its_bench_set_shows_nothing_unless_it_is_seen():
    shut = DECLARED._replace(actuator=DECLARED.actuator._replace(bench_set=(9e5, 1e6)))
    isolated = prepared('isolated')
    assert not {n for n in applicable(isolated, shut) if EFFECTS[n].location == 'stem'}
    seen = prepared('commanded')
    assert set(applicable(seen, shut)) == IN_OPEN_LOOP


@pytest.mark.parametrize('kind', RECORDS)
def test_parameters_that_are_not_turned_change_nothing(kind):
    experiment = prepared(kind)
    before = experiment.predict(DECLARED)
    turned = set()
    for free in declared_freedom(DECLARED, experiment):
        name = free.knob.parameter
        other = experiment.predict(put(DECLARED, name, free.value(0.5), free.element))
        if not matters(name, experiment):
            for channel, values in before.items():
                assert np.array_equal(values, other[channel]), name
        elif any(not np.array_equal(before[c], other[c], equal_nan=True) for c in before):
            turned.add(name)
    assert turned


def test_tolerances_are_said_in_si_and_parameters_by_how_many_they_moved():
    """A stop is fitted as what it yields; it says of its stiffness the same as the others do."""
    for free in declared_freedom(DECLARED, prepared('commanded')):
        given, little = free.value(0.0), 1e-3
        slope = (free.value(little) - free.value(-little)) / (2.0 * little)
        assert free.spread == pytest.approx(abs(slope), rel=1e-4)
        assert 0.003 * abs(given) < free.spread < 0.31 * abs(given) or given == 0.0
        for z in (free.low, -1.0, 0.5, free.high):
            assert abs(free.away(z)) == pytest.approx(abs(z))
            assert abs(z) < 5.1
            assert free.away(z) * (free.value(z) - given) > 0.0


def test_what_a_flow_bench_finds_has_no_tolerance():
    bench = declared_freedom(DECLARED, prepared('bench'))
    gain = next(free for free in bench if free.knob.parameter == 'booster.opening_gain')
    assert gain.spread is None
    assert gain.away(gain.high) == 0.0


@pytest.mark.parametrize(('columns', 'free'), [
    (timed, {'coulomb_friction', 'stiction', 'presliding_stiffness', 'presliding_damping',
             'stribeck_velocity'}),
    (swept_columns, {'coulomb_friction', 'presliding_stiffness'}),
], ids=['timed', 'swept'])
def test_a_sweep_without_a_clock_says_nothing_of_what_acts_by_speeds(columns, free):
    experiment = prepare(record_of(columns()), DECLARED)
    problem = Problem(experiment, np.ones(len(experiment.time), dtype=bool), DECLARED, ())
    rubs = with_effect(problem, EFFECTS['stem_friction'])
    assert {one.knob.parameter for one in rubs.freedoms} == {f'actuator.{name}' for name in free}


@pytest.mark.parametrize(('role', 'tried'), [('test', False), ('train', True)])
def test_what_the_test_set_alone_shows_decides_nothing(role, tried):
    """A pressure that comes near the bench set there only would have its stem looked into."""
    columns = only('time', 'control_current', 'chamber_pressure')
    experiment = prepare(record_of(columns), DECLARED)
    segments = split(experiment.time, experiment.current)
    pressure = np.full(len(TIME), 50e3)
    pressure[rows_of(segments, role, len(TIME))] = 250e3
    seen = without_test_set(
        replace(experiment, measured={'chamber_pressure': pressure}), segments)
    assert ('stem_friction' in applicable(seen, DECLARED)) == tried
