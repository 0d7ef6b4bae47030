# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""From a record to an experiment: who drives, who is compared, which rows count, the start."""

import numpy as np
import pytest

from booster_ros.diagnosis.experiment.experiment import DriveNoise
from booster_ros.diagnosis.experiment.noise_colour import Noise
from booster_ros.diagnosis.preparing.gaps import SETTLING
from booster_ros.diagnosis.preparing.preparation import DWELL_FILLED, prepare
from booster_ros.model.simulation import simulate
from booster_ros.model.system import PositionerParameters
from booster_ros.records import RecordError, read_record
from booster_ros.records.cleaning import clean

DECLARED = PositionerParameters()
SHUT = DECLARED._replace(booster=DECLARED.booster._replace(opening_gain=0.0))
ROWS = 400


def record_of(**columns):
    """Return the cleaned record of these columns; a missing row count is filled with ROWS."""
    arrays = {name: np.array(values, dtype=float) for name, values in columns.items()}
    size = len(next(iter(arrays.values())))
    return clean(arrays, np.arange(2, size + 2), 'plant.csv')


def step_test(seed=1):
    """Return time, current, chamber pressure and position of a noisy step from mid travel."""
    time = 0.1 * np.arange(ROWS)
    current = np.where(time < 10.0, 0.43e-3, 0.45e-3)
    run = simulate(DECLARED, time, current, {'chamber_pressure': 215e3})
    rng = np.random.default_rng(seed)
    return {
        'time': time, 'control_current': current,
        'chamber_pressure': run['chamber_pressure'] + 150.0 * rng.standard_normal(ROWS),
        'valve_position': run['valve_position'] + 8e-6 * rng.standard_normal(ROWS),
    }


RAMP = np.linspace(20e3, 320e3, ROWS)
TIME = {'time': 0.1 * np.arange(ROWS)}
POSITION = {'valve_position': np.linspace(0.0, 0.016, ROWS)}
CHAMBER = {'chamber_pressure': RAMP}
BACK = {'back_pressure': 180e3 + 0.2 * RAMP}
SUPPLY = {'supply_pressure': np.full(ROWS, 400e3)}
FLOW = {'mass_flow': np.linspace(0.0, 1e-3, ROWS)}
CURRENT = {'control_current': np.linspace(0.40e-3, 0.46e-3, ROWS)}
NO_CURRENT = {'control_current': np.zeros(ROWS)}


@pytest.mark.parametrize(('columns', 'pinned', 'compared'), [
    (TIME | CURRENT | CHAMBER | POSITION, (), ('chamber_pressure', 'valve_position')),
    (TIME | CURRENT | BACK | SUPPLY | CHAMBER, ('supply_pressure',),
     ('back_pressure', 'chamber_pressure')),
    (TIME | BACK | CHAMBER | POSITION, ('back_pressure',), ('chamber_pressure', 'valve_position')),
    (TIME | BACK | FLOW | CHAMBER, ('back_pressure',), ('mass_flow', 'chamber_pressure')),
    (BACK | FLOW | CHAMBER | SUPPLY, ('back_pressure', 'chamber_pressure', 'supply_pressure'),
     ('mass_flow',)),
    (TIME | CHAMBER | POSITION, ('chamber_pressure',), ('valve_position',)),
    (CHAMBER | POSITION, ('chamber_pressure',), ('valve_position',)),
])
def test_the_most_upstream_channels_drive_and_the_others_are_compared(columns, pinned, compared):
    experiment = prepare(record_of(**columns), DECLARED)
    assert tuple(experiment.pinned) == pinned
    assert experiment.channels == compared
    assert np.ptp(experiment.current) == (np.ptp(CURRENT['control_current'])
                                          if 'control_current' in columns else 0.0)
    assert experiment.quasi_static == ('time' not in columns)


@pytest.mark.parametrize(('columns', 'pinned', 'compared'), [
    (TIME | CHAMBER, (), ('chamber_pressure',)),
    (TIME | CHAMBER | SUPPLY, ('supply_pressure',), ('chamber_pressure',)),
    (TIME | NO_CURRENT | CHAMBER | POSITION, (), ('chamber_pressure', 'valve_position')),
])
def test_a_record_that_nothing_drives_is_of_a_chamber_that_is_declared_shut(
        columns, pinned, compared):
    experiment = prepare(record_of(**columns), SHUT)
    assert tuple(experiment.pinned) == pinned
    assert experiment.channels == compared
    with pytest.raises(RecordError, match=r'^plant\.csv: nothing drives the model'):
        prepare(record_of(**columns), DECLARED)


@pytest.mark.parametrize('columns', [
    TIME | CURRENT, TIME | POSITION, TIME | FLOW, TIME | SUPPLY, CHAMBER, BACK | SUPPLY,
    CURRENT | SUPPLY,
])
def test_a_record_without_a_drive_and_a_response_is_refused_in_one_sentence(columns):
    with pytest.raises(RecordError, match=r'^plant\.csv: nothing can be compared') as caught:
        prepare(record_of(**columns), DECLARED)
    for name in columns.keys() - {'time'}:
        assert name in str(caught.value)


def test_a_column_that_was_ignored_may_be_the_one_that_lacks(tmp_path):
    """A name that is nearly one of a record's is asked for where nothing can be compared."""
    csv = tmp_path / 'plant.csv'
    csv.write_text('time,control_current,chamber_presure,pos_mm\n' + ''.join(
        f'{row / 10},0.0004,{1000 * row},{row}\n' for row in range(40)))
    with pytest.raises(RecordError) as caught:
        prepare(read_record(csv), DECLARED)
    sentence = str(caught.value)
    assert 'has control_current, and nothing downstream of that to compare' in sentence
    assert 'column chamber_presure: not a column of a record, ignored (is it chamber_pressure?)' \
        in sentence
    assert 'column pos_mm' in sentence


def test_flow_without_a_known_opening_is_left_out_and_that_is_said():
    experiment = prepare(record_of(**TIME, **CHAMBER, **POSITION, **FLOW), DECLARED)
    assert experiment.channels == ('valve_position',)
    assert any('mass_flow is not compared' in note for note in experiment.notes)


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
    assert experiment.notes == (said,)


def test_the_prepared_model_of_an_exact_plant_misses_by_the_noise():
    experiment = prepare(record_of(**step_test()), DECLARED)
    assert experiment.noise['chamber_pressure'] == pytest.approx(150.0, rel=0.2)
    assert experiment.noise['valve_position'] == pytest.approx(8e-6, rel=0.2)
    predicted = experiment.predict(DECLARED)
    for name, measured in experiment.measured.items():
        misses = np.std(measured - predicted[name])
        assert misses < 1.3 * experiment.noise[name]


def test_a_resting_start_is_averaged_and_a_moving_one_is_taken_as_it_is():
    columns = step_test()
    still = prepare(record_of(**columns), DECLARED).initial
    assert still.chamber_pressure == pytest.approx(np.mean(columns['chamber_pressure'][:5]))
    assert still.valve_position == pytest.approx(np.mean(columns['valve_position'][:5]))
    columns['chamber_pressure'] = columns['chamber_pressure'] - 400.0 * np.arange(ROWS)[::-1]
    moving = prepare(record_of(**columns), DECLARED).initial
    assert moving.chamber_pressure == columns['chamber_pressure'][0]


def test_without_a_pressure_the_spring_tells_where_the_chamber_starts():
    columns = step_test()
    measured = columns.pop('chamber_pressure')
    start = prepare(record_of(**columns), DECLARED).initial
    assert start.chamber_pressure == pytest.approx(np.mean(measured[:5]), abs=500.0)


@pytest.mark.parametrize(('position', 'current', 'low', 'high'), [
    (0.0, 0.30e-3, 0.0, 150e3),  # vented against the lower stop
    (0.016, 0.48e-3, 300e3, 400e3),  # filled against the upper stop
])
def test_at_a_stop_the_booster_tells_where_the_chamber_starts(position, current, low, high):
    record = record_of(
        time=TIME['time'], control_current=np.full(ROWS, current),
        valve_position=np.full(ROWS, position) + 1e-6 * np.sin(np.arange(ROWS)))
    assert low <= prepare(record, DECLARED).initial.chamber_pressure <= high


def test_a_back_pressure_that_begins_later_does_not_tell_where_the_chamber_starts():
    columns = step_test()
    del columns['chamber_pressure']
    columns['valve_position'][:] = 0.0
    columns['back_pressure'] = np.full(ROWS, 200e3)
    columns['back_pressure'][::2] = np.nan
    experiment = prepare(record_of(**columns), DECLARED)
    assert np.isfinite(experiment.initial.chamber_pressure)
    assert np.isfinite(experiment.predict(DECLARED)['back_pressure']).all()


def test_missing_measurements_do_not_count_and_the_others_stay():
    columns = step_test()
    columns['valve_position'][50:80] = np.nan
    experiment = prepare(record_of(**columns), DECLARED)
    missing = np.isnan(experiment.measured['valve_position'])
    assert np.flatnonzero(missing).tolist() == list(range(50, 80))
    assert np.isfinite(experiment.measured['chamber_pressure']).all()


def test_rows_after_a_gap_of_the_drive_do_not_count_until_the_chamber_has_caught_up():
    columns = step_test()
    kept = np.r_[0:150, 200:ROWS]
    gapped = {name: values[kept] for name, values in columns.items()}
    experiment = prepare(record_of(**gapped), DECLARED)
    counted = np.isfinite(experiment.measured['chamber_pressure'])
    resumed = experiment.time[150]
    assert counted[experiment.time < resumed].all()
    assert not counted[150:][experiment.time[150:] < resumed + SETTLING].any()
    assert any('gaps of control_current' in note for note in experiment.notes)


def test_a_gap_in_a_pinned_drive_is_bridged_by_a_straight_line_that_does_not_count():
    pressure = RAMP.copy()
    pressure[100:150] = np.nan
    experiment = prepare(record_of(**TIME, chamber_pressure=pressure, **POSITION), DECLARED)
    assert np.allclose(experiment.pinned['chamber_pressure'], RAMP)
    counted = np.isfinite(experiment.measured['valve_position'])
    assert not counted[100:250].any()
    assert counted[:100].all()
    assert counted[250:].all()


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


def fast(current_after, gap=7):
    """Return a record at 100 Hz with some rows missing, and the index of the row after them."""
    time = 0.01 * np.arange(4000)
    current = np.where(time < 10.0, 0.43e-3, 0.45e-3)
    current[time >= 20.0] = current_after
    run = simulate(DECLARED, time, current, {'chamber_pressure': 215e3})
    kept = np.ones(4000, dtype=bool)
    kept[2000 - gap:2000] = False
    columns = {'time': time, 'control_current': current, **{
        name: run[name] for name in ('chamber_pressure', 'valve_position')}}
    return record_of(**{name: values[kept] for name, values in columns.items()}), 2000 - gap


@pytest.mark.parametrize(('current_after', 'gap', 'counts'), [
    (0.45e-3, 7, True), (0.4501e-3, 7, True), (0.43e-3, 7, False), (0.45e-3, 100, False)])
def test_rows_after_a_short_gap_count_where_the_drive_stands_as_before_it(
        current_after, gap, counts):
    record, row = fast(current_after, gap)
    experiment = prepare(record, DECLARED)
    assert np.isfinite(experiment.measured['chamber_pressure'][row:row + 500]).all() == counts
    assert np.isfinite(experiment.measured['chamber_pressure'][:row]).all()


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


def test_a_current_that_is_none_throughout_a_sweep_did_not_drive_it():
    by_hand = {**CHAMBER, **POSITION}
    experiment = prepare(record_of(control_current=np.zeros(ROWS), **by_hand), DECLARED)
    assert experiment.drives == ('chamber_pressure',)
    assert experiment.channels == ('valve_position',)
    assert any('control_current is 0 A in every row' in note for note in experiment.notes)
    with pytest.raises(RecordError, match='nothing can be compared'):
        prepare(record_of(control_current=np.zeros(ROWS), **POSITION), DECLARED)
    started = np.where(np.arange(ROWS) > 0, 0.0, 0.4e-3)  # the first row only begins
    experiment = prepare(record_of(control_current=started, **by_hand), DECLARED)
    assert experiment.drives == ('chamber_pressure',)


def test_a_position_beside_the_flow_of_a_bench_is_left_out_and_that_is_said():
    experiment = prepare(record_of(**BACK, **FLOW, **CHAMBER, **SUPPLY, **POSITION), DECLARED)
    assert experiment.channels == ('mass_flow',)
    assert any('valve_position is not compared' in note for note in experiment.notes)


@pytest.mark.parametrize('name', ['opening_gain', 'max_area'])
def test_a_flow_bench_is_refused_where_the_declared_booster_has_no_flow(name):
    shut = DECLARED._replace(booster=DECLARED.booster._replace(**{name: 0.0}))
    with pytest.raises(RecordError, match=f'booster.{name} must be above 0'):
        prepare(record_of(**BACK, **FLOW, **CHAMBER, **SUPPLY), shut)


def test_a_sweep_in_absolute_pressure_is_refused():
    stem = 0.016 * np.clip((RAMP - 150e3) / 150e3, 0.0, 1.0)
    prepare(record_of(valve_position=stem, **CHAMBER), DECLARED)
    with pytest.raises(RecordError, match='looks like absolute pressure'):
        prepare(record_of(valve_position=stem, chamber_pressure=RAMP + 101_325.0), DECLARED)


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


def test_noise_of_a_measured_drive_counts_as_noise_of_what_it_drives():
    columns = step_test()
    del columns['control_current']
    experiment = prepare(record_of(**columns), DECLARED)
    spring = DECLARED.actuator.travel / 150e3  # m/Pa
    assert experiment.noise['valve_position'] > 0.8 * np.hypot(8e-6, 150.0 * spring)


def misfits(columns):
    """Return the mean square of what the true model misses, in squares of the noise found."""
    experiment = prepare(record_of(**columns), DECLARED)
    predicted = experiment.predict(DECLARED)
    return {name: float(np.nanmean(((values - predicted[name]) / experiment.noise[name])**2))
            for name, values in experiment.measured.items()}


def driven_by_its_back_pressure(noise, seed=1):
    """Return two minutes of stairs of which the current was not recorded, its drive with noise."""
    rng = np.random.default_rng(seed)
    time = 0.01 * np.arange(12_000)
    current = rng.uniform(0.34e-3, 0.46e-3, 20)[(time // 6.0).astype(int)]
    run = simulate(DECLARED, time, current, {'chamber_pressure': 170e3})
    return {'time': time, 'back_pressure': noise.added_to(run['back_pressure'], rng),
            'chamber_pressure': run['chamber_pressure'] + 150.0 * rng.standard_normal(len(time)),
            'valve_position': run['valve_position'] + 8e-6 * rng.standard_normal(len(time))}


@pytest.mark.parametrize('noise', [Noise(400.0), Noise(150.0, 0.5), Noise(150.0, 0.9)])
def test_noise_of_a_drive_is_as_loud_and_as_coloured_as_it_is(noise):
    """Loud noise shifts what two unlike seats settle to, slow noise reaches the chamber."""
    columns = driven_by_its_back_pressure(noise)
    drive = prepare(record_of(**columns), DECLARED).drive_noise['back_pressure']
    assert drive.level == pytest.approx(noise.level, rel=0.05)
    assert drive.correlation == pytest.approx(noise.correlation, abs=0.05)
    for misfit in misfits(columns).values():
        assert 0.9 < misfit < 1.3


def test_thinned_rows_let_no_more_of_the_noise_of_a_drive_through():
    experiment = prepare(record_of(**driven_by_its_back_pressure(Noise(150.0))), DECLARED)
    thin, _ = experiment.thinned(8)
    left = thin.measured['chamber_pressure'] - thin.predict(DECLARED)['chamber_pressure']
    assert np.mean((left / thin.noise['chamber_pressure'])**2) < 1.3


@pytest.mark.parametrize(('every', 'correlation'), [(1, 0.0), (8, 0.0), (1, 0.9)])
def test_noise_of_a_drive_that_is_drawn_is_that_of_its_samples(every, correlation):
    drawn = DriveNoise(100.0, every, correlation).draw(40_000, np.random.default_rng(1))
    assert len(drawn) == 40_000
    samples = drawn[::every]
    assert np.std(samples) == pytest.approx(100.0, rel=0.05)
    assert np.corrcoef(samples[1:], samples[:-1])[0, 1] == pytest.approx(correlation, abs=0.05)
    if every > 1:
        halfway = drawn[every // 2::every]
        assert halfway[:-1] == pytest.approx(0.5 * (samples[1:] + samples[:-1])[:len(halfway) - 1])


@pytest.mark.parametrize('every', [1, 2, 5])
def test_a_drive_slower_than_the_rows_is_as_noisy_as_it_is(every):
    columns = step_test()
    del columns['control_current']
    columns['chamber_pressure'][np.arange(ROWS) % every > 0] = np.nan
    (misfit,) = misfits(columns).values()
    assert 0.6 < misfit < 1.7


def test_levels_between_which_a_drive_steps_are_no_noise():
    supply = np.full(ROWS, 400e3)
    constant = prepare(record_of(**step_test(), supply_pressure=supply), DECLARED)
    supply[ROWS // 2:] = 410e3
    stepped = prepare(record_of(**step_test(), supply_pressure=supply), DECLARED)
    assert stepped.noise == pytest.approx(constant.noise, rel=1e-3)
    assert stepped.drive_noise == constant.drive_noise


def test_drives_of_a_sweep_have_no_noise_that_could_be_told():
    """On a bench supply and back pressure stand at a few levels each."""
    levels = np.repeat([100e3, 150e3, 200e3], ROWS // 3)
    rows = {name: values[:len(levels)] for name, values in (BACK | CHAMBER | FLOW).items()}
    assert prepare(record_of(**rows, supply_pressure=levels), DECLARED).drive_noise == {}


def test_thinned_rows_hold_the_jumps_of_a_measured_drive():
    time = 0.01 * np.arange(4000)
    current = np.where(time % 8.0 < 4.0, 0.43e-3, 0.45e-3)
    declared = DECLARED._replace(ep_converter=DECLARED.ep_converter._replace(time_constant=1e-3))
    run = simulate(declared, time, current, {'chamber_pressure': 215e3})
    back = run['back_pressure'] + 100.0 * np.random.default_rng(2).standard_normal(len(time))
    experiment = prepare(record_of(
        time=time, back_pressure=back, chamber_pressure=run['chamber_pressure'],
        valve_position=run['valve_position']), declared)
    thin, kept = experiment.thinned(8)
    assert len(kept) < len(time) / 7
    whole, fewer = experiment.predict(declared), thin.predict(declared)
    for name, apart in (('chamber_pressure', 100.0), ('valve_position', 10e-6)):
        assert np.std(fewer[name] - whole[name][kept]) < apart


@pytest.mark.parametrize(('name', 'every'), [
    ('chamber_pressure', 2), ('chamber_pressure', 5), ('valve_position', 3)])
def test_a_channel_slower_than_the_others_is_as_noisy_as_it_is(name, every):
    """Its rows are those of a bag, or of two tables that a user merged."""
    columns = step_test()
    columns[name][np.arange(ROWS) % every > 0] = np.nan
    for misfit in misfits(columns).values():
        assert 0.6 < misfit < 1.5


def test_thinned_rows_hold_every_channel_wherever_its_samples_are():
    columns = step_test()
    columns['chamber_pressure'][1::2] = np.nan
    columns['valve_position'][0::2] = np.nan
    columns['chamber_pressure'][0] = 0.0
    thin, kept = prepare(record_of(**columns), DECLARED).thinned(8)
    assert kept[0] == 0
    assert len(kept) < ROWS / 7
    for values in thin.measured.values():
        assert np.isfinite(values).sum() > 0.4 * len(kept)


def test_what_the_solver_leaves_is_noise_in_a_record_without_noise():
    time = 0.02 * np.arange(1500)
    current = np.where(time % 8.0 < 4.0, 0.43e-3, 0.45e-3)
    run = simulate(DECLARED, time, current, {'chamber_pressure': 215e3})
    experiment = prepare(record_of(
        time=time, control_current=current, chamber_pressure=run['chamber_pressure'].round(3),
        valve_position=run['valve_position'].round(9)), DECLARED)
    thin, _ = experiment.thinned(8)
    predicted = thin.predict(DECLARED)
    for name, values in thin.measured.items():
        assert np.mean(((values - predicted[name]) / thin.noise[name])**2) < 0.5
    assert experiment.notes == ()


def test_a_stem_that_never_moves_is_compared_closely_where_the_model_hardly_does():
    columns = step_test() | {'valve_position': np.zeros(ROWS)}
    stiff = DECLARED._replace(actuator=DECLARED.actuator._replace(bench_set=(4e5, 9e5)))
    experiment = prepare(record_of(**columns), stiff)
    assert experiment.noise['valve_position'] == 1e-7
    assert any('valve_position stands still' in note for note in experiment.notes)


def test_a_drive_slower_than_the_rows_is_no_gap_but_in_its_own_gaps():
    supply = np.full(ROWS, np.nan)
    supply[::4] = 400e3 + 1e3 * TIME['time'][::4]
    supply[100:140] = np.nan
    experiment = prepare(record_of(**TIME, **BACK, **CHAMBER, supply_pressure=supply), DECLARED)
    known = np.isfinite(experiment.measured['chamber_pressure'])
    assert known[:97].all()
    assert not known[98:139].any()
    np.testing.assert_allclose(
        experiment.pinned['supply_pressure'][:97], 400e3 + 1e3 * TIME['time'][:97])


def test_commands_between_the_stamps_of_another_clock_are_no_effect():
    """A record without noise; each command is taken up to half a row before or after its row."""
    rng = np.random.default_rng(3)
    fine = 0.001 * np.arange(40_000)
    wanted = np.where(fine % 4.0 < 2.0, 0.43e-3, 0.45e-3)
    taken = wanted.copy()
    for change in np.flatnonzero(np.diff(wanted)) + 1:
        by = int(rng.integers(-5, 6))
        taken[min(change, change + by):max(change, change + by)] = wanted[change - (by > 0)]
    run = simulate(DECLARED, fine, taken, {'chamber_pressure': 170e3})
    rows = np.arange(0, 40_000, 10) + rng.integers(0, 3, 4000)
    columns = {'time': fine, 'control_current': wanted,
               'chamber_pressure': run['chamber_pressure'], 'valve_position': run['valve_position']}
    for misfit in misfits({name: values[rows] for name, values in columns.items()}).values():
        assert 0.1 < misfit < 2.0


def test_a_record_that_begins_with_its_first_command_starts_with_the_converter_where_it_was():
    time = 0.01 * np.arange(2000)
    current = np.where(time < 10.0, 0.43e-3, 0.45e-3)
    before = np.concatenate(([0.35e-3], current[:-1]))
    run = simulate(DECLARED, time, before, {'chamber_pressure': 50e3})
    experiment = prepare(record_of(
        time=time[1:], control_current=current[1:], chamber_pressure=run['chamber_pressure'][1:],
        valve_position=run['valve_position'][1:]), DECLARED)
    at_first = run['back_pressure'][1] - run['back_pressure'][900]
    assert experiment.initial.departure.back_pressure == pytest.approx(at_first, abs=2e3)
    assert any('had not settled at the first command' in note for note in experiment.notes)
    assert prepare(record_of(**step_test()), DECLARED).initial.departure.back_pressure == 0.0


def test_a_vented_valve_says_nothing_of_where_its_converter_starts():
    time = 0.01 * np.arange(1000)
    current = np.where(time < 5.0, 0.0, 0.43e-3)
    run = simulate(DECLARED, time, current)
    experiment = prepare(record_of(
        time=time, control_current=current, chamber_pressure=run['chamber_pressure']), DECLARED)
    assert experiment.initial.departure.back_pressure == 0.0
    assert not any('had not settled' in note for note in experiment.notes)


@pytest.mark.parametrize(('column', 'wrong', 'says'), [
    ('chamber_pressure', lambda p: p + 101_325.0, 'looks like absolute pressure'),
    ('chamber_pressure', lambda p: 0.01 * p, 'from mbar'),
    ('valve_position', lambda x: x / 0.016, 'declared travel is 0.016 m'),
    ('valve_position', lambda x: 0.1 * x + 0.09, 'declared travel is 0.016 m'),
    ('valve_position', lambda x: -x, 'reverse its sign'),
    ('control_current', lambda i: 0.004 + 16.0 * i, 'the supply has 4e+05'),
    ('time', lambda t: 1e3 * t, 'if they are 100 milliseconds apart'),
    ('time', lambda t: t / 3600.0, 'hours apart'),
])
def test_values_of_another_scale_are_refused_before_they_become_an_effect(column, wrong, says):
    columns = step_test()
    prepare(record_of(**columns), DECLARED)
    columns[column] = wrong(columns[column])
    with pytest.raises(RecordError, match=rf'^plant\.csv, column {column}: ') as caught:
        prepare(record_of(**columns), DECLARED)
    assert says in str(caught.value)


def stepped(plant, levels=(3.6, 4.3, 3.9, 4.5)):
    """Return time, current (0.1 mA), pressure and position of a valve that is stepped about."""
    time = TIME['time']
    current = 1e-4 * np.array(levels)[(time // 5.0).astype(int) % len(levels)]
    run = simulate(plant, time, current, {'chamber_pressure': 250e3})
    return {'time': time, 'control_current': current,
            **{name: run[name] for name in ('chamber_pressure', 'valve_position')}}


def test_an_absolute_pressure_of_a_booster_with_a_dead_band_is_refused():
    columns = stepped(DECLARED._replace(booster=DECLARED.booster._replace(
        intake_preload=0.1, exhaust_preload=0.1)))
    prepare(record_of(**columns), DECLARED)
    columns['chamber_pressure'][200:220] = np.nan
    columns['chamber_pressure'] += 101_325.0
    with pytest.raises(RecordError, match=r'column chamber_pressure: .* looks like absolute'):
        prepare(record_of(**columns), DECLARED)


def test_a_stem_that_moves_at_another_pressure_than_declared_is_of_no_absolute_one():
    """With an atmosphere less it would move nearly as measured; but the booster is as declared."""
    harder = DECLARED._replace(actuator=DECLARED.actuator._replace(bench_set=(230e3, 380e3)))
    columns = stepped(harder, levels=(4.3, 4.6, 4.4, 4.7))
    assert columns['chamber_pressure'].min() > 150e3
    assert prepare(record_of(**columns), DECLARED).channels


@pytest.mark.parametrize('driven', [True, False])
def test_a_position_below_closed_is_of_this_valve_if_it_rises_as_the_valve_opens(driven):
    columns = stepped(DECLARED)
    if not driven:
        del columns['control_current']
    position = columns['valve_position']
    columns['valve_position'] = position - 0.007
    assert columns['valve_position'].mean() < 0.0
    prepare(record_of(**columns), DECLARED)
    columns['valve_position'] = -position
    with pytest.raises(RecordError, match='falls where the declared model opens'):
        prepare(record_of(**columns), DECLARED)


@pytest.mark.parametrize('driven_by', ['control_current', 'back_pressure'])
def test_rows_after_a_gap_count_once_the_chamber_has_caught_up(driven_by):
    """What went on in a gap shows for as long as a large chamber takes to fill."""
    time = 0.05 * np.arange(2400)
    current = np.where((time > 20.0) & (time < 60.0), 0.46e-3, 0.40e-3)
    run = simulate(DECLARED, time, current, {'chamber_pressure': 100e3})
    here = (time < 15.0) | (time > 58.0)
    experiment = prepare(record_of(
        time=time[here], **{driven_by: run[driven_by][here]},
        chamber_pressure=run['chamber_pressure'][here] + 50.0 * np.random.default_rng(
            1).standard_normal(int(here.sum()))), DECLARED)
    missed = experiment.measured['chamber_pressure'] - experiment.predict(
        DECLARED)['chamber_pressure']
    assert np.isfinite(missed[experiment.time > 100.0]).any()
    assert np.nanmax(np.abs(missed)) < 6.0 * experiment.noise['chamber_pressure']


@pytest.mark.parametrize('driven', [True, False])
def test_a_position_that_counts_from_open_is_refused(driven):
    columns = stepped(DECLARED)
    if not driven:
        del columns['control_current']
    columns['valve_position'] = 0.016 - columns['valve_position']
    with pytest.raises(RecordError, match='which is open for a valve that air closes'):
        prepare(record_of(**columns), DECLARED)


@pytest.mark.parametrize(('stuck', 'value'), [
    ('valve_position', 0.01), ('chamber_pressure', 101_325.0)])
def test_a_reading_that_never_changes_while_the_model_moves_is_not_compared(stuck, value):
    columns = stepped(DECLARED)
    columns[stuck] = np.full(ROWS, value)
    experiment = prepare(record_of(**columns), DECLARED)
    assert experiment.channels == tuple(
        name for name in ('chamber_pressure', 'valve_position') if name != stuck)
    assert any(f'{stuck} is not compared' in note for note in experiment.notes)


def test_readings_that_all_stick_fast_are_refused():
    columns = stepped(DECLARED)
    columns['valve_position'] = np.full(ROWS, 0.01)
    del columns['chamber_pressure']
    with pytest.raises(RecordError, match='no other channel is left'):
        prepare(record_of(**columns), DECLARED)


def test_a_valve_that_stays_shut_as_its_pressure_says_is_compared():
    columns = stepped(DECLARED)
    columns['chamber_pressure'] = columns['chamber_pressure'] * 0.3
    columns['valve_position'] = np.zeros(ROWS)
    assert 'valve_position' in prepare(record_of(**columns), DECLARED).channels


def test_a_sensor_that_is_off_by_less_or_by_what_swings_is_no_absolute_pressure():
    columns = step_test()
    given = columns['chamber_pressure']
    for wrong in (given + 60e3, given + 101e3 + 30e3 * np.sin(TIME['time'])):
        columns['chamber_pressure'] = wrong
        assert prepare(record_of(**columns), DECLARED).channels


@pytest.mark.parametrize(('wrong', 'says'), [
    (lambda p: p + 101_325.0, 'looks like absolute'), (lambda p: 0.01 * p, 'from mbar')])
def test_an_absolute_pressure_and_one_in_mbar_that_drive_the_stem_are_refused(wrong, says):
    columns = step_test()
    del columns['control_current']
    assert prepare(record_of(**columns), DECLARED).drives == ('chamber_pressure',)
    columns['chamber_pressure'] = wrong(columns['chamber_pressure'])
    with pytest.raises(RecordError, match=rf'column chamber_pressure: .*{says}'):
        prepare(record_of(**columns), DECLARED)


@pytest.mark.parametrize('in_mbar', [
    ('back_pressure',), ('supply_pressure',), ('back_pressure', 'supply_pressure'),
    ('back_pressure', 'supply_pressure', 'chamber_pressure')])
def test_drives_in_mbar_are_refused_whatever_else_is(in_mbar):
    columns = step_test()
    run = simulate(DECLARED, columns['time'], columns['control_current'],
                   {'chamber_pressure': 215e3})
    columns |= {'back_pressure': run['back_pressure'], **SUPPLY}
    if 'back_pressure' in in_mbar:
        del columns['control_current']
    prepare(record_of(**columns), DECLARED)
    columns |= {name: 0.01 * columns[name] for name in in_mbar}
    named = ' and '.join(name for name in in_mbar if name != 'chamber_pressure')
    with pytest.raises(RecordError, match=rf'column {named}: .* \(from mbar: times 100\)'):
        prepare(record_of(**columns), DECLARED)


def test_a_supply_far_below_the_declared_one_is_no_other_unit_where_the_model_follows_it():
    time = 0.1 * np.arange(ROWS)
    current = np.where(time < 10.0, 0.38e-3, 0.40e-3)
    supply = DECLARED.supply._replace(pressure=15e3)
    run = simulate(DECLARED._replace(supply=supply), time, current, {'chamber_pressure': 0.0})
    assert np.ptp(run['chamber_pressure']) > 5e3
    columns = {'time': time, 'control_current': current,
               'chamber_pressure': run['chamber_pressure'],
               'supply_pressure': np.full(ROWS, 15e3)}
    assert prepare(record_of(**columns), DECLARED).drives


def test_a_high_pressure_that_drives_the_stem_as_declared_is_no_absolute_one():
    """The stem stays away from its seat, so the pressure is never near that of the atmosphere."""
    columns = step_test()
    del columns['control_current']
    assert columns['chamber_pressure'].min() > 150e3
    off = DECLARED._replace(actuator=DECLARED.actuator._replace(bench_set=(100e3, 280e3)))
    assert prepare(record_of(**columns), off).channels == ('valve_position',)


@pytest.mark.parametrize(('period', 'step'), [(10.0, 600.0), (5e-4, 0.05)])
def test_rows_far_apart_or_close_together_are_fine_where_the_valve_moves_like_that(period, step):
    time = period * np.arange(ROWS)
    current = np.where(time % (2.0 * step) < step, 0.43e-3, 0.45e-3)
    run = simulate(DECLARED, time, current, {'chamber_pressure': 170e3})
    noise = 150.0 * np.random.default_rng(1).standard_normal(ROWS)
    prepare(record_of(time=time, control_current=current,
                      chamber_pressure=run['chamber_pressure'] + noise), DECLARED)


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


@pytest.mark.parametrize('apart', [2.0, 5.0])
@pytest.mark.parametrize('reading', [0.0, 8e-3])
def test_a_dead_sensor_says_nothing_of_the_unit_of_time(apart, reading):
    time = apart * np.arange(300)
    current = np.repeat(np.random.default_rng(1).choice([0.42e-3, 0.44e-3, 0.46e-3], 20), 15)
    run = simulate(DECLARED, time, current, {'chamber_pressure': 230e3})
    noise = 150.0 * np.random.default_rng(2).standard_normal(300)
    experiment = prepare(record_of(
        time=time, control_current=current, chamber_pressure=run['chamber_pressure'] + noise,
        valve_position=np.full(300, reading)), DECLARED)
    assert experiment.channels == ('chamber_pressure',)


def test_a_pressure_that_hardly_moves_for_a_leak_is_in_no_other_unit():
    leaking = DECLARED._replace(actuator=DECLARED.actuator._replace(leak_area=2e-6))
    columns = step_test()
    run = simulate(leaking, columns['time'], columns['control_current'], {'chamber_pressure': 20e3})
    columns['chamber_pressure'] = run['chamber_pressure']
    assert prepare(record_of(**columns), DECLARED).channels


def read_now_and_then(every, dwell=1507, seed=1):
    """Return the columns of a valve of which a row in `every` of 10 ms is kept."""
    rng = np.random.default_rng(seed)
    time = 0.01 * np.arange(30000)
    steps = np.repeat(rng.choice(np.linspace(0.40e-3, 0.45e-3, 9), 20), dwell)
    steps = np.resize(steps, len(time))
    current = steps + 5e-6 * np.sin(time / 10.0)
    run = simulate(DECLARED, time, current, {'chamber_pressure': 215e3})
    noise = {'chamber_pressure': 150.0, 'valve_position': 8e-6}
    columns = {'time': time, 'control_current': current} | {
        name: run[name] + level * rng.standard_normal(len(time)) for name, level in noise.items()}
    return {name: values[::every] for name, values in columns.items()}


def misses(experiment):
    """Return by channel what the declared model leaves, in that of noise."""
    predicted = experiment.predict(DECLARED)
    return {name: np.sqrt(np.nanmean((values - predicted[name])**2)) / experiment.noise[name]
            for name, values in experiment.measured.items()}


@pytest.mark.parametrize('every', [20, 50, 100])
def test_commands_that_were_read_now_and_then_are_taken_as_what_they_may_have_been(every):
    experiment = prepare(record_of(**read_now_and_then(every)), DECLARED)
    assert max(misses(experiment).values()) < 1.15
    compared = [np.isfinite(values).mean() for values in experiment.measured.values()]
    assert 0.1 < min(compared) <= max(compared) < 0.5
    assert 'were read now and then' in experiment.notes[-1]


@pytest.mark.parametrize('jitter', [2e-3, 0.05])
def test_they_are_so_where_rows_are_not_quite_evenly_spaced_as_well(jitter):
    columns = read_now_and_then(50)
    moved = np.random.default_rng(3).uniform(-jitter, jitter, len(columns['time']))
    columns['time'] = columns['time'] + np.r_[0.0, moved[1:]] * 0.01
    experiment = prepare(record_of(**columns), DECLARED)
    assert 'were read now and then' in experiment.notes[-1]
    assert experiment.noise['chamber_pressure'] < 300.0
    assert max(misses(experiment).values()) < 1.3


def test_thinned_rows_of_commands_that_were_read_now_and_then_meet_the_noise_as_well():
    thin, kept = prepare(record_of(**read_now_and_then(20)), DECLARED).thinned(4)
    assert len(kept) < 600
    assert max(misses(thin).values()) < 1.15


@pytest.mark.parametrize('every', [1, 50, 100])
def test_commands_that_were_recorded_when_they_were_given_stand(every):
    columns = read_now_and_then(every)
    if every > 1:  # play them as they are recorded
        held = columns['control_current']
        run = simulate(DECLARED, columns['time'], held, {'chamber_pressure': 215e3})
        rng = np.random.default_rng(2)
        columns['chamber_pressure'] = run['chamber_pressure'] + 150.0 * rng.standard_normal(
            len(held))
        columns['valve_position'] = run['valve_position'] + 8e-6 * rng.standard_normal(len(held))
    experiment = prepare(record_of(**columns), DECLARED)
    assert np.array_equal(experiment.current, columns['control_current'])
    assert experiment.ends is None
    assert all(np.isfinite(values).all() for values in experiment.measured.values())
