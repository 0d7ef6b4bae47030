# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""CSV records read piece by piece, and the first row alone."""

import re
import tracemalloc

from made_csv import HEADER, good_lines, replaced, write
import numpy as np
import pytest

from booster_ros.records import (
    CsvWriter, RecordError, csv_columns, first_row, iterate_csv, read_record)


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


@pytest.mark.parametrize('space', [b'\xa0', b'\x85'])
@pytest.mark.parametrize('block', [100, 1 << 20])
def test_a_space_of_another_encoding_is_refused_wherever_a_portion_begins(
        tmp_path, monkeypatch, space, block):
    """It was read where nothing else in the portion was odd, and refused elsewhere."""
    monkeypatch.setattr('booster_ros.records.csv_text._BLOCK_BYTES', block)
    lines = [line.encode() for line in good_lines()]
    lines[20] = lines[20].replace(b',', space + b',', 1)
    with pytest.raises(RecordError, match='row 21, column time'):
        list(iterate_csv(write(tmp_path, b'\n'.join(lines)), ['time', 'control_current']))
