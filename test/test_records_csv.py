# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""CSV records: which dialects are read, and what is refused in which words."""

import os
from pathlib import Path
import re

from hypothesis import given, settings, strategies
from made_csv import HEADER, defects, good_lines, read_lines, replaced, write
import numpy as np
import pytest

from booster_ros.records import RecordError, read_record
from booster_ros.records.guarded import COMPRESSED


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
    (replaced(1, 'time,control_current (mm),b,c'),
     "row 1, column 'control_current (mm)': mm is no unit of control_current, which is in A"),
    (replaced(1, 'time,control_current (foo),b,c'),
     "row 1, column 'control_current (foo)': 'foo' is no unit that is known"),
    (replaced(1, 'time,b,c,valve_position [%]'),
     "row 1, column 'valve_position [%]': is a share, of what a mapping has to say"),
    (replaced(1, HEADER.replace('valve_position', 'chamber_pressure_quality')),
     "row 1: column 'chamber_pressure_quality' says which values are good"),
    (replaced(1, HEADER + ',' + 'x' * 2_000_000), 'has a line of more than 1 MB'),
    (replaced(1, HEADER + ',x' * 20_000), 'has 20004 columns'),
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


def test_a_word_among_the_numbers_of_the_first_row_is_no_row_of_units(tmp_path):
    with pytest.raises(RecordError, match=r"'Bad' is not a number$"):
        read_lines(tmp_path, replaced(2, '0.0,0.0004,Bad,0'))


@pytest.mark.parametrize(('content', 'says'), [
    (b'', 'the first row is empty'),
    ('time,chamber_pressure\n0,1\n'.encode('utf-16'), 'not a CSV in UTF-8 but UTF-16'),
    (b'PK\x03\x04abc', 'but a zip archive or spreadsheet'),
    (b'\x1f\x8b\x08', 'cannot be read'),
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


@pytest.mark.parametrize(('name', 'unit', 'factor'), [
    ('time', '(ms)', 1e3), ('control_current', '[mA]', 1e3), ('chamber_pressure', '[kPa]', 1e-3),
    ('valve_position', ' (mm)', 1e3)])
def test_another_unit_in_the_header_is_converted_and_noted(tmp_path, name, unit, factor):
    plain = read_lines(tmp_path, good_lines())
    place = HEADER.split(',').index(name)
    rows = [line.split(',') for line in good_lines()[1:]]
    for cells in rows:
        cells[place] = f'{float(cells[place]) * factor:.9g}'
    header = HEADER.replace(name, name + unit)
    record = read_lines(tmp_path, [header, *map(','.join, rows)])
    np.testing.assert_allclose(record[name], plain[name], rtol=1e-8, atol=1e-15)
    assert len(defects(record, 'converted')) == 1


def test_absolute_pressure_that_the_header_names_becomes_gauge_pressure(tmp_path):
    lines = ['time,chamber_pressure [bara]', '0,2.0', '1,2.1']
    record = read_lines(tmp_path, lines)
    np.testing.assert_allclose(record['chamber_pressure'], [98_675.0, 108_675.0])
    assert 'absolute' in defects(record, 'converted')[0].treatment


def test_what_is_no_file_is_refused_before_it_is_read(tmp_path):
    pipe = tmp_path / 'pipe'
    os.mkfifo(pipe)  # nobody writes into it: opening it would wait for ever
    for path in ('/dev/zero', '/dev/full', pipe):
        with pytest.raises(RecordError, match='is a device, a pipe or a socket'):
            read_record(path)


def test_a_file_without_line_ends_is_refused_before_memory_goes(tmp_path):
    path = tmp_path / 'endless.csv'
    with path.open('wb') as file:
        file.truncate(1 << 40)  # a terabyte of zeros that takes no room
    for content in (b'', b'time,chamber_pressure\n0,1\n'):
        with path.open('r+b') as file:
            file.write(content)
        with pytest.raises(RecordError, match='more than 1 MB'):
            read_record(path)


def test_names_of_a_hundred_thousand_characters_take_no_time(tmp_path):
    lines = [f'{HEADER},{"_" * 100_000},chamber_pressur{"e" * 100_000}']
    lines += [f'{line},1,2' for line in good_lines()[1:]]
    record = read_lines(tmp_path, lines)
    assert len(record) == 50
    assert all(len(note) < 500 for note in record.notes)


def test_unknown_columns_may_hold_anything_and_are_noted(tmp_path):
    lines = [line + f',comment {row},x' for row, line in enumerate(good_lines())]
    lines[0] = HEADER + ',chamber_presure,'
    record = read_lines(tmp_path, lines)
    assert list(record.columns) == HEADER.split(',')
    unknown, unnamed = defects(record, 'unknown_column')
    assert unknown.column == 'chamber_presure'
    assert 'is it chamber_pressure?' in unknown.treatment
    assert unnamed.column == f'number {len(HEADER.split(",")) + 2}'


def test_without_time_a_record_is_a_sweep_in_row_order(tmp_path):
    lines = ['chamber_pressure,valve_position', '0,0', '150000,0', '0,0', '300000,0.016']
    record = read_lines(tmp_path, lines)
    assert 'time' not in record
    assert list(record['chamber_pressure']) == [0.0, 150_000.0, 0.0, 300_000.0]


@pytest.mark.parametrize('name', ['row', 'Index', 'n', 'no.', 'sample', 'force', 'demand', 's'])
def test_a_sweep_may_have_a_column_that_rises_as_time_does(tmp_path, name):
    rows = (f'{k},{1000 * k},{1e-5 * k:.6f}' for k in range(300))
    record = read_lines(tmp_path, [f'{name},chamber_pressure,valve_position', *rows])
    assert 'time' not in record
    assert defects(record, 'unknown_column')[0].column == name


@pytest.mark.parametrize('begins', COMPRESSED)
def test_a_file_that_only_begins_as_a_compressed_one_is_refused(tmp_path, begins):
    path = tmp_path / 'r.csv'
    path.write_bytes(begins + b'time,control_current,valve_position\n0,0,0\n')
    with pytest.raises(RecordError, match=r'r\.csv: cannot be read, '):
        read_record(path)


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


@pytest.mark.parametrize('cell', ['_' * 100_000, 'chamber_pressure' + '_' * 100_000 + '[',
                                  'pressure ' * 10_000], ids=['', 'unit', 'words'])
def test_a_long_cell_in_the_header_is_no_column_and_takes_no_time(tmp_path, cell):
    lines = good_lines()
    record = read_lines(tmp_path, [f'{lines[0]},{cell}', *(f'{line},1' for line in lines[1:])])
    assert 'chamber_pressure' in record
    note, = record.ignored
    assert len(note) < 300


@pytest.mark.parametrize('text', [
    b'time,' + b'x' * 1_100_000, b'time,valve_position\n0,0.001\n1,' + b'0' * 6_000_000],
    ids=['header', 'row'])
def test_a_line_without_end_is_refused(tmp_path, text):
    with pytest.raises(RecordError, match='a line of more than 1 MB'):
        read_record(write(tmp_path, text))


def test_a_long_file_of_lines_that_end_in_carriage_returns_alone_is_read(tmp_path):
    rows = 400_000
    text = 'time,valve_position\r' + ''.join(f'{k},0.001\r' for k in range(rows))
    record = read_record(write(tmp_path, text))
    assert len(record) == rows
    assert record.rows[-1] == rows + 1
