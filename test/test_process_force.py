# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A measured pressure drop over the process valve drives the stem, and nothing above it."""

from dataclasses import replace

from made_diagnosis import DECLARED, record_of
from made_task import STEPS, problem_of
import numpy as np
import pytest

from booster_ros.diagnosis.data.experiment import LONGEST_INTERVAL
from booster_ros.diagnosis.estimation.fit import fit_at
from booster_ros.diagnosis.estimation.parametrisation import put
from booster_ros.diagnosis.hypotheses.applicable import applicable
from booster_ros.diagnosis.hypotheses.subsystem import upstream
from booster_ros.diagnosis.pipeline import diagnose
from booster_ros.diagnosis.prepare.preparation import prepare
from booster_ros.diagnosis.selection.screening import references
from booster_ros.model.actuator import VESSEL
from booster_ros.model.simulation import simulate

PLUG = 2e-3
PUSHED = put(DECLARED, 'actuator.plug_area', PLUG)
TIME = np.arange(0.0, 60.0, 0.05)
SWEEP = 225e3 + 60e3 * np.interp(TIME, np.arange(0.0, 61.0, 6.0), [
    0.0, 1.0, -0.6, 0.4, -1.0, 0.8, -0.2, 0.6, -0.8, 1.0, 0.0])
DROPS = np.array([1e5, 4e5, 2e5, 5e5, 0.0, 3e5, 6e5, 2e5, 4e5, 1e5])[(TIME // 6.0).astype(int)]


def signature(plant, faster=1.0):
    """Return what a stem does under a moving pressure and a stepping drop, with noise of both."""
    time = TIME / faster
    run = simulate(plant, time, np.zeros_like(time),
                   pinned={'chamber_pressure': SWEEP, 'pressure_drop': DROPS})
    noise = np.random.default_rng(1).standard_normal((3, len(TIME)))
    return {'time': time, 'chamber_pressure': SWEEP + 150.0 * noise[0],
            'valve_position': run['valve_position'] + 8e-6 * noise[1],
            'pressure_drop': DROPS + 500.0 * noise[2]}


def commanded(plant, drop=DROPS):
    """Return what a valve does at steps of its current while a pressure drop pushes its stem."""
    current = 1e-4 * STEPS[(TIME // 5.0).astype(int)]
    run = simulate(plant, TIME, current, {'chamber_pressure': 1.7e5}, {'pressure_drop': drop})
    noise = np.random.default_rng(1).standard_normal((3, len(TIME)))
    return {'time': TIME, 'control_current': current,
            'chamber_pressure': run['chamber_pressure'] + 150.0 * noise[0],
            'valve_position': run['valve_position'] + 8e-6 * noise[1],
            'pressure_drop': drop + 500.0 * noise[2]}


def without(columns, *names):
    return {name: values for name, values in columns.items() if name not in names}


def told(area, *names):
    """Return what is said of a quick record of a stem with a plug of this area."""
    columns = signature(put(DECLARED, 'actuator.plug_area', area), 5.0)
    record = record_of({name: values[::2] for name, values in columns.items()})
    return diagnose(prepare(record, DECLARED), DECLARED, names=names, places=frozenset())


@pytest.mark.campaign
def test_the_area_on_which_the_process_pushes_is_found():
    (effect,) = told(-PLUG, 'process_force', 'bench_set_shift').effects
    assert (effect.name, effect.location) == ('process_force', 'stem')
    size = effect.parameters['actuator.plug_area']
    assert size.low < -PLUG < size.high
    assert size.value == pytest.approx(-PLUG, rel=0.02)
    assert (effect.standing, effect.confused_with) == ('confirmed', ())


@pytest.mark.campaign
def test_a_drop_that_pushes_nothing_is_no_effect():
    assert told(0.0, 'process_force').verdict == 'none'


def test_a_record_without_the_drop_is_judged_as_ever():
    columns = {name: values[:600:2] for name, values in signature(PUSHED).items()}
    experiment = prepare(record_of(without(columns, 'pressure_drop')), DECLARED)
    assert experiment.drives == ('chamber_pressure',)
    assert 'process_force' not in applicable(experiment, DECLARED)
    with_drop = prepare(record_of(columns), DECLARED)
    assert set(applicable(with_drop, DECLARED)) - set(applicable(experiment, DECLARED)) == {
        'process_force'}
    for name, values in experiment.predict(DECLARED).items():
        assert np.array_equal(values, with_drop.predict(DECLARED)[name])
        missed = experiment.measured[name] - values
        assert np.std(missed) > 20.0 * experiment.noise[name]
        left = with_drop.measured[name] - with_drop.predict(PUSHED)[name]
        assert np.std(left) < 1.2 * with_drop.noise[name]


@pytest.mark.parametrize(('drop', 'tried'), [
    (DROPS, True), (DROPS / 1e3, False), (np.full_like(TIME, 3e5), False)])
def test_a_drop_that_stands_still_is_not_told_from_a_shifted_spring(drop, tried):
    experiment = prepare(record_of(commanded(DECLARED, drop)), DECLARED)
    assert experiment.drives == ('control_current', 'pressure_drop')
    assert ('process_force' in applicable(experiment, DECLARED)) == tried


def test_a_drop_leaves_what_is_above_the_stem_to_be_judged():
    columns = {name: values[:600:2] for name, values in commanded(PUSHED).items()}
    experiment = prepare(record_of(columns), DECLARED)
    bare = prepare(record_of(without(columns, 'pressure_drop')), DECLARED)
    assert experiment.noise == pytest.approx(bare.noise, rel=1e-3)
    above, as_ever = upstream(experiment), upstream(bare)
    assert set(above.pinned) == {'valve_position', 'stem_velocity'}
    for name, values in as_ever.predict(DECLARED).items():
        assert np.array_equal(values, above.predict(DECLARED, as_ever.initial)[name])
    # rests are explained by what is told at rest, and intervals are as long as with a current alone
    problem = problem_of(experiment)
    assert len(references(problem, fit_at(problem, problem.start()))) == len(references(
        problem_of(bare), fit_at(problem_of(bare), problem.start())))
    slow = replace(experiment, time=10.0 * experiment.time)
    assert slow._longest_interval() == LONGEST_INTERVAL


def test_thinned_rows_hold_the_jumps_of_a_drop():
    experiment = prepare(record_of(commanded(PUSHED)), DECLARED)
    thin, kept = experiment.thinned(20)
    assert len(kept) < len(TIME) / 5
    whole, fewer = experiment.predict(PUSHED), thin.predict(PUSHED)
    assert np.std(fewer['valve_position'] - whole['valve_position'][kept]) < 10e-6


def test_the_start_is_that_of_a_stem_that_is_pushed():
    """Without a pressure the spring and the process tell where the chamber starts."""
    for controlled in (False, True):
        p = PUSHED._replace(position_controller=PUSHED.position_controller._replace(
            enabled=controlled))
        held = 225e3 + PLUG * DROPS[0] / p.actuator.effective_area
        command = {'set_point' if controlled else 'control_current': np.full_like(
            TIME, 8e-3 if controlled else 0.44e-3)}
        experiment = prepare(record_of({
            'time': TIME, **command, 'pressure_drop': DROPS,
            'valve_position': 8e-3 + 1e-6 * np.sin(TIME)}), p)
        assert experiment.initial.chamber_pressure == pytest.approx(held, abs=50.0)
        assert experiment.predict(p)['valve_position'][0] == pytest.approx(8e-3, abs=5e-6)


def test_a_drop_that_was_not_read_for_a_while_is_bridged_and_slow_samples_are_no_gap():
    columns = {name: values[:700] for name, values in signature(PUSHED).items()}
    columns['pressure_drop'][1::4] = columns['pressure_drop'][2::4] = np.nan
    columns['pressure_drop'][500:600] = np.nan
    experiment = prepare(record_of(columns), DECLARED)
    known = np.isfinite(experiment.measured['valve_position'])
    assert known[:490].all()
    assert not known[505:595].any()
    assert np.isfinite(experiment.pinned['pressure_drop']).all()


def test_a_vessel_has_nothing_to_push():
    columns = without(commanded(DECLARED), 'valve_position')
    experiment = prepare(record_of(columns), put(DECLARED, 'actuator.kind', VESSEL))
    assert experiment.drives == ('control_current',)
    assert any('pressure_drop is read and not used' in note for note in experiment.notes)
