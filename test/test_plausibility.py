# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Values that cannot be of the declared valve are refused, and odd ones of it are not."""

from made_diagnosis import DECLARED
import made_record
from made_record import BACK, CHAMBER, FLOW, RAMP, ROWS, SUPPLY, TIME, record_of
import numpy as np
import pytest

from booster_ros.diagnosis.prepare.otherwise import PRESSURES
from booster_ros.diagnosis.prepare.preparation import prepare
from booster_ros.model.simulation import simulate
from booster_ros.records import RecordError


def step_test():
    """Return the columns of a noisy step, and of not much more than a stem takes to follow it."""
    return {name: values[:200] for name, values in made_record.step_test().items()}


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


def test_a_record_of_the_right_scales_is_taken():
    assert prepare(record_of(**step_test()), DECLARED).channels


@pytest.mark.parametrize(('column', 'wrong', 'says'), [
    ('chamber_pressure', lambda p: p + 101_325.0, 'looks like absolute pressure'),
    ('chamber_pressure', lambda p: 0.01 * p, 'from mbar'),
    ('valve_position', lambda x: x / 0.016, 'declared travel is 0.016 m'),
    ('valve_position', lambda x: 0.1 * x + 0.09, 'declared travel is 0.016 m'),
    ('valve_position', lambda x: -x, 'reverse its sign'),
    ('control_current', lambda i: 0.004 + 16.0 * i, 'the supply has 4e+05'),
    ('control_current', lambda i: 8.2e-4 - i, 'less the current'),
    ('control_current', lambda i: np.max(i) - i, 'less the current'),
    ('time', lambda t: 1e3 * t, 'if they are 100 milliseconds apart'),
    ('time', lambda t: 1e6 * t, 'if they are 1e+05 microseconds apart'),
    ('time', lambda t: t / 3600.0, 'hours apart'),
])
def test_values_of_another_scale_are_refused_before_they_become_an_effect(column, wrong, says):
    columns = step_test()
    columns[column] = wrong(columns[column])
    with pytest.raises(RecordError, match=rf'^plant\.csv, column {column}: ') as caught:
        prepare(record_of(**columns), DECLARED)
    assert says in str(caught.value)


def test_a_level_that_is_far_off_does_not_make_a_converter_reverse_acting():
    """The chamber is slow, so that its pressure hardly goes with a current that swings fast."""
    time = np.arange(0.0, 30.0, 0.05)
    current = 0.433e-3 + 5e-6 * sum(np.sin(2.0 * np.pi * f * time) for f in (0.62, 0.75, 0.88))
    leaking = DECLARED._replace(actuator=DECLARED.actuator._replace(leak_area=2e-7))
    run = simulate(leaking, time, current, {'chamber_pressure': 2.1e5})
    random = np.random.default_rng(0)
    columns = {'time': time, 'control_current': current, **{
        name: run[name] + noise * random.standard_normal(len(time))
        for name, noise in (('chamber_pressure', 150.0), ('valve_position', 8e-6))}}
    settled = {name: values[200:] for name, values in columns.items()}
    assert np.corrcoef(settled['control_current'], settled['chamber_pressure'])[0, 1] < 0.0
    prepare(record_of(**settled), DECLARED)


def test_time_in_ms_of_rows_that_are_one_apart_is_refused():
    columns = step_test()
    fast = np.arange(8.0, 14.0, 1e-3)  # with the step
    columns = {name: np.interp(fast, columns['time'], values) for name, values in columns.items()}
    prepare(record_of(**columns), DECLARED)
    with pytest.raises(RecordError, match='if they are 1 milliseconds apart'):
        prepare(record_of(**columns | {'time': np.arange(float(len(fast)))}), DECLARED)


def test_a_pressure_in_mbar_is_refused_though_the_model_does_not_follow_it_closely():
    """Something swings in it that the model lacks."""
    columns = step_test()
    columns['chamber_pressure'] += 7e3 * np.sin(3.0 * columns['time'])
    prepare(record_of(**columns), DECLARED)
    columns['chamber_pressure'] *= 0.01
    with pytest.raises(RecordError, match='from mbar'):
        prepare(record_of(**columns), DECLARED)


def stepped(plant, levels=(3.6, 4.3, 3.9, 4.5)):
    """Return time, current, pressure and position of a valve that is stepped to levels, 0.1 mA."""
    time = TIME['time'][:50 * len(levels)]
    current = 1e-4 * np.array(levels)[(time // 5.0).astype(int)]
    run = simulate(plant, time, current, {'chamber_pressure': 250e3})
    return {'time': time, 'control_current': current,
            **{name: run[name] for name in ('chamber_pressure', 'valve_position')}}


@pytest.mark.parametrize(('levels', 'total'), [
    ((4.02, 4.07, 3.69, 4.38), 0.94e-3), ((4.5, 4.29, 4.32, 4.48), 1.17e-3),
    ((4.08, 3.68, 4.34, 3.85), 1.5e-3)])
def test_a_reversed_current_is_found_among_many_that_leave_the_valve_open_or_shut(levels, total):
    columns = stepped(DECLARED, levels)
    prepare(record_of(**columns), DECLARED)
    columns['control_current'] = total - columns['control_current']
    with pytest.raises(RecordError, match=rf'moves as measured with {total:.4g} A less the curr'):
        prepare(record_of(**columns), DECLARED)


def test_an_absolute_pressure_of_a_booster_with_a_dead_band_is_refused():
    columns = stepped(DECLARED._replace(booster=DECLARED.booster._replace(
        intake_preload=0.1, exhaust_preload=0.1)))
    prepare(record_of(**columns), DECLARED)
    columns['chamber_pressure'][100:110] = np.nan
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


@pytest.mark.parametrize('driven', [True, False])
def test_a_position_that_counts_from_open_is_refused(driven):
    columns = stepped(DECLARED)
    if not driven:
        del columns['control_current']
    columns['valve_position'] = 0.016 - columns['valve_position']
    with pytest.raises(RecordError, match='for a valve that air closes, subtract it'):
        prepare(record_of(**columns), DECLARED)


@pytest.mark.parametrize(('stuck', 'value'), [
    ('valve_position', 0.01), ('chamber_pressure', 101_325.0)])
def test_a_reading_that_never_changes_while_the_model_moves_is_not_compared(stuck, value):
    columns = stepped(DECLARED)
    columns[stuck] = np.full(len(columns['time']), value)
    experiment = prepare(record_of(**columns), DECLARED)
    assert experiment.channels == tuple(
        name for name in ('chamber_pressure', 'valve_position') if name != stuck)
    assert any(f'{stuck} is not compared' in note for note in experiment.notes)


def test_readings_that_all_stick_fast_are_refused():
    columns = stepped(DECLARED)
    columns['valve_position'] = np.full(len(columns['time']), 0.01)
    del columns['chamber_pressure']
    with pytest.raises(RecordError, match='no other channel is left'):
        prepare(record_of(**columns), DECLARED)


def test_a_valve_that_stays_shut_as_its_pressure_says_is_compared():
    columns = stepped(DECLARED)
    columns['chamber_pressure'] = columns['chamber_pressure'] * 0.3
    columns['valve_position'] = np.zeros(len(columns['time']))
    assert 'valve_position' in prepare(record_of(**columns), DECLARED).channels


def test_a_sensor_that_is_off_by_less_or_by_what_swings_is_no_absolute_pressure():
    columns = step_test()
    given = columns['chamber_pressure']
    for wrong in (given + 60e3, given + 101e3 + 60e3 * np.sin(columns['time'])):
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
    columns = driven_by(['back_pressure', 'supply_pressure'])
    if 'back_pressure' in in_mbar:
        del columns['control_current']
    prepare(record_of(**columns), DECLARED)
    columns |= {name: 0.01 * columns[name] for name in in_mbar}
    named = ' and '.join(sorted(in_mbar, key=PRESSURES.index))
    with pytest.raises(RecordError, match=rf'column {named}: .* \(from mbar: times 100\)'):
        prepare(record_of(**columns), DECLARED)


def driven_by(channels, plant=DECLARED):
    """Return columns of a step test with these pressures upstream of the chamber as well."""
    columns = step_test()
    run = simulate(plant, columns['time'], columns['control_current'],
                   {'chamber_pressure': 215e3})
    for name in ('chamber_pressure', 'valve_position', *channels):
        columns[name] = run[name]
    return columns


@pytest.mark.parametrize(('channels', 'absolute', 'commanded'), [
    (['supply_pressure'], ['supply_pressure'], True),
    (['back_pressure'], ['back_pressure'], True),
    (['back_pressure'], ['back_pressure'], False),
    (['back_pressure', 'supply_pressure'], ['back_pressure'], False),
    (['back_pressure', 'supply_pressure'], ['supply_pressure'], False),
    (['back_pressure', 'supply_pressure'], ['supply_pressure', 'back_pressure'], False)])
def test_absolute_pressures_upstream_are_refused_by_name(channels, absolute, commanded):
    """A supply in absolute pressure came out as a dead band and a jet that pushes the plug."""
    plant = DECLARED._replace(booster=DECLARED.booster._replace(intake_preload=0.05))
    columns = driven_by(channels, plant)
    if not commanded:
        del columns['control_current']
    assert prepare(record_of(**columns), DECLARED).drives
    for name in absolute:
        columns[name] = columns[name] + 101_325.0
    named = ' and '.join(absolute)
    with pytest.raises(RecordError, match=rf'column {named}: .* looks like absolute pressure'):
        prepare(record_of(**columns), DECLARED)


def test_a_supply_an_atmosphere_above_the_declared_one_is_no_absolute_one_if_the_valve_has_it():
    high = DECLARED._replace(supply=DECLARED.supply._replace(pressure=501_325.0))
    columns = driven_by(['supply_pressure'], high)
    assert columns['supply_pressure'].min() == 501_325.0
    assert 'supply_pressure' in prepare(record_of(**columns), DECLARED).drives


@pytest.mark.parametrize('read', [0.0, 150e3])
def test_a_supply_from_which_the_chamber_cannot_have_been_filled_is_refused(read):
    columns = driven_by(['supply_pressure'])
    assert columns['chamber_pressure'].max() > 250e3
    columns['supply_pressure'][:] = read
    with pytest.raises(RecordError, match=r'never exceeds .* Pa, .* not what fed the booster'):
        prepare(record_of(**columns), DECLARED)


def test_a_chamber_that_only_falls_from_above_its_supply_was_filled_before():
    time = 0.1 * np.arange(ROWS)
    lost = DECLARED._replace(supply=DECLARED.supply._replace(pressure=50e3))
    run = simulate(lost, time, np.full(ROWS, 0.43e-3), {'chamber_pressure': 280e3})
    assert np.ptp(run['chamber_pressure']) > 50e3
    columns = {'time': time, 'control_current': np.full(ROWS, 0.43e-3),
               **{name: run[name] for name in (
                   'chamber_pressure', 'valve_position', 'supply_pressure')}}
    assert 'supply_pressure' in prepare(record_of(**columns), DECLARED).drives


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


@pytest.mark.parametrize(('apart', 'reading'), [(2.0, 8e-3), (5.0, 0.0)])
def test_a_dead_sensor_says_nothing_of_the_unit_of_time(apart, reading):
    time = apart * np.arange(120)
    current = np.repeat(np.random.default_rng(1).choice([0.42e-3, 0.44e-3, 0.46e-3], 8), 15)
    run = simulate(DECLARED, time, current, {'chamber_pressure': 230e3})
    noise = 150.0 * np.random.default_rng(2).standard_normal(120)
    experiment = prepare(record_of(
        time=time, control_current=current, chamber_pressure=run['chamber_pressure'] + noise,
        valve_position=np.full(120, reading)), DECLARED)
    assert experiment.channels == ('chamber_pressure',)


def test_a_pressure_that_hardly_moves_for_a_leak_is_in_no_other_unit():
    leaking = DECLARED._replace(actuator=DECLARED.actuator._replace(leak_area=2e-6))
    columns = step_test()
    run = simulate(leaking, columns['time'], columns['control_current'], {'chamber_pressure': 20e3})
    columns['chamber_pressure'] = run['chamber_pressure']
    assert prepare(record_of(**columns), DECLARED).channels


def test_a_current_that_falls_while_the_valve_fills_for_another_reason_is_not_reversed():
    """The supply comes back while the current goes down: pressure rises all the same."""
    time = TIME['time'][:200]
    rising = {'supply_pressure': np.interp(time, [0.0, time[-1]], [100e3, 400e3])}
    current = np.interp(time, [0.0, time[-1]], [4.6e-4, 4.4e-4])
    run = simulate(DECLARED, time, current, {'chamber_pressure': 90e3}, rising)
    columns = {'time': time, 'control_current': current, **rising,
               **{name: run[name] for name in ('chamber_pressure', 'valve_position')}}
    assert np.corrcoef(current, columns['chamber_pressure'])[0, 1] < -0.9
    assert prepare(record_of(**columns), DECLARED).channels
