# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A set point drives the model through the position controller where nothing below it is known."""

from dataclasses import replace
from pathlib import Path

from made_diagnosis import record_of
import numpy as np
import pytest

from booster_ros.diagnosis.hypotheses.applicable import applicable, free_to_refit
from booster_ros.diagnosis.hypotheses.subsystem import upstream
from booster_ros.diagnosis.pipeline import diagnose
from booster_ros.diagnosis.prepare.preparation import SLOW_PERIOD, TRANSMITTER, prepare
from booster_ros.model.catalogue import EFFECTS
from booster_ros.model.parameters import from_values
from booster_ros.model.simulation import simulate
from booster_ros.parameters.file import read_parameter_file
from booster_ros.records import RecordError

FILE = Path(__file__).parent.parent / 'config' / 'closed_loop.yaml'
DECLARED = from_values(read_parameter_file(FILE).physical)
OPEN = DECLARED._replace(
    position_controller=DECLARED.position_controller._replace(enabled=False))
TRAVEL = DECLARED.actuator.travel
IN_LOOP = {name for name, effect in EFFECTS.items() if effect.location == 'position_controller'}


def columns(apart=0.1, seconds=40.0, more=('chamber_pressure',), **controller):
    """Return what a valve whose controller has these parameters besides does, rows `apart` s."""
    rng = np.random.default_rng(5)
    time = np.arange(0.0, seconds, apart)
    levels = TRAVEL * rng.uniform(0.2, 0.8, len(time))
    set_point = levels[(time / max(3.0, 4.0 * apart)).astype(int)]
    valve = DECLARED._replace(
        position_controller=DECLARED.position_controller._replace(**controller))
    held = {'chamber_pressure': 150e3 * (1.0 + set_point[0] / TRAVEL)}
    run = simulate(valve, time, set_point, held)
    noise = {'chamber_pressure': 150.0, 'valve_position': 8e-6}
    seen = {name: run[name] + noise[name] * rng.standard_normal(len(time))
            for name in (*more, 'valve_position')}
    return {'time': time, 'set_point': set_point, **seen}


def prepared(p=DECLARED, **arguments):
    return prepare(record_of(columns(**arguments)), p)


def test_a_set_point_drives_where_the_controller_is_declared():
    experiment = prepared()
    assert experiment.drives == ('set_point',)
    assert experiment.channels == ('chamber_pressure', 'valve_position')
    assert set(applicable(experiment, DECLARED)) == set(EFFECTS) - {
        'process_force', 'integrating_firmware'}
    assert 'position_controller.gain' in {
        free.knob.parameter for free in free_to_refit(DECLARED, experiment)}
    for name, values in experiment.predict(DECLARED).items():
        assert np.std(experiment.measured[name] - values) < 1.3 * experiment.noise[name]


def test_beside_a_measured_stem_an_integral_part_would_run_away():
    assert upstream(prepared(seconds=60.0)) is None


def test_without_a_declared_controller_the_pressure_drives_as_before():
    experiment = prepared(OPEN)
    assert experiment.drives == ('chamber_pressure',)
    assert not IN_LOOP & {*applicable(experiment, OPEN)}
    assert any('set_point is read and not used' in note for note in experiment.notes)
    with pytest.raises(RecordError, match=r'position_controller\.enabled: true in the parameters'):
        prepared(OPEN, more=())


def test_beside_a_current_a_set_point_is_idle_and_the_controller_is_off():
    seen = columns(seconds=20.0)
    seen['control_current'] = np.linspace(0.40e-3, 0.44e-3, len(seen['time']))
    loop, bare = (prepare(record_of(seen), p) for p in (DECLARED, OPEN))
    assert loop.drives == ('control_current',)
    assert not IN_LOOP & {*applicable(loop, DECLARED)}
    for name, values in bare.predict(OPEN).items():
        np.testing.assert_array_equal(loop.predict(DECLARED)[name], values)


def test_slow_rows_ask_for_what_they_tell_and_say_what_they_hide():
    experiment = prepared(apart=1.0, seconds=200.0, more=())
    assert experiment.is_slow
    assert not free_to_refit(DECLARED, experiment)
    tried = set(applicable(experiment, DECLARED))
    assert {'slew_limit', 'positioner_dead_zone', 'position_sensor_bias'} < tried
    assert {EFFECTS[name].location for name in tried} <= {'position_controller', 'sensor', 'stem'}
    assert any('not where below the controller' in note for note in experiment.notes)
    # a longer period is taken, and what that changes is noise
    assert DECLARED.position_controller.period < experiment.least_period == SLOW_PERIOD
    fine = replace(experiment, least_period=0.0, tolerance=1.0)
    both = (one.predict(DECLARED)['valve_position'] for one in (fine, experiment))
    changed = np.std(np.subtract(*both))
    assert 0.0 < changed < 2.0 * TRANSMITTER * TRAVEL
    assert changed < experiment.noise['valve_position'] <= np.hypot(changed, TRANSMITTER * TRAVEL)


def test_a_slew_limit_is_found_in_rows_of_a_second():
    experiment = prepared(apart=1.0, seconds=60.0, more=(), rate_limit_up=2.4e-3,
                          rate_limit_down=0.8e-3)
    found = diagnose(experiment, DECLARED, names=('slew_limit',))
    assert [effect.name for effect in found.effects] == ['slew_limit']
    up, down = (found.effects[0].parameters[f'position_controller.rate_limit_{way}'].value
                for way in ('up', 'down'))
    assert up == pytest.approx(2.4e-3, rel=0.02)
    assert down == pytest.approx(0.8e-3, rel=0.02)
    assert found.effects[0].location == 'position_controller'
