# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Defects of records: what is mended, what is noted, and what is left as it is."""

from made_csv import HEADER, defects, good_lines, read_lines
import numpy as np
import pytest

from booster_ros.records import RecordError
from booster_ros.records.cleaning import clean


def test_a_vented_chamber_is_not_taken_for_kilopascals(tmp_path):
    noise = np.random.default_rng(1).normal(0.0, 150.0, 200).round()
    lines = ['time,chamber_pressure', *(f'{k / 100},{p}' for k, p in enumerate(noise))]
    assert len(read_lines(tmp_path, lines)) == 200
    lines = ['time,chamber_pressure,supply_pressure', '0,0,400000', '1,0,400000']
    assert len(read_lines(tmp_path, lines)) == 2


def test_gaps_are_named_and_not_filled(tmp_path):
    lines = good_lines()
    del lines[20:30]
    record = read_lines(tmp_path, lines)
    (gap,) = defects(record, 'gap')
    assert (gap.first_row, gap.last_row) == (20, 21)
    assert '0.11 s' in gap.treatment
    assert len(record) == 40
    assert str(gap) == 'rows 20 to 21, column time: a gap of 0.11 s, left open'


def with_value(row: int, pressure: float, rows: int = 400) -> list[str]:
    """Return good lines with one pressure replaced."""
    lines = good_lines(rows)
    cells = lines[row - 1].split(',')
    lines[row - 1] = ','.join([*cells[:2], f'{pressure:.0f}', cells[3]])
    return lines


@pytest.mark.parametrize('wild', [2e6, 0.0, -3e5])
def test_a_single_value_far_from_its_neighbours_is_named_and_not_used(tmp_path, wild):
    record = read_lines(tmp_path, with_value(200, wild))
    assert np.flatnonzero(np.isnan(record['chamber_pressure'])).tolist() == [198]
    assert np.isfinite(record['valve_position']).all()
    (defect,) = defects(record, 'wild_value')
    assert str(defect) == ('row 200, column chamber_pressure: 1 value far from the rows before '
                           'and after, not used')
    assert not defects(record, 'missing_values')


def test_a_pressure_drop_is_cleaned_as_a_pressure_is():
    time = 0.1 * np.arange(400)
    drop = np.where(time < 20.0, 1e5, 3e5) + 200.0 * np.random.default_rng(1).standard_normal(400)
    drop[100], drop[300:303] = 2e6, -9999.0
    record = clean({'time': time, 'pressure_drop': drop}, np.arange(2, 402), 'plant.csv')
    assert np.flatnonzero(np.isnan(record['pressure_drop'])).tolist() == [100, 300, 301, 302]


def test_steps_and_peaks_that_last_and_signals_that_go_to_and_fro_are_kept(tmp_path):
    lines = good_lines(400)
    for row in range(200, 400):  # a step
        lines[row] = lines[row].rsplit(',', 1)[0] + ',0.012'
    for row in (100, 101):  # two rows
        cells = lines[row].split(',')
        lines[row] = ','.join([*cells[:2], '250000', cells[3]])
    record = read_lines(tmp_path, lines)
    assert not defects(record, 'wild_value')
    assert np.isfinite(record['chamber_pressure']).all()
    alternating = [HEADER] + [
        f'{row / 10},0.0004,{150_000 + 50_000 * (row % 10 == 0)},0.001' for row in range(400)]
    assert not defects(read_lines(tmp_path, alternating), 'wild_value')


def spiked(current, spikes=(500, 1200), size=5e3, rows=2000):
    """Return the lines of noise about a level that follows the command, with spikes in it."""
    rng = np.random.default_rng(2)
    pressure = 2e5 + 1e9 * (current - 4e-4) + 150.0 * rng.standard_normal(rows)
    pressure[list(spikes)] += size
    return [HEADER] + [f'{row / 100},{one:.9f},{p:.0f},0.001'
                       for row, (one, p) in enumerate(zip(current, pressure))]


SLOW_SINE = 4e-4 + 5e-5 * np.sin(np.arange(2000) / 300.0)


def test_small_spikes_through_which_the_command_ran_on_are_not_used(tmp_path):
    """A valve cannot have gone there and back: 5 kPa in a range of 100."""
    record = read_lines(tmp_path, spiked(SLOW_SINE))
    assert np.flatnonzero(np.isnan(record['chamber_pressure'])).tolist() == [500, 1200]
    late = [','.join([line.split(',')[0], '', *line.split(',')[2:]]) if row < 10 else line
            for row, line in enumerate(spiked(SLOW_SINE)[1:])]  # the first commands are not known
    record = read_lines(tmp_path, [HEADER, *late])
    assert np.flatnonzero(np.isnan(record['chamber_pressure'])).tolist() == [500, 1200]


def test_small_spikes_that_the_command_may_have_made_are_kept(tmp_path):
    current = SLOW_SINE.copy()
    current[[499, 1200]] += 5e-6  # a valve answers in the same row or in the next
    assert not defects(read_lines(tmp_path, spiked(current)), 'wild_value')
    without = [line.split(',', 2)[0] + ',' + line.split(',', 2)[2] for line in spiked(SLOW_SINE)]
    assert not defects(read_lines(tmp_path, without), 'wild_value')


def test_peaks_as_are_usual_in_a_record_are_kept(tmp_path):
    often = range(50, 2000, 100)  # one in a hundred rows: below noise and steps nothing is wild
    assert not defects(read_lines(tmp_path, spiked(SLOW_SINE, often)), 'wild_value')


@pytest.mark.parametrize('step', [1.0, 400.0])
def test_noise_and_flicker_of_a_signal_that_stands_still_are_no_wild_values(tmp_path, step):
    noise = 150.0 * np.random.default_rng(1).standard_normal(4000)
    pressures = 2e5 + step * np.round((noise + 0.3 * step) / step)
    lines = [HEADER] + [f'{row / 100},0.0004,{p:.0f},0.001' for row, p in enumerate(pressures)]
    record = read_lines(tmp_path, lines)
    assert np.isfinite(record['chamber_pressure']).all()
    lines[2000] = '19.99,0.0004,150000,0.001'
    assert defects(read_lines(tmp_path, lines), 'wild_value')


def test_pressures_that_stay_below_vacuum_are_refused(tmp_path):
    lines = with_value(200, -3e5)
    lines[200] = lines[200].replace('169900', '-300000')
    with pytest.raises(RecordError, match=(
            r'row 200, column chamber_pressure: -300000 Pa gauge is below vacuum')):
        read_lines(tmp_path, lines)


def test_of_duplicated_stamps_the_last_row_stays(tmp_path):
    lines = good_lines()
    lines.insert(10, lines[9].replace('150800', '150000'))
    record = read_lines(tmp_path, lines)
    assert len(record) == 50
    assert record['chamber_pressure'][8] == 150_000.0
    (duplicate,) = defects(record, 'duplicated_stamp')
    assert (duplicate.first_row, duplicate.last_row, duplicate.count) == (10, 10, 1)
    assert 10 not in record.rows


def test_rows_of_one_stamp_that_have_a_channel_each_are_one_row(tmp_path):
    lines = good_lines()
    expected = read_lines(tmp_path, lines)
    split = [lines[0]]
    for line in lines[1:]:
        time, current, pressure, position = line.split(',')
        split += [f'{time},{current},,', f'{time},,{pressure},{position}']
    record = read_lines(tmp_path, split)
    for name, values in expected.columns.items():
        assert np.array_equal(record[name], values)
    assert [d.count for d in defects(record, 'duplicated_stamp')] == [50]
    assert not defects(record, 'missing_values')
    assert not defects(record, 'missing_command')


def test_stamps_that_are_cut_to_whole_seconds_are_refused(tmp_path):
    lines = good_lines()
    few = [lines[0], *(f'{k // 20},{line.split(",", 1)[1]}' for k, line in enumerate(lines[1:]))]
    with pytest.raises(RecordError, match='time: has 3 stamps in 50 rows: write it with more dig'):
        read_lines(tmp_path, few)


def test_what_a_stamp_lacks_altogether_is_not_taken_from_another_one(tmp_path):
    lines = good_lines()
    time, current, _, position = lines[9].split(',')
    lines[9:10] = [f'{time},{current},,', f'{time},,,{position}']
    record = read_lines(tmp_path, lines)
    assert np.flatnonzero(np.isnan(record['chamber_pressure'])).tolist() == [8]


def test_pauses_between_bursts_of_rows_are_no_gaps_and_one_that_is_longer_is(tmp_path):
    lines = good_lines()
    time = np.add.outer(0.1 * np.arange(5), 2e-5 * np.arange(10)).ravel()
    time[30:] += 3.0
    lines[1:] = [','.join([f'{at:.6f}', *line.split(',')[1:]])
                 for at, line in zip(time, lines[1:], strict=True)]
    record = read_lines(tmp_path, lines)
    (gap,) = defects(record, 'gap')
    assert (gap.first_row, gap.last_row) == (31, 32)


def test_a_clock_that_was_set_while_recording_is_pointed_out(tmp_path):
    lines = good_lines()
    lines[20:] = [','.join([str(1.7e9 + float(line.split(',')[0])), *line.split(',')[1:]])
                  for line in lines[20:]]
    with pytest.raises(RecordError, match=r'row 21, column time: 1\.7e\+09 s after the row before'):
        read_lines(tmp_path, lines)


def test_missing_outputs_stay_missing_and_missing_commands_hold(tmp_path):
    lines = good_lines()
    for row in (10, 11, 12):
        time, _, _, position = lines[row - 1].split(',')
        lines[row - 1] = f'{time},,NaN,{position}'
    record = read_lines(tmp_path, lines)
    assert np.isnan(record['chamber_pressure'][8:11]).all()
    assert (record['control_current'][8:11] == record['control_current'][7]).all()
    (missing,) = defects(record, 'missing_values')
    assert (missing.column, missing.first_row, missing.last_row) == ('chamber_pressure', 10, 12)
    (held,) = defects(record, 'missing_command')
    assert held.count == 3


def test_a_command_is_not_held_across_a_gap_nor_before_the_first(tmp_path):
    lines = good_lines()
    lines[1] = lines[1].replace('0.000400000', '')
    lines[30] = '0.29,,152900,0.000058'
    del lines[20:30]
    record = read_lines(tmp_path, lines)
    assert np.isnan(record['control_current'][[0, 19]]).all()
    assert np.isfinite(record['control_current'][20])


@pytest.mark.parametrize('position', ['', '0.001'])
def test_rows_without_time_and_empty_columns_are_dropped(tmp_path, position):
    """A column is empty too if its values stand in rows without a time alone."""
    lines = [','.join([*line.split(',')[:3], '']) for line in good_lines()]
    lines[0] = HEADER
    lines[6] = f',0.0004,150000,{position}'
    record = read_lines(tmp_path, lines)
    assert 'valve_position' not in record
    assert len(record) == 49
    assert defects(record, 'empty_column')[0].column == 'valve_position'
    assert defects(record, 'missing_time')[0].first_row == 7


def test_many_runs_are_one_note(tmp_path):
    lines = good_lines()
    for row in range(5, 45, 2):
        lines[row - 1] = ','.join([*lines[row - 1].split(',')[:3], ''])
    (missing,) = defects(read_lines(tmp_path, lines), 'missing_values')
    assert (missing.first_row, missing.last_row, missing.count) == (5, 43, 20)


def test_uneven_sampling_resolution_and_start_are_noted(tmp_path):
    random = np.random.default_rng(2)
    time = np.cumsum(random.uniform(0.005, 0.02, 300))
    pressure = 150_000 + 25 * random.integers(0, 400, 300)
    rows = zip(time, pressure, strict=True)
    lines = ['time,chamber_pressure', *(f'{t:.4f},{p}' for t, p in rows)]
    record = read_lines(tmp_path, lines)
    assert 'steps of 25 Pa' in defects(record, 'quantised')[0].treatment
    assert defects(record, 'uneven_sampling')[0].count == 299
    assert defects(record, 'starts_in_operation')[0].first_row == 2


def test_a_calendar_time_is_counted_from_the_first_row(tmp_path):
    lines = ['time,chamber_pressure', *(f'{1.7e9 + k / 100:.2f},{9000 + k}' for k in range(20))]
    record = read_lines(tmp_path, lines)
    np.testing.assert_allclose(record['time'], np.arange(20) / 100, atol=1e-6)
    assert defects(record, 'calendar_time')


def test_a_clean_record_has_no_notes(tmp_path):
    random = np.random.default_rng(3)
    lines = ['time,control_current,chamber_pressure,valve_position'] + [
        f'{k / 100:.2f},0,{random.normal():.12f},{random.normal(0, 1e-6):.12f}' for k in range(99)]
    assert read_lines(tmp_path, lines).notes == ()


def test_the_columns_of_a_record_cannot_be_changed(tmp_path):
    record = read_lines(tmp_path, good_lines())
    with pytest.raises(ValueError, match='read-only'):
        record['time'][0] = 1.0


def saw_tooth(rows: int = 300) -> list[list[str]]:
    """Return the cells of a saw tooth: time, current, pressure far above zero, position."""
    return [[str(k), f'{0.004 + 0.0004 * (k % 10):.4g}', str(100_000 + 2000 * (k % 10)),
             f'{0.0005 * (k % 10):.4g}'] for k in range(rows)]


def read_cells(folder, cells: list[list[str]], header: str = HEADER):
    return read_lines(folder, [header, *(','.join(one) for one in cells)])


def test_zeros_amid_a_pressure_are_a_dropout(tmp_path):
    cells = saw_tooth()
    for k in range(100, 105):
        cells[k][2] = '0'
    record = read_cells(tmp_path, cells)
    assert record.rows[np.isnan(record['chamber_pressure'])].tolist() == [102, 103, 104, 105, 106]
    assert np.isfinite(record['valve_position']).all()
    assert 'a dropout' in str(defects(record, 'dropout')[0])
    alone = read_cells(tmp_path, [one[::2] for one in cells], 'time,chamber_pressure')
    assert np.isnan(alone['chamber_pressure']).sum() == 5


def test_zeros_of_a_valve_that_was_vented_are_pressures(tmp_path):
    """The position fell with the pressure, or the command asked for it; others go near zero."""
    vented = saw_tooth()
    for k in range(100, 105):
        vented[k] = [str(k), '0.004', '0', '0']
    assert not defects(read_cells(tmp_path, vented), 'dropout')
    near = saw_tooth()
    for k in range(100, 105):
        near[k][2] = str(20_000 * abs(102 - k))  # on its way down and up again
    assert not defects(read_cells(tmp_path, near), 'dropout')
    often = saw_tooth()
    for k in range(100, 120):
        often[k][2] = '0'
    assert not defects(read_cells(tmp_path, often), 'dropout')
    down = saw_tooth()
    for k in range(100, 105):
        down[k][2] = '0'
    for k in range(105, 300):
        down[k][2] = '30000'  # it came back elsewhere
    assert not defects(read_cells(tmp_path, down), 'dropout')


@pytest.mark.parametrize(('chamber', 'dropped'), [('100000', True), ('1000', False)])
def test_a_supply_that_fails_is_no_dropout_unless_the_chamber_shows_it(tmp_path, chamber, dropped):
    cells = [[str(k), '400000', '100000'] for k in range(300)]
    for k in range(100, 105):
        cells[k][1:] = ['0', chamber]
    record = read_cells(tmp_path, cells, 'time,supply_pressure,chamber_pressure')
    assert bool(defects(record, 'dropout')) is dropped


@pytest.mark.parametrize('mark', ['-9999', '-999', '99999', '999999'])
def test_numbers_that_loggers_write_for_none_are_no_pressures(tmp_path, mark):
    cells = saw_tooth(40)
    for k in (11, 12, 13):
        cells[k][2] = mark
    record = read_cells(tmp_path, cells)
    assert np.flatnonzero(np.isnan(record['chamber_pressure'])).tolist() == (
        [11, 12, 13] if mark != '99999' else [])  # among the others it may be one
    assert len(defects(record, 'sentinel')) == (mark != '99999')


def test_vacuum_is_said_to_be_outside_the_model(tmp_path):
    cells = [[str(k), str(-30_000 - 10 * k)] for k in range(60)]
    record = read_cells(tmp_path, cells, 'time,chamber_pressure')
    assert 'vacuum is outside the model' in str(defects(record, 'vacuum')[0])
    noise = [[str(k), str(-300 + 10 * k)] for k in range(60)]
    assert not defects(read_cells(tmp_path, noise, 'time,chamber_pressure'), 'vacuum')


def test_nothing_beside_time_is_no_record():
    with pytest.raises(RecordError, match=r'record\.csv: has no column beside time'):
        clean({'time': np.arange(20.0)}, np.arange(2, 22), 'record.csv')
