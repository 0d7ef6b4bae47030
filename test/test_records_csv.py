# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""CSV records: what is read, what is mended and noted, and what is refused in which words."""

import os
from pathlib import Path
import re
import resource
import tracemalloc

from hypothesis import given, settings, strategies
import numpy as np
import pytest

from booster_ros.records import (
    CsvWriter, RecordError, csv_columns, first_row, iterate_csv, read_record)
from booster_ros.records.csv_digits import fixed_lines

HEADER = 'time,control_current,chamber_pressure,valve_position'


def good_lines(rows: int = 50) -> list[str]:
    return [HEADER] + [
        f'{row / 100:.2f},{4e-4 + 1e-6 * (row // 10):.9f},{150_000 + 100 * row},{row * 2e-6:.6f}'
        for row in range(rows)
    ]


def write(folder: Path, text: str | bytes) -> Path:
    path = folder / 'record.csv'
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def read_lines(folder: Path, lines: list[str]):
    return read_record(write(folder, '\n'.join(lines) + '\n'))


def replaced(row: int, line: str) -> list[str]:
    """Return good lines with one replaced, counted as an editor does."""
    lines = good_lines()
    lines[row - 1] = line
    return lines


def defects(record, kind: str):
    return [defect for defect in record.defects if defect.kind == kind]


def test_columns_and_row_numbers_are_those_of_the_file(tmp_path):
    record = read_lines(tmp_path, good_lines())
    assert list(record.columns) == HEADER.split(',')
    assert len(record) == 50
    assert record['time'][7] == 0.07
    assert record['chamber_pressure'][7] == 150_700.0
    assert list(record.rows[:2]) == [2, 3]


@pytest.mark.parametrize('mangle', [
    lambda text: text.replace('\n', '\r\n'),
    lambda text: text.replace('\n', '\r'),
    lambda text: '\ufeff' + text,
    lambda text: text.rstrip('\n'),
    lambda text: text + '\n\n  \n',
    lambda text: text.replace(',', '\t'),
    lambda text: text.replace(',', ';'),
    lambda text: text.replace(',', ';').replace('.', ','),
    lambda text: text.replace(',', ' , '),
    lambda text: text.replace('time', '"time"').replace('0.07', '"0.07"'),
    lambda text: text.replace('chamber_pressure', 'Chamber Pressure'),
], ids=[
    'Windows', 'old Mac', 'byte order mark', 'no line feed at the end', 'blank lines at the end',
    'tabs', 'semicolons', 'decimal commas', 'spaces', 'quotes', 'capitals',
])
def test_dialects_read_the_same(tmp_path, mangle):
    text = '\n'.join(good_lines()) + '\n'
    plain = read_record(write(tmp_path, text))
    record = read_record(write(tmp_path, mangle(text)))
    for name, values in plain.columns.items():
        np.testing.assert_array_equal(record[name], values)
    np.testing.assert_array_equal(record.rows, plain.rows)


@pytest.mark.parametrize(('lines', 'says'), [
    (replaced(5, '0.03,0.0004,abc,0'), "row 5, column chamber_pressure: 'abc' is not a number"),
    (replaced(2, 's,A,Pa,m'), "row 2, column time: 's' is not a number (remove the row of units"),
    (replaced(5, '0.03,1_0,1,0'), "row 5, column control_current: '1_0' is not a number"),
    (replaced(5, '0.03,0.0004,inf,0'), 'row 5, column chamber_pressure: the value is infinite'),
    (replaced(5, '0.03,0.0004,1e999,0'), 'row 5, column chamber_pressure: the value is infinite'),
    (replaced(5, '0.03,0.0004,150000'), 'row 5: 3 cells where the header has 4'),
    (replaced(5, '0,03,0,0004,150000,0'), '6 cells where the header has 4; with decimal commas'),
    (replaced(5, '"0.03,0.0004,1,0'), 'row 5: the quotes do not match'),
    (replaced(9, '0.01,0.0004,150000,0'), 'row 9, column time: runs backwards, from 0.06 to 0.01'),
    (replaced(5, '0.03,0.45,150000,0'), 'row 5, column control_current: 0.45 is not plausible'),
    (replaced(5, '0.03,0.0004,1e9,0'), 'column chamber_pressure: 1e+09 is not plausible in Pa'),
    (replaced(5, '0.03,0.0004,1,8.3'), 'row 5, column valve_position: 8.3 is not plausible in m'),
    (replaced(1, 'time,a,b,c'), 'row 1: no known column beside time; a record has'),
    (replaced(1, 'time,a,b,chamber_presure'),
     'row 1: no known column beside time: chamber_presure (is it chamber_pressure?); a record has'),
    (replaced(1, 'time,time,chamber_pressure,c'), 'row 1: column time appears twice'),
    (replaced(1, 'timestamp,control_current,b,c'), "row 1: column 'timestamp' looks like the time"),
    (replaced(1, '__time,control_current,b,c'), "row 1: column '__time' looks like the time"),
    (replaced(1, 'elapsed_time,control_current,b,c'), "'elapsed_time' looks like the time"),
    *((replaced(1, f'{name},control_current,b,c'), f"row 1: column '{name}' looks like the time")
      for name in ('elapsed', 'zeit', 'Messzeit (s)', 'Datum', 'ms', 'ts', 'epoch', 'uptime',
                   'unix_ns', 'ros clock', 'elapsedTime', 'timeMs', 'Millis')),
    (replaced(1, 'time,control_current (mA),b,c'),
     "row 1: column 'control_current (mA)' must be in A: convert it and call it control_current"),
    (replaced(1, ''), 'the first row is empty'),
    ([HEADER], 'has a header and no rows of data'),
    ([HEADER, '', ''], 'has a header and no rows of data'),
    ([HEADER, ',,,'], 'column time has no value, and no other column is left'),
    ([HEADER, ',1e-4,2e5,0.01'], 'column time has no value'),
    ([HEADER] + ['0.0,1e-4,2e5,0.01'] * 3, 'row 3, column time: stands still in all rows'),
    (['time,chamber_pressure'] + [f'{k},{k % 4}' for k in range(50)],
     'row 5, column chamber_pressure: the largest value is 3, which looks like kPa, bar'),
    (['time,chamber_pressure'] + [f'{k},{150 if k > 9 else 0.1 * (-1) ** k}' for k in range(50)],
     'column chamber_pressure: the largest value is 150, which looks like kPa, bar'),
    (['time,chamber_pressure'] + [f'{1.7e18 + k:.0f},{k}' for k in range(50)],
     'row 2, column time: 1.7e+18 is not plausible in s'),
])
def test_refusals_say_where_and_why(tmp_path, lines, says):
    with pytest.raises(RecordError) as refusal:
        read_lines(tmp_path, lines)
    assert says in str(refusal.value)
    assert str(refusal.value).startswith(str(tmp_path / 'record.csv'))
    assert '\n' not in str(refusal.value)


@pytest.mark.parametrize(('content', 'says'), [
    (b'', 'the first row is empty'),
    ('time,chamber_pressure\n0,1\n'.encode('utf-16'), 'not a CSV in UTF-8 but UTF-16'),
    (b'PK\x03\x04abc', 'but a zip archive or spreadsheet'),
    (b'\x1f\x8b\x08', 'but gzip'),
    (b'time,druck\xfc\n', 'row 1: not UTF-8'),
    (b'time,\0\n', 'row 1: the file is binary'),
])
def test_what_is_not_csv_is_named(tmp_path, content, says):
    with pytest.raises(RecordError, match=re.escape(says)):
        read_record(write(tmp_path, content))


def test_a_file_that_is_not_there_is_refused_by_name(tmp_path):
    with pytest.raises(RecordError, match=r'nothing\.csv: No such file'):
        read_record(tmp_path / 'nothing.csv')


def test_a_unit_behind_a_name_may_stand_there_if_it_is_ours(tmp_path):
    header = 'time [s],control_current [A],chamber_pressure (Pa),valve_position [m]'
    record = read_lines(tmp_path, replaced(1, header))
    assert set(record.columns) == set(HEADER.split(','))


def test_unknown_columns_may_hold_anything_and_are_noted(tmp_path):
    lines = [line + f',comment {row}' for row, line in enumerate(good_lines())]
    lines[0] = HEADER + ',chamber_presure'
    record = read_lines(tmp_path, lines)
    assert list(record.columns) == HEADER.split(',')
    (unknown,) = defects(record, 'unknown_column')
    assert unknown.column == 'chamber_presure'
    assert 'is it chamber_pressure?' in unknown.treatment


def test_without_time_a_record_is_a_sweep_in_row_order(tmp_path):
    lines = ['chamber_pressure,valve_position', '0,0', '150000,0', '0,0', '300000,0.016']
    record = read_lines(tmp_path, lines)
    assert 'time' not in record
    assert list(record['chamber_pressure']) == [0.0, 150_000.0, 0.0, 300_000.0]
    assert record.stretches() == [slice(0, 4)]


@pytest.mark.parametrize('name', ['row', 'Index', 'n', 'no.', 'sample', 'force', 'set point', 's'])
def test_a_sweep_may_have_a_column_that_rises_as_time_does(tmp_path, name):
    rows = (f'{k},{1000 * k},{1e-5 * k:.6f}' for k in range(300))
    record = read_lines(tmp_path, [f'{name},chamber_pressure,valve_position', *rows])
    assert 'time' not in record
    assert defects(record, 'unknown_column')[0].column == name


def test_a_vented_chamber_is_not_taken_for_kilopascals(tmp_path):
    noise = np.random.default_rng(1).normal(0.0, 150.0, 200).round()
    lines = ['time,chamber_pressure', *(f'{k / 100},{p}' for k, p in enumerate(noise))]
    assert len(read_lines(tmp_path, lines)) == 200
    lines = ['time,chamber_pressure,supply_pressure', '0,0,400000', '1,0,400000']
    assert len(read_lines(tmp_path, lines)) == 2


def test_gaps_split_a_record_and_are_not_filled(tmp_path):
    lines = good_lines()
    del lines[20:30]
    record = read_lines(tmp_path, lines)
    (gap,) = defects(record, 'gap')
    assert (gap.first_row, gap.last_row) == (20, 21)
    assert '0.11 s' in gap.treatment
    assert record.stretches() == [slice(0, 19), slice(19, 40)]
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
    assert [piece.start for piece in record.stretches()] == [0, 30]


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


@settings(max_examples=300, deadline=None)
@given(
    at=strategies.integers(0, 2000), length=strategies.integers(0, 40),
    what=strategies.one_of(
        strategies.binary(max_size=20),
        strategies.text('0123456789.,;eE+-\n\r\t" naif', max_size=20).map(str.encode)),
)
def test_a_mutilated_file_reads_or_is_refused(tmp_path_factory, at, length, what):
    text = ('\n'.join(good_lines()) + '\n').encode()
    path = write(tmp_path_factory.getbasetemp(), text[:at] + what + text[at + length:])
    try:
        record = read_record(path)
    except RecordError as error:
        assert '\n' not in str(error)  # noqa: PT017
    else:
        assert all(len(values) == len(record.rows) > 0 for values in record.columns.values())
        assert not any(np.isinf(values).any() for values in record.columns.values())


cells = strategies.sampled_from(['0.5', '1e-4', '-3', '', ' ', 'nan', '7 ', '.5', '5.', '+1'])


@settings(max_examples=200, deadline=None)
@given(strategies.lists(strategies.tuples(cells, cells), min_size=1, max_size=20))
def test_the_fast_and_the_careful_way_read_the_same(tmp_path_factory, table):
    folder = tmp_path_factory.getbasetemp()
    lines = ['chamber_pressure,valve_position', *(','.join(row) for row in table)]
    plain = read_or_sentence(write(folder, '\n'.join(lines)))
    # A quoted cell is left to the careful way.
    quoted = ['"chamber_pressure",valve_position', *(f'"{a}",{b}' for a, b in table)]
    careful = read_or_sentence(write(folder, '\n'.join(quoted)))
    assert plain == careful


def read_or_sentence(path: Path) -> object:
    try:
        return {name: str(values) for name, values in read_record(path).columns.items()}
    except RecordError as error:
        return str(error)


def test_blocks_of_a_long_file_join_seamlessly(tmp_path, monkeypatch):
    path = write(tmp_path, '\n'.join(good_lines(2000)))
    whole = read_record(path)
    monkeypatch.setattr('booster_ros.records.csv_text._BLOCK_BYTES', 777)
    pieces = read_record(path)
    for name, values in whole.columns.items():
        np.testing.assert_array_equal(pieces[name], values)
    np.testing.assert_array_equal(pieces.rows, whole.rows)
    write(tmp_path, '\n'.join([*good_lines(2000), '20.00,x,1,1']))
    with pytest.raises(RecordError, match='row 2002, column control_current'):
        read_record(path)


def test_iteration_yields_the_wanted_columns_in_order(tmp_path):
    path = write(tmp_path, '\n'.join(good_lines()))
    assert csv_columns(path) == tuple(HEADER.split(','))
    chunks = list(iterate_csv(path, ['valve_position', 'time'], rows_per_chunk=20))
    assert [len(chunk.rows) for chunk in chunks] == [20, 20, 10]
    values = np.concatenate([chunk.values for chunk in chunks])
    record = read_record(path)
    np.testing.assert_array_equal(values[:, 0], record['valve_position'])
    np.testing.assert_array_equal(values[:, 1], record['time'])
    np.testing.assert_array_equal(np.concatenate([chunk.rows for chunk in chunks]), record.rows)


@pytest.mark.parametrize('end', ['\n', '\r\n', '\r'])
@pytest.mark.parametrize('block', [1, 1 << 20])
def test_the_first_row_is_read_alone(tmp_path, monkeypatch, end, block):
    monkeypatch.setattr('booster_ros.records.csv_text._BLOCK_BYTES', block)
    lines = [HEADER, '', '  ', ' ,0.0004, 150000,0.001', 'what', 'ever']
    first = first_row(write(tmp_path, end.join(lines)), ['valve_position', 'time'])
    assert first.rows.tolist() == [4]
    np.testing.assert_array_equal(first.values, [[0.001, np.nan]])


@pytest.mark.parametrize(('lines', 'says'), [
    (good_lines(), 'row 1: there is no column mass_flow'),
    ([HEADER, '', ' '], 'has a header and no rows of data'),
    ([HEADER, '', '0,0.0004,1e9,0'], 'row 3, column chamber_pressure: 1e+09 is not plausible'),
    ([HEADER, '0,0.0004'], 'row 2: 2 cells where the header has 4'),
])
def test_a_bad_first_row_is_refused(tmp_path, lines, says):
    column = 'mass_flow' if 'mass_flow' in says else 'chamber_pressure'
    with pytest.raises(RecordError, match=re.escape(says)):
        first_row(write(tmp_path, '\n'.join(lines)), [column])


@pytest.mark.parametrize(('lines', 'says'), [
    (good_lines(), 'row 1: there is no column mass_flow'),
    (replaced(7, '0.01,0.0004,150000,0'), 'row 7, column time: runs backwards'),
    (replaced(7, ',0.0004,150000,0'), 'row 7, column time: the time is missing'),
    (replaced(51, '1e7,0.0004,150000,0'), 'row 51, column time: 1e+07 s after the row before'),
    ([HEADER], 'no rows of data'),
])
def test_iteration_refuses(tmp_path, lines, says):
    columns = ['time', 'mass_flow' if 'mass_flow' in says else 'control_current']
    with pytest.raises(RecordError, match=re.escape(says)):
        list(iterate_csv(write(tmp_path, '\n'.join(lines)), columns, rows_per_chunk=3))


@pytest.mark.parametrize(('time', 'says'), [
    (0.05, 'row 51, column time: runs backwards, from 0.48 to 0.05 s'),
    (1.7e9, r'row 51, column time: 1\.7e\+09 s after the row before'),
])
def test_iteration_refuses_a_clock_that_was_set_between_blocks(tmp_path, monkeypatch, time, says):
    monkeypatch.setattr('booster_ros.records.csv_text._BLOCK_BYTES', 1)  # a block is a line
    lines = good_lines(100)
    lines[50:] = [f'{time + row / 100:.2f},0.0004,150000,0' for row in range(50)]
    with pytest.raises(RecordError, match=says):
        list(iterate_csv(write(tmp_path, '\n'.join(lines)), ['time']))


def test_iteration_needs_no_more_memory_for_a_longer_file(tmp_path, monkeypatch):
    monkeypatch.setattr('booster_ros.records.csv_text._BLOCK_BYTES', 50_000)

    def peak(rows: int) -> int:
        path = tmp_path / f'{rows}.csv'
        with CsvWriter(path, ('time', 'control_current')) as writer:
            for first in range(0, rows, 10_000):
                time = np.arange(first, first + 10_000) / 100
                writer.write_rows(np.column_stack([time, np.full(time.size, 4e-4)]))
        tracemalloc.start()
        try:
            assert sum(len(c.rows) for c in iterate_csv(path, ['time', 'control_current'])) == rows
            return tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()

    assert peak(60_000) < 1.2 * peak(20_000)


def test_what_is_written_reads_back(tmp_path):
    random = np.random.default_rng(4)
    names = HEADER.split(',')
    table = np.column_stack([
        np.arange(100) / 100, random.uniform(0, 5e-4, 100), random.uniform(0, 3e5, 100),
        random.uniform(0, 0.016, 100)])
    table[5, 2] = np.nan
    with CsvWriter(tmp_path / 'out.csv', names) as writer:
        writer.write_rows(table[:60])
        assert not (tmp_path / 'out.csv').exists()
        writer.write_rows(table[60:])
    record = read_record(tmp_path / 'out.csv')
    for name, values, step in zip(names, table.T, (1e-6, 1e-12, 1e-3, 1e-9), strict=True):
        np.testing.assert_allclose(record[name], values, rtol=0, atol=0.51 * step)
    assert [path.name for path in tmp_path.iterdir()] == ['out.csv']


def test_an_interrupted_writer_leaves_nothing_and_keeps_the_old_file(tmp_path):
    path = write(tmp_path, 'old')

    def interrupted() -> None:
        with CsvWriter(path, ['time']) as writer:
            writer.write_rows(np.zeros((3, 1)))
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert path.read_text() == 'old'
    assert [path.name for path in tmp_path.iterdir()] == ['record.csv']


def written(path: Path) -> str:
    with CsvWriter(path, ['time']) as writer:
        writer.write_rows(np.zeros((1, 1)))
    return path.read_text()


def test_a_link_is_followed_and_stays(tmp_path):
    kept = tmp_path / 'kept'
    kept.mkdir()
    file, link, chain, ahead = (
        kept / 'file.csv', tmp_path / 'link', tmp_path / 'chain', tmp_path / 'ahead')
    file.write_text('old')
    link.symlink_to(Path('kept') / 'file.csv')
    chain.symlink_to(link)
    ahead.symlink_to(kept / 'new.csv')
    for path, target in ((link, file), (chain, file), (ahead, kept / 'new.csv')):
        assert written(path) == 'time\n0.000000\n'
        assert path.is_symlink()
        assert not target.is_symlink()
        file.write_text('old')
    assert {path.name for path in kept.iterdir()} == {'file.csv', 'new.csv'}


def test_what_is_no_file_is_refused_and_stays(tmp_path):
    pipe, link, circle = (tmp_path / name for name in ('pipe', 'link', 'circle'))
    os.mkfifo(pipe)
    link.symlink_to(pipe)
    circle.symlink_to(circle)
    for path, says in ((pipe, 'it is no file but a device, a pipe or a socket'),
                       (link, 'it is no file'), (tmp_path, 'it is a folder'),
                       (Path('/'), 'it is a folder'), (Path(''), 'it is a folder'),
                       (pipe / 'in.csv', 'Not a directory'),
                       (circle, 'Too many levels of symbolic links')):
        with pytest.raises(RecordError, match=f'{re.escape(str(path))} cannot be written: {says}'):
            CsvWriter(path, ['time'])
    assert pipe.is_fifo()
    assert {path.name for path in tmp_path.iterdir()} == {'pipe', 'link', 'circle'}


def test_a_place_that_cannot_be_written_is_named(tmp_path):
    with pytest.raises(RecordError, match=r'no_folder.out\.csv cannot be written: No such file'):
        CsvWriter(tmp_path / 'no_folder' / 'out.csv', ['time'])
    with pytest.raises(RecordError, match='cannot be written: File name too long'):
        CsvWriter(tmp_path / ('x' * 300), ['time'])


@pytest.mark.parametrize('rows', [1, 10_000])
def test_a_full_disk_is_said_and_nothing_is_left(tmp_path, rows):
    """Whether what was written is refused at once or when the file is closed."""
    def fill():
        with CsvWriter(tmp_path / 'record.csv', ['time']) as writer:
            writer.write_rows(np.zeros((rows, 1)))

    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4, limits[1]))
    try:
        with pytest.raises(RecordError, match=r'record\.csv cannot be written: File too large'):
            fill()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert list(tmp_path.iterdir()) == []


def test_written_numbers_are_those_that_python_formats():
    """To the byte, also at ties, around powers of ten, below zero and for negative zero."""
    random = np.random.default_rng(7)
    table = np.concatenate([
        random.normal(size=(5000, 3)) * 10.0 ** random.integers(-9, 5, (5000, 3)),
        np.array([[0.0, -0.0, 0.0005], [0.0015, -0.0625, 1e-13], [999.9995, 9.9999995, -0.0004]]),
        (random.integers(-99, 99, (500, 3)) + 0.5) * [1e-3, 1e-6, 1e-9],
        random.integers(-99, 99, (500, 3)) / 64.0,
    ])
    decimals = (3, 6, 9)
    expected = ''.join(f'{a:.3f},{b:.6f},{c:.9f}\n' for a, b, c in table.tolist())
    assert fixed_lines(table, decimals) == expected.encode()
    assert fixed_lines(table[:1], decimals) == expected.split('\n', 1)[0].encode() + b'\n'


@pytest.mark.parametrize('value', [np.nan, -np.inf, 1e30])
def test_what_has_no_fixed_digits_is_written_all_the_same(tmp_path, value):
    path = tmp_path / 'out.csv'
    with CsvWriter(path, ('time', 'chamber_pressure')) as writer:
        writer.write_rows(np.array([[0.0, 1.0], [1.0, value]]))
    assert path.read_text() == f'time,chamber_pressure\n0.000000,1.000\n1.000000,{value:.3f}\n'
