# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Files of others, read with the mapping that `inspect` wrote: what is right, and what is asked."""

import re

from made_csv import defects
from made_foreign import TRAVEL, given, lines, mapped, mapping_in, rows, write
import numpy as np
import pytest

from booster_ros.records import RecordError, read_mapping, read_record
from booster_ros.records.mapped import read_runs

PRESSURE = np.array([row[2] for row in rows()], dtype=float)


def with_cells(column: int, cells: dict[int, str], count: int = 40) -> list[str]:
    """Return lines with other text in a column, by the number of the line."""
    text = [line.split(',') for line in lines(count=count)]
    for number, cell in cells.items():
        text[number - 1][column] = cell
    return [','.join(one) for one in text]


@pytest.mark.parametrize('mark', ['Bad', 'Pt Created', 'No Data', '-9999', '-999.25', '32767'])
def test_states_and_sentinels_in_a_column_are_no_pressures(tmp_path, mark):
    path = write(tmp_path, with_cells(2, dict.fromkeys((13, 14, 15), mark)))
    record = mapped(path)
    expected = PRESSURE.copy()
    expected[11:14] = np.nan
    if mark == '32767':  # within the range of the others: it may be a pressure
        expected[11:14] = 32767.0
    np.testing.assert_array_equal(record['chamber_pressure'], expected)
    assert np.isfinite(record['valve_position']).all()


def test_a_word_that_the_mapping_does_not_list_is_refused_by_row(tmp_path):
    path = write(tmp_path, lines())
    mapping = mapping_in(path)
    write(tmp_path, with_cells(2, {20: 'Faulty'}))
    with pytest.raises(RecordError, match=r"row 20: 'Faulty' is not a number; .* missing: \['Fau"):
        read_record(path, mapping=mapping)


@pytest.mark.parametrize(('good', 'bad'), [
    ('Good', 'Bad'), ('192', '0'), ('192.0', '24'), ('GOOD', 'Uncertain')])
def test_values_of_bad_quality_are_not_used(tmp_path, good, bad):
    text = [line + ',' + ('quality' if k == 0 else bad if k in (12, 13, 14) else good)
            for k, line in enumerate(with_cells(2, {13: '0', 14: '0', 15: '0'}))]
    record = mapped(write(tmp_path, text))
    assert np.flatnonzero(np.isnan(record['chamber_pressure'])).tolist() == [11, 12, 13]
    assert sum(one.count for one in defects(record, 'bad_quality')) == 9
    with pytest.raises(RecordError, match="'quality' says which values are good"):
        read_record(tmp_path / 'export.csv')  # never ignored in silence


def test_a_quality_column_of_one_column_says_nothing_of_others(tmp_path):
    text = [line + ',' + ('chamber_pressure_quality' if k == 0 else 'Bad' if k == 5 else 'Good')
            for k, line in enumerate(lines())]
    record = mapped(write(tmp_path, text))
    assert np.flatnonzero(np.isnan(record['chamber_pressure'])).tolist() == [4]
    assert np.isfinite(record['valve_position']).all()


def test_a_loop_of_a_control_system_with_flags_and_a_long_head(tmp_path):
    text = ['PROCESSDATA\tFIC7 Data\tyyyy-MM-dd HH:mm:ss', '8\t10\t2024-09-01 21:55:00\t60',
            'tagname\tFIC7.MV\tFIC7.PV\tFIC7.SV\tFIC7.MODE\tbOpOFL\tbPvOFL\tbSpOFL\tbAutOFL',
            'desc\t阀_OP\t阀_PV\t阀_SP\tAut\tbOpOFL\tbPvOFL\tbSpOFL\tbAutOFL', 'fsMax=3.1\tfsMin=0']
    text += [f'2024-09-01 21:{k // 6:02}:{k % 6 * 10:02}\t{40 + k / 10}\t{900 + k}\t930\t1\t'
             f'{int(k == 7)}\t0\t0\t0' for k in range(60)]
    path = write(tmp_path, '\r\n'.join(text), 'loop.txt')
    with pytest.raises(RecordError, match=r'columns\.process_value\.unit: .*FIC7\.PV'):
        mapped(path)
    record = mapped(path, ('PV", unit: "?"', 'PV", unit: kPa'),
                    ('SV", unit: "?"', 'SV", unit: kPa'))
    assert len(record) == 60
    assert set(np.diff(record['time'])) == {10.0}
    assert record['set_point'][0] == pytest.approx(0.4 * TRAVEL, rel=1e-12)
    assert record['process_value'][0] == 900e3
    assert record['set_point'][7] == record['set_point'][6]  # a command holds
    assert [defect.first_row for defect in defects(record, 'missing_command')] == [13]
    assert np.isfinite(record['process_value']).all()


def test_a_historian_newest_first_with_an_outage(tmp_path):
    text = ['id,date,time,FT_211,FV_211']
    text += [f'{9000 - k},2024-11-26,{5 - k // 60:02}:{59 - k % 60:02}:00,'
             f'{"NULL" if 50 <= k < 60 else 70 + k / 10},{30 + k / 100}' for k in range(200)]
    record = mapped(write(tmp_path, '\ufeff' + '\n'.join(text)), ('unit: "?"', 'unit: kg/h'))
    assert len(record) == 200
    assert set(np.diff(record['time'])) == {60.0}
    assert np.isnan(record['process_value']).sum() == 10
    assert record['process_value'][-1] == pytest.approx(70 / 3600, rel=1e-12)
    assert record['set_point'][0] == pytest.approx(0.3199 * TRAVEL, rel=1e-12)
    assert defects(record, 'newest_first')


def test_a_logger_without_header(tmp_path):
    text = [f'{40 + 10 * k}.000\t4.478\t0.004\t{1.014 + k / 1000:.3f}' for k in range(60)]
    path = write(tmp_path, '\r\n'.join(text))
    record = mapped(path, ('[1], unit: "?"', '[1], unit: ms'),
                    ('# NAME: {from: 3, unit: "?"}', 'valve_position: {from: 3, unit: mm}'),
                    ('# NAME: {from: 4, unit: "?"}',
                     'chamber_pressure: {from: 4, unit: bar, gauge: true}'))
    assert record['chamber_pressure'][0] == pytest.approx(101_400.0)
    assert record['time'][1] - record['time'][0] == pytest.approx(0.01)
    assert record['valve_position'][0] == 4e-6


def test_where_gauge_and_absolute_are_both_possible_it_is_asked(tmp_path):
    text = ['time,P act [bar]', *(f'{k},{1.014 + k / 100:.3f}' for k in range(40))]
    path = write(tmp_path, text)
    with pytest.raises(RecordError, match='gauge: true or gauge: false'):
        mapped(path)
    gauge = mapped(path, ('gauge: "?"', 'gauge: true'))
    absolute = mapped(path, ('gauge: "?"', 'gauge: false'))
    assert gauge['chamber_pressure'][0] == pytest.approx(101_400.0)
    assert absolute['chamber_pressure'][0] == pytest.approx(75.0)
    assert any('absolute' in note for note in absolute.notes)
    short = given(tmp_path, 'time: time\ncolumns: {chamber_pressure: "P act [bar]"}')
    with pytest.raises(RecordError, match='may be gauge or absolute'):
        read_record(path, mapping=short)


def test_a_pressure_that_falls_below_half_an_atmosphere_is_gauge_pressure(tmp_path):
    text = ['Timestamp_s,Setpoint_kPa,Feedback_kPa',
            *(f'{k / 20:.4f},{k},{2.219 + k}' for k in range(100))]
    record = mapped(write(tmp_path, text))
    assert record['chamber_pressure'][0] == pytest.approx(2219.0, rel=1e-12)
    assert record.beside['set_point'].unit == 'Pa'
    short = given(tmp_path, 'time: Timestamp_s\ncolumns: {chamber_pressure: Feedback_kPa}')
    record = read_record(tmp_path / 'export.csv', mapping=short)
    assert any('so it is gauge pressure' in note for note in record.notes)


def test_a_unit_that_is_nowhere_is_asked_for_by_name(tmp_path):
    text = ['Time,Target,Pressure,PWM', *(f'{k / 50:.3f},35.0,{0.22 + k},0' for k in range(60))]
    path = write(tmp_path, text)
    with pytest.raises(RecordError, match=r"set_point\.unit: the unit of 'Target'"):
        mapped(path)
    with pytest.raises(RecordError, match=r"chamber_pressure\.unit: the unit of 'Pressure'"):
        mapped(path, ('Target, unit: "?"', 'Target, unit: kPa'))
    record = mapped(path, ('Pressure, unit: "?"', 'Pressure, unit: kPa'),
                    ('Target, unit: "?"', 'Target, unit: kPa'))
    assert record['set_point'][0] == 35e3
    assert record['chamber_pressure'][0] == pytest.approx(220.0)


def test_numbers_too_small_or_large_for_their_unit_are_asked_about(tmp_path):
    text = ['time,back_pressure,control_current',
            *(f'{k},{300 + k},{4 + k / 10}' for k in range(40))]
    path = write(tmp_path, text)
    with pytest.raises(RecordError, match='the unit of'):
        mapped(path)
    record = mapped(path, ('back_pressure, unit: "?"', 'back_pressure, unit: Pa'),
                    ('control_current, unit: "?"', 'control_current, unit: mA'))
    assert record['back_pressure'][0] == 300.0
    assert record['control_current'][0] == 0.004


def test_per_cent_are_of_the_travel_or_of_a_range(tmp_path):
    text = ['time,AO [%],Travel [%]', *(f'{k},{k},{2.5 * (k % 10)}' for k in range(40))]
    path = write(tmp_path, text)
    with pytest.raises(RecordError, match='of: is a share, of what is not known'):
        read_record(path, mapping=given(
            tmp_path, 'time: time\ncolumns: {control_current: "AO [%]"}'))
    mapping = given(tmp_path, 'time: time\ncolumns:\n  control_current: {from: "AO [%]", '
                              'of: [4 mA, 20 mA]}\n  valve_position: "Travel [%]"')
    record = read_record(path, mapping=mapping, travel=TRAVEL)
    np.testing.assert_allclose(record['control_current'], 0.004 + 0.00016 * np.arange(40))
    assert record['valve_position'][1] == pytest.approx(0.0005)
    with pytest.raises(RecordError, match='travel, which is not known; say travel: 20 mm'):
        read_record(path, mapping=mapping)


def test_runs_in_one_file_are_records_of_their_own(tmp_path):
    path = write(tmp_path, [*lines(), *lines()[1:31]])
    record = mapped(path)
    assert len(record) == 40  # the longest, as inspect chose and wrote
    assert any('run 1 of 2' in note for note in record.notes)
    assert [len(one) for one in read_runs(path, mapping_in(path))] == [40, 30]
    second = mapped(path, ('run: 1', 'run: 2'))
    assert (len(second), second['time'][0]) == (30, 0.0)
    with pytest.raises(RecordError, match=r'2 runs, each a record .*say which, as in run: 1'):
        mapped(path, ('run: 1', ''))
    with pytest.raises(RecordError, match='there is no run 3'):
        mapped(path, ('run: 1', 'run: 3'))


def test_what_is_stored_by_exception_holds_and_its_noise_is_not_there(tmp_path):
    text = lines()[:1]
    for k, (t, i, p, x) in enumerate(rows()):
        text.append(f'{t},{i if k % 10 == 0 else ""},{p if k % 3 == 0 else ""},'
                    f'{x if k % 7 == 0 else ""}')
    record = mapped(write(tmp_path, text))
    assert record['chamber_pressure'][:6].tolist() == [20e3] * 3 + [26e3] * 3
    assert np.isfinite(record['valve_position']).all()
    assert record.held['chamber_pressure'] == 6000.0
    assert 'stored by exception' in str(defects(record, 'held')[0])


def test_long_tables_are_pivoted(tmp_path):
    text = ['Tag,Timestamp,Value,Quality']
    for t, _, p, x in rows():
        bad = t == 12
        text += [f'PT1.kPa,2024-05-01 10:00:{t:02}.000,{"Bad Input" if t == 5 else p / 1000},'
                 f'{"Bad" if bad else "Good"}',
                 f'ZT1,2024-05-01 10:00:{t:02}.250,{x * 1000},Good']
    path = write(tmp_path, text)
    mapping = given(tmp_path, '\n'.join([
        'time: Timestamp', 'long: {tag: Tag, value: Value}', 'columns:',
        '  chamber_pressure: {from: PT1.kPa, unit: kPa, gauge: true}',
        '  valve_position: {from: ZT1, unit: mm}', 'missing: [Bad Input]',
        'quality: {column: Quality, good: [Good]}']))
    record = read_record(path, mapping=mapping)
    assert len(record) == 80
    assert record['time'][:3].tolist() == [0.0, 0.25, 1.0]
    pressure = record['chamber_pressure'][::2]
    assert np.flatnonzero(np.isnan(pressure)).tolist() == [5, 12]
    assert pressure[1] == 22e3
    np.testing.assert_allclose(record['valve_position'][1::2], [row[3] for row in rows()])
    guessed = mapping_in(path)
    assert (guessed.long.tag, guessed.long.value) == ('Tag', 'Value')


@pytest.mark.parametrize(('text', 'says'), [
    ('columns: {chamber_presure: P}', r'chamber_presure is not a column .*is it chamber_pressure'),
    ('columns: {chamber_pressure: {frm: P}}', "'frm' has no meaning there"),
    ('columns: {chamber_pressure: {unit: kPa}}', 'give the name of a column'),
    ('columns: {}', 'names no column of a record'),
    ('columns: {chamber_pressure: Q}', r"has no column 'Q'; it has 'time', 'P \[kPa\]'"),
    ('columns: {chamber_pressure: 9}', 'has no column 9, it has 2'),
    ('columns: {chamber_pressure: {from: "P [kPa]", unit: furlong^9}}', 'no unit of|no unit that'),
    ('columns: {chamber_pressure: {from: "P [kPa]", unit: mA}}', 'mA is no unit of chamber_pressu'),
    ('columns: {chamber_pressure: {from: "P [kPa]", unit: kPaa, gauge: true}}', 'contradict'),
    ('time: {columns: time, unit: mA}\ncolumns: {chamber_pressure: 2}', 'mA is no unit of time'),
    ('time: {columns: time, unit: s, zone: Berlin}\ncolumns: {chamber_pressure: 2}',
     'there is no zone'),
    ('time: {unit: s}\ncolumns: {chamber_pressure: 2}', 'give the columns that hold the time'),
    ('columns: {chamber_pressure: 2}\nrun: -1', '-1 is not the number of a run'),
    ('columns: {chamber_pressure: 2}\nfile: {header: x}', "'x' is not the number of a line"),
    ('columns: {chamber_pressure: 2}\nfile: {first: 900}', 'no line has numbers|has no line'),
    ('columns: &a {chamber_pressure: 2}\nheld: *a', 'has no aliases'),
    ('columns: [', 'is not YAML'), ('- 1', 'is not a table'), ('', 'is not a table'),
    ('quality: {column: 2}\ncolumns: {chamber_pressure: 2}', 'which values mean that a row is g'),
])
def test_a_mapping_that_is_wrong_is_one_sentence(tmp_path, text, says):
    path = write(tmp_path, ['time,P [kPa]', *(f'{k},{k}' for k in range(30))])
    with pytest.raises(RecordError, match=says) as refusal:
        read_record(path, mapping=given(tmp_path, text))
    assert '\n' not in str(refusal.value)


def test_a_mapping_that_is_no_file_is_refused(tmp_path):
    for path in ('/dev/zero', tmp_path):
        with pytest.raises(RecordError, match='is no file'):
            read_mapping(path)
    with pytest.raises(RecordError, match='No such file'):
        read_mapping(tmp_path / 'none.yaml')


def test_a_row_with_too_many_cells_is_not_cut(tmp_path):
    path = write(tmp_path, lines())
    mapping = mapping_in(path)
    text = lines()
    text[19] += ',5,6'
    write(tmp_path, text)
    with pytest.raises(RecordError, match='row 20 has 6 cells where the others have 4'):
        read_record(path, mapping=mapping)


def test_notes_tell_what_each_column_was_read_from(tmp_path):
    text = ['time,P act (psi)', *(f'{k},{k}' for k in range(40))]
    record = mapped(write(tmp_path, text))
    assert re.search(r"chamber_pressure: read from 'P act \(psi\)', converted from psi to Pa",
                     '\n'.join(record.notes))
    assert record['chamber_pressure'][1] == pytest.approx(6894.757293)


def test_a_table_where_names_of_columns_stand_is_told(tmp_path):
    with pytest.raises(RecordError, match=r'held: .* is not a column of a record'):
        given(tmp_path, 'columns: {chamber_pressure: P}\nheld: [{a: 1}]')
