# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""From a record to an experiment: its rows, its clock, its noise, and channels that are slow."""

from made_diagnosis import DECLARED
from made_record import CHAMBER, POSITION, ROWS, misfits, misses, record_of, step_test
import numpy as np
import pytest

from booster_ros.diagnosis.prepare.preparation import prepare
from booster_ros.diagnosis.prepare.rows import DWELL_FILLED
from booster_ros.model.simulation import simulate
from booster_ros.records import RecordError


def test_too_few_rows_are_refused():
    few = {name: values[:5] for name, values in (CHAMBER | POSITION).items()}
    with pytest.raises(RecordError, match='only 5 rows'):
        prepare(record_of(**few), DECLARED)


@pytest.mark.parametrize('name', ['chamber_pressure', 'valve_position'])
@pytest.mark.parametrize('values', [1, 11])
def test_a_channel_with_too_few_values_is_not_compared_and_cuts_nothing(name, values):
    columns = step_test()
    columns[name][:-values] = np.nan
    experiment = prepare(record_of(**columns), DECLARED)
    assert experiment.channels == tuple({'chamber_pressure', 'valve_position'} - {name})
    assert len(experiment.time) == ROWS
    said = f'{name} is not compared: it has {values} of the 12 values needed'
    assert experiment.notes[:1] == (said,)


def test_where_nothing_rests_it_is_said_that_noise_may_be_larger_than_it_seems():
    columns = step_test()
    said = 'what drives the valve hardly rests'
    moving = prepare(record_of(**columns), DECLARED)
    assert [note for note in moving.notes if note.startswith(said)]
    time = np.arange(0.0, 64.0, 0.05)
    current = 1e-4 * np.array([3.6, 4.3, 3.9, 4.5])[(time // 8.0).astype(int) % 4]
    run = simulate(DECLARED, time, current, {'chamber_pressure': 250e3})
    noise = 150.0 * np.random.default_rng(1).standard_normal(len(time))
    still = prepare(record_of(time=time, control_current=current,
                              chamber_pressure=run['chamber_pressure'] + noise), DECLARED)
    assert not [note for note in still.notes if note.startswith(said)]


def test_where_a_ripple_hides_the_colour_of_noise_the_channel_is_named():
    time = np.arange(0.0, 64.0, 0.02)
    current = 1e-4 * np.array([3.6, 4.3, 3.9, 4.5])[(time // 8.0).astype(int) % 4]
    run = simulate(DECLARED, time, current, {'chamber_pressure': 250e3})
    generator = np.random.default_rng(1)
    pressure, position = (
        run[name] + level * generator.standard_normal(len(time))
        for name, level in {'chamber_pressure': 150.0, 'valve_position': 8e-6}.items())
    prepared = prepare(record_of(
        time=time, control_current=current, valve_position=position,
        chamber_pressure=pressure + 300.0 * np.sin(2.0 * np.pi * 3.0 * time)), DECLARED)
    said = [note for note in prepared.notes if 'taken as white' in note]
    assert len(said) == 1
    assert said[0].startswith('the noise of chamber_pressure is taken as white')


def test_the_prepared_model_of_an_exact_plant_misses_by_the_noise():
    experiment = prepare(record_of(**step_test()), DECLARED)
    assert experiment.noise['chamber_pressure'] == pytest.approx(150.0, rel=0.2)
    assert experiment.noise['valve_position'] == pytest.approx(8e-6, rel=0.2)
    predicted = experiment.predict(DECLARED)
    for name, measured in experiment.measured.items():
        misses = np.std(measured - predicted[name])
        assert misses < 1.3 * experiment.noise[name]


def test_missing_measurements_do_not_count_and_the_others_stay():
    columns = step_test()
    columns['valve_position'][50:80] = np.nan
    experiment = prepare(record_of(**columns), DECLARED)
    missing = np.isnan(experiment.measured['valve_position'])
    assert np.flatnonzero(missing).tolist() == list(range(50, 80))
    assert np.isfinite(experiment.measured['chamber_pressure']).all()


def test_rows_before_the_first_known_drive_are_cut_off():
    columns = step_test()
    columns['chamber_pressure'][:30] = np.nan
    experiment = prepare(record_of(**columns), DECLARED)
    assert len(experiment.time) == ROWS - 30
    assert np.allclose(experiment.time, columns['time'][30:] - columns['time'][30])
    assert 'rows 2 to 31 left out: they lack chamber_pressure' in experiment.notes


def test_a_pressure_that_ends_before_the_record_leaves_the_position_to_be_compared():
    columns = step_test()
    columns['chamber_pressure'][ROWS // 2:] = np.nan
    experiment = prepare(record_of(**columns), DECLARED)
    assert np.isfinite(experiment.measured['valve_position']).all()
    assert np.isfinite(experiment.measured['chamber_pressure']).sum() == ROWS // 2
    assert not any('left out' in note for note in experiment.notes)


def test_rows_after_the_last_known_drive_are_cut_off():
    columns = step_test()
    columns['control_current'][-20:] = np.nan
    columns['time'][-20:] += 30.0  # a command is not held across a gap
    experiment = prepare(record_of(**columns), DECLARED)
    assert len(experiment.time) == ROWS - 20
    assert f'rows {ROWS - 18} to {ROWS + 1} left out: they lack control_current' in experiment.notes


def test_time_counts_from_where_the_record_begins():
    columns = step_test()
    columns['time'] += 5000.0
    experiment = prepare(record_of(**columns), DECLARED)
    assert np.allclose(experiment.time, columns['time'] - 5000.0)
    assert 'time counted from the first row used, at 5000 s' in experiment.notes
    drifting = DECLARED._replace(ep_converter=DECLARED.ep_converter._replace(drift=5e3))
    still, moved = experiment.predict(DECLARED), experiment.predict(drifting)
    change = moved['chamber_pressure'] - still['chamber_pressure']
    assert abs(change[-1]) > 5.0 * abs(change[20])


def test_a_sweep_of_currents_is_compared_after_each_has_stood():
    current = np.linspace(0.42e-3, 0.46e-3, 30)
    settled = []
    for one in current:
        time = np.arange(0.0, 60.0, 0.5)
        settled.append(simulate(DECLARED, time, np.full(len(time), one))['chamber_pressure'][-1])
    record = record_of(control_current=current, chamber_pressure=settled)
    experiment = prepare(record, DECLARED)
    assert np.allclose(np.diff(experiment.time), DWELL_FILLED)
    predicted = experiment.predict(DECLARED)['chamber_pressure']
    assert np.isnan(experiment.measured['chamber_pressure'][0])
    assert np.abs(predicted - settled)[1:].max() < 50.0


@pytest.mark.parametrize(('name', 'every'), [
    ('chamber_pressure', 2), ('chamber_pressure', 5), ('valve_position', 3)])
def test_a_channel_slower_than_the_others_is_as_noisy_as_it_is(name, every):
    """Its rows are those of a bag, or of two tables that a user merged."""
    columns = step_test()
    columns[name][np.arange(ROWS) % every > 0] = np.nan
    for misfit in misfits(columns).values():
        assert 0.6 < misfit < 1.5


def test_a_stem_that_never_moves_is_compared_closely_where_the_model_hardly_does():
    columns = step_test() | {'valve_position': np.zeros(ROWS)}
    stiff = DECLARED._replace(actuator=DECLARED.actuator._replace(bench_set=(4e5, 9e5)))
    experiment = prepare(record_of(**columns), stiff)
    assert experiment.noise['valve_position'] == 1e-7
    assert any('valve_position stands still' in note for note in experiment.notes)


def test_a_sweep_of_back_pressures_gives_the_chamber_time_to_fill():
    back = np.r_[np.linspace(180e3, 255e3, 15), np.linspace(250e3, 185e3, 14)]
    gain = DECLARED.ep_converter.gain
    settled = [simulate(DECLARED, np.arange(0.0, 60.0, 0.5), np.full(120, one / gain))
               ['chamber_pressure'][-1] for one in back]
    experiment = prepare(record_of(back_pressure=back, chamber_pressure=settled), DECLARED)
    assert experiment.drives == ('back_pressure',)
    predicted = experiment.predict(DECLARED)['chamber_pressure']
    assert np.abs(predicted - settled).max() < 400.0  # the last of it takes minutes


def slow(values, first, every=10, noise=150.0):
    """Return a channel that has a noisy value in one of so many rows, from one on."""
    sparse = np.full(len(values), np.nan)
    sparse[first::every] = values[first::every]
    return sparse + noise * np.random.default_rng(first).standard_normal(len(values))


@pytest.mark.parametrize(('drive', 'first'), [
    ('supply_pressure', 0), ('supply_pressure', 3), ('back_pressure', 3)])
def test_slow_channels_need_not_have_their_values_in_the_same_rows(drive, first):
    time = 0.01 * np.arange(6000)
    current = 0.44e-3 + 0.02e-3 * np.abs((time / 15.0) % 2.0 - 1.0)
    run = simulate(DECLARED, time, current, {'chamber_pressure': 230e3})
    commanded = {'control_current': current} if drive == 'supply_pressure' else {}
    experiment = prepare(record_of(
        time=time, **commanded, valve_position=run['valve_position'],
        chamber_pressure=slow(run['chamber_pressure'], 5), **{drive: slow(run[drive], first)},
    ), DECLARED)
    assert len(experiment.time) > 5980
    assert experiment.initial.chamber_pressure == pytest.approx(
        run['chamber_pressure'][len(time) - len(experiment.time)], abs=1500.0)
    assert misses(experiment)['chamber_pressure'] < 1.2


def test_a_drive_that_was_read_once_is_named_where_no_row_is_left_by_it():
    columns = step_test()
    columns['supply_pressure'] = np.r_[400e3, np.full(ROWS - 1, np.nan)]
    with pytest.raises(RecordError, match='lack supply_pressure'):
        prepare(record_of(**columns), DECLARED)


def odd(changed):
    """Return a record in time whose stamps are changed by a function."""
    return record_of(**{**CHAMBER, **POSITION, 'time': changed(0.1 * np.arange(ROWS))})


@pytest.mark.parametrize(('record', 'says'), [
    # a run over it would need hundreds of gigabytes, or end after hours, or with an IndexError
    (lambda: record_of(chamber_pressure=[1e5], valve_position=[0.004]), 'only 1 row, at least 12'),
    (lambda: odd(lambda time: 1e-10 * time), r'rows are 1e-11 s apart, .* time must be in s'),
    (lambda: odd(lambda time: 1e-8 * time), 'rows are 1e-09 s apart'),
    (lambda: odd(lambda time: np.where(time < 20.0, time, time + 86400.0)),
     r'row 202, column time: a gap of 8\.64e\+04 s, longer than all the rest of the record'),
    # a run over it would take minutes, hundreds of them hours
    (lambda: odd(lambda time: 1e5 * time), r'column time: lasts .* time must be in s, or cut'),
])
def test_times_that_no_valve_has_are_refused(record, says):
    with pytest.raises(RecordError, match=says):
        prepare(record(), DECLARED)


def test_a_sweep_that_would_stand_for_days_is_refused():
    rows = 25_000
    back = np.linspace(100e3, 300e3, rows)
    with pytest.raises(RecordError, match=r'lasts 7\.5e\+05 s, .* a sweep needs fewer rows'):
        prepare(record_of(back_pressure=back, chamber_pressure=back, valve_position=1e-8 * back),
                DECLARED)
