# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Times as loggers write them: formats, zones, counters that wrap, rows in any order."""

from datetime import datetime, timedelta

from made_csv import defects
from made_foreign import given, lines, mapped, rows, write
import numpy as np
import pytest

from booster_ros.records import RecordError, read_record


def with_times(times: list[str], head: str = 'time', separator: str = ',') -> list[str]:
    """Return lines with these times."""
    names = [head, 'control_current', 'chamber_pressure', 'valve_position']
    return [separator.join(names), *(
        separator.join([time, f'{row[1]:.4g}', str(row[2]), f'{row[3]:.4g}'])
        for time, row in zip(times, rows(len(times))))]


def moments(begin: datetime, form: str, count: int = 40, step: float = 1.0) -> list[str]:
    """Return evenly spaced times as text."""
    return [(begin + timedelta(seconds=step * k)).strftime(form) for k in range(count)]


@pytest.mark.parametrize('form', [
    '%Y-%m-%d %H:%M:%S', '%Y-%m-%dT%H:%M:%S', '%Y-%m-%dT%H:%M:%SZ', '%Y-%m-%d %H:%M:%S.%f',
    '%Y-%m-%dT%H:%M:%S+02:00', '%d.%m.%Y %H:%M:%S', '%d/%m/%Y %H:%M:%S', '%m/%d/%Y %I:%M:%S %p',
    '%Y/%m/%d %H:%M:%S', '%d-%b-%Y %H:%M:%S', '%Y%m%d %H%M%S', '%H:%M:%S', '%H:%M:%S.%f',
    '%d-%b-%y %H:%M:%S.%f'])
def test_text_is_read_in_the_format_that_it_is_in(tmp_path, form):
    begin = datetime(2024, 10, 27, 23, 59, 45)  # midnight is passed
    path = write(tmp_path, with_times(moments(begin, form)))
    record = mapped(path)
    np.testing.assert_allclose(record['time'], np.arange(40), atol=1e-9)
    assert record['chamber_pressure'][1] == 22e3


@pytest.mark.parametrize('form', ['%d/%m/%Y %H:%M:%S', '%m-%d-%Y %H:%M:%S', '%d/%m/%y %H:%M'])
def test_day_and_month_that_may_be_either_way_round_are_asked_for(tmp_path, form):
    begin = datetime(2011, 11, 12, 23, 59, 0)
    path = write(tmp_path, with_times(moments(begin, form, step=60.0)))
    with pytest.raises(RecordError, match='day and month could be either way round'):
        mapped(path)
    record = mapped(path, ('format: "?"', f'format: "{form}"'))
    assert set(np.diff(record['time'])) == {60.0}
    plain = given(tmp_path, 'time: time\ncolumns: {chamber_pressure: chamber_pressure}')
    with pytest.raises(RecordError, match='write which as the format'):
        read_record(path, mapping=plain)


def test_the_other_order_of_day_and_month_gives_another_time(tmp_path):
    path = write(tmp_path, with_times(['01/02/2024 00:00:00', '02/02/2024 00:00:00',
                                       '03/02/2024 00:00:00', '04/02/2024 00:00:00']))
    day = mapped(path, ('format: "?"', 'format: "%d/%m/%Y %H:%M:%S"'))
    assert day['time'][1] == 86400.0
    with pytest.raises(RecordError, match='s after the row before'):  # months, not days
        mapped(path, ('format: "?"', 'format: "%m/%d/%Y %H:%M:%S"'))


def test_a_time_that_is_not_in_the_format_is_named(tmp_path):
    times = moments(datetime(2024, 5, 1), '%Y-%m-%d %H:%M:%S')
    times[10] = '2024-05-01 99:00:00'
    with pytest.raises(RecordError, match="row 12: the time '2024-05-01 99:00:00' is not in the"):
        read_record(write(tmp_path, with_times(times)), mapping=given(
            tmp_path, 'time: {columns: time, format: "%Y-%m-%d %H:%M:%S"}\n'
                      'columns: {chamber_pressure: chamber_pressure}'))


def test_date_and_time_in_two_columns_are_one_time(tmp_path):
    begin = datetime(2024, 10, 27, 1, 59, 30)
    times = moments(begin, '%Y-%m-%d,%H:%M:%S')
    record = mapped(write(tmp_path, with_times(times, 'date,time')))
    assert record['time'].tolist() == list(range(40))


@pytest.mark.parametrize(('head', 'unit', 'step'), [
    ('time_ms', '', 1000), ('Time (ms)', '', 1000), ('t_us', '', 1e6), ('millis', '', 1000),
    ('Timestamp_s', '', 1), ('Elapsed [min]', '', 1 / 60), ('Zeit', 's', 1), ('t', 'ms', 1000)])
def test_units_of_numbers_are_in_the_name_or_asked_for(tmp_path, head, unit, step):
    path = write(tmp_path, with_times([f'{k * step:.10g}' for k in range(40)], head))
    edits = []
    if unit:
        with pytest.raises(RecordError, match='the unit of the time is not known'):
            mapped(path)
        edits = [('unit: "?"', f'unit: {unit}')]
    np.testing.assert_allclose(mapped(path, *edits)['time'], np.arange(40), atol=1e-8)


def test_nanoseconds_since_1970_are_exact(tmp_path):
    begin = 1_730_000_000_123_456_789
    times = [str(begin + 10_000_000 * k) for k in range(40)]
    record = mapped(write(tmp_path, with_times(times, 'stamp')))
    np.testing.assert_array_equal(record['time'], np.arange(40) * 10_000_000 / 1e9)


@pytest.mark.parametrize(('first', 'zone_moves'), [(1_730_000_000, -1), (0, 1)])
def test_a_clock_that_was_changed_by_an_hour_needs_its_zone(tmp_path, first, zone_moves):
    times = [first + 60 * k + (zone_moves * 3600 if k >= 60 else 0) for k in range(120)]
    path = write(tmp_path, with_times(list(map(str, times))))
    with pytest.raises(RecordError, match=r'zone: the clock on the wall was changed by an hour'):
        mapped(path)
    record = mapped(path, ('zone: "?"', 'zone: Europe/Berlin'))
    assert set(np.diff(record['time'])) == {60.0}
    assert not defects(record, 'gap')
    assert len(defects(record, 'clock_change')) == 1


def test_the_hour_that_comes_twice_in_a_zone_is_two_hours(tmp_path):
    wall = [datetime(2024, 10, 27, 2, 30) + timedelta(minutes=k) for k in range(30)]
    wall += [datetime(2024, 10, 27, 2, 0) + timedelta(minutes=k) for k in range(90)]
    path = write(tmp_path, with_times([one.strftime('%Y-%m-%d %H:%M:%S') for one in wall]))
    record = mapped(path, ('zone: "?"', 'zone: Europe/Berlin'))
    assert set(np.diff(record['time'])) == {60.0}


def test_the_hour_that_a_zone_leaves_out_is_no_gap(tmp_path):
    wall = [datetime(2024, 3, 31, 1, 30) + timedelta(minutes=k + 60 * (k >= 30))
            for k in range(90)]
    path = write(tmp_path, with_times([one.strftime('%Y-%m-%d %H:%M:%S') for one in wall]))
    record = mapped(path, ('zone: "?"', 'zone: Europe/Berlin'))
    assert set(np.diff(record['time'])) == {60.0}
    plain = mapped(path, ('zone: "?"', 'zone: UTC'))
    assert defects(plain, 'gap')


def test_newest_first_is_turned_round(tmp_path):
    text = lines()
    record = mapped(write(tmp_path, [text[0], *text[:0:-1]]))
    assert record['time'].tolist() == list(range(40))
    assert record['chamber_pressure'][1] == 22e3
    assert record.rows[0] == 41


@pytest.mark.parametrize(
    ('bits', 'unit', 'step'), [(16, 'ms', 20), (32, 'ms', 10), (32, 'us', 5000)])
def test_a_counter_that_wraps_runs_on(tmp_path, bits, unit, step):
    times = [str((2**bits - 10 * step + 3 + step * k) % 2**bits) for k in range(40)]
    record = mapped(write(tmp_path, with_times(times, f'time_{unit}')))
    scale = {'ms': 1e-3, 'us': 1e-6}[unit]
    np.testing.assert_allclose(np.diff(record['time']), step * scale, rtol=1e-6)
    assert 'wrapped' in str(defects(record, 'wrapped_counter')[0])


def test_a_counter_that_restarts_begins_another_run(tmp_path):
    text = lines()
    text.insert(1, '4.29497e+06,0.004,20000,0')
    record = mapped(write(tmp_path, text))
    assert len(record) == 40
    assert record['time'][0] == 0.0


def test_a_few_rows_out_of_order_are_sorted(tmp_path):
    text = lines(count=200)
    text[50], text[51] = text[51], text[50]
    record = mapped(write(tmp_path, text))
    assert record['time'].tolist() == list(range(200))
    assert record['chamber_pressure'][49] == rows(200)[49][2]
    assert defects(record, 'disorder')


def test_an_interval_in_the_preamble_is_the_time(tmp_path):
    text = ['Recorder X', 'Sampling interval: 20 ms', '', 'P act [kPa]\tTravel [mm]', 'ch 1\tch 2']
    text += [f'{k}\t{k / 10}' for k in range(50)]
    record = mapped(write(tmp_path, text))
    np.testing.assert_allclose(record['time'], 0.02 * np.arange(50))


def test_a_year_that_no_clock_shows_is_refused(tmp_path):
    times = moments(datetime(2024, 5, 1), '%Y-%m-%d %H:%M:%S')
    times[10] = times[10].replace('2024', '2524')
    with pytest.raises(RecordError, match=r"row 12: the time '2524-.* is not within the years"):
        mapped(write(tmp_path, with_times(times)))
