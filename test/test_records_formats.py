# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tables that are no plain CSV: workbooks, Parquet, MATLAB, JSON lines, compressed, odd text."""

import bz2
from contextlib import suppress
from datetime import datetime, timedelta
import gzip
import io
import json
import lzma
import shutil
import sys
import zipfile

from made_foreign import given, lines, mapped, mapping_in, rows, write
import numpy as np
import pandas as pd
import pytest

from booster_ros.records import RecordError, read_record
from booster_ros.records.inspection import inspect

NAMES = ['time', 'control_current', 'chamber_pressure', 'valve_position']
COLUMNS = dict(zip(NAMES, np.array(rows()).T))


def check(record):
    """Check that a record holds the rows of the saw tooth."""
    assert len(record) == 40
    for name, values in COLUMNS.items():
        np.testing.assert_allclose(record[name], values, atol=1e-12)


@pytest.mark.parametrize(('name', 'compress'), [
    ('a.csv.gz', gzip.compress), ('a.csv.bz2', bz2.compress), ('a.csv.xz', lzma.compress)])
def test_compressed_text_is_read_by_its_own_names(tmp_path, name, compress):
    path = write(tmp_path, compress('\n'.join(lines()).encode()), name)
    check(read_record(path))
    path.write_bytes(path.read_bytes()[:-20])
    with pytest.raises(RecordError, match='cannot be read'):
        read_record(path)


def test_what_unpacks_to_endless_lines_is_refused(tmp_path):
    path = write(tmp_path, gzip.compress(b'time,chamber_pressure\n' + bytes(50 << 20)), 'bomb.gz')
    with pytest.raises(RecordError, match=r'more than 1 MB|binary'):
        read_record(path)


@pytest.mark.parametrize(('encoding', 'mark'), [
    ('cp1252', b''), ('utf-8-sig', b''), ('utf-16', b'')])
def test_encodings(tmp_path, encoding, mark):
    text = '\n'.join(f'{line},{"Temperatur °C" if k == 0 else 20}'
                     for k, line in enumerate(lines()))
    check(mapped(write(tmp_path, mark + text.encode(encoding))))


@pytest.mark.parametrize(
    ('delimiter', 'decimal'), [(';', ','), ('\t', ','), ('\t', '.'), ('|', '.')])
def test_delimiters_and_decimal_signs(tmp_path, delimiter, decimal):
    text = [line.replace(',', delimiter).replace('.', decimal) for line in lines()]
    check(mapped(write(tmp_path, text)))


def test_columns_separated_by_spaces(tmp_path):
    check(mapped(write(tmp_path, ['  '.join(line.split(',')) for line in lines()])))


@pytest.mark.parametrize(('delimiter', 'thousands', 'decimal'), [(';', '.', ','), ('\t', ',', '.')])
def test_signs_between_thousands(tmp_path, delimiter, thousands, decimal):
    text = [delimiter.join(['time', 'chamber_pressure'])]
    text += [f'{k}{delimiter}{20 + 2 * (k % 10)}{thousands}000{decimal}5' for k in range(40)]
    record = mapped(write(tmp_path, text))
    np.testing.assert_array_equal(record['chamber_pressure'], COLUMNS['chamber_pressure'] + 0.5)


def test_a_word_among_decimal_commas_spoils_no_number(tmp_path):
    text = ['time;P act [kPa]', *(f'{k};{20 + k / 8:.3f}'.replace('.', ',') for k in range(40))]
    text[8] = '7;Bad'
    record = mapped(write(tmp_path, text))
    assert np.flatnonzero(np.isnan(record['chamber_pressure'])).tolist() == [7]
    assert record['chamber_pressure'][1] == 20_125.0


def test_commas_that_may_be_either_are_asked_about(tmp_path):
    path = write(tmp_path, ['time;chamber_pressure', *(f'{k};{999 + k:,}' for k in range(40))])
    with pytest.raises(RecordError, match="'1,000' has a comma for decimals or for thousands"):
        mapping_in(path)
    text = 'time: time\ncolumns: {chamber_pressure: {from: chamber_pressure, unit: Pa}}\n'
    for signs, last in (('decimal: ".", thousands: ","', 1038.0), ('decimal: ","', 1.038)):
        record = read_record(path, mapping=given(tmp_path, f'file: {{{signs}}}\n{text}'))
        assert record['chamber_pressure'][-1] == last


def test_dates_with_points_are_no_numbers_where_points_separate_thousands(tmp_path):
    text = ['Datum;Zeit;P act [Pa]', *(f'0{1 + k // 20}.02.2024;10:{k:02}:00;2{k:02}.000,5'
                                       for k in range(40))]
    record = mapped(write(tmp_path, text), ('gauge: "?"', 'gauge: true'))
    assert record['chamber_pressure'][1] == 201_000.5
    assert record['time'][1] == 60.0


def test_three_decimals_are_no_thousands(tmp_path):
    text = ['time;P [bar]', *(f'{k};{0.2 + k / 100:.3f}'.replace('.', ',') for k in range(40))]
    record = mapped(write(tmp_path, text))
    np.testing.assert_allclose(record['chamber_pressure'], 20e3 + 1e3 * np.arange(40))


@pytest.mark.parametrize('head', [
    ['# test bench 3'], ['Exported by Historian', 'Tag list: FV211', ''],
    ['Settings:', 'gain;3', 'Data:'], ['my test', '1.5,0.004']])
def test_what_stands_above_the_table_is_passed_over(tmp_path, head):
    check(mapped(write(tmp_path, [*head[:-1], *([head[-1]] if head[-1][:1] != '1' else []),
                                  *lines()])))


def test_a_row_of_units_is_read(tmp_path):
    text = lines()
    text[1:] = [f'{1000 * t},{1000 * i:.4g},{p / 1000},{1000 * x:.4g}' for t, i, p, x in rows()]
    text.insert(1, 'ms,mA,kPa,mm')
    check(mapped(write(tmp_path, text)))


def test_a_comma_at_the_end_of_rows_is_no_column(tmp_path):
    check(mapped(write(tmp_path, [line + (',' if k else '') for k, line in enumerate(lines())])))


def frame(**more):
    import pandas as pd
    return pd.DataFrame({**COLUMNS, **more})


@pytest.mark.parametrize('form', ['parquet', 'feather'])
def test_parquet_and_feather(tmp_path, form):
    pytest.importorskip('pyarrow')
    path = tmp_path / f'a.{form}'
    getattr(frame(), f'to_{form}')(path)
    check(read_record(path))
    renamed = frame().rename(columns={'chamber_pressure': 'P act [Pa]'})
    renamed['time'] = [datetime(2024, 5, 1) + timedelta(seconds=k) for k in range(40)]
    getattr(renamed, f'to_{form}')(path)
    record = mapped(path)
    np.testing.assert_array_equal(record['time'], COLUMNS['time'])
    np.testing.assert_array_equal(record['chamber_pressure'], COLUMNS['chamber_pressure'])
    path.write_bytes(path.read_bytes()[:200])
    with pytest.raises(RecordError, match='is damaged'):
        read_record(path)


@pytest.mark.parametrize('head', [
    [], [['FV-7, exported by N. N.'], ['Operator', 'N. N.'], []], [['FV-7'], ['Settings:', 5]]])
@pytest.mark.parametrize('units', [False, True])
def test_a_sheet_with_a_preamble(tmp_path, head, units):
    openpyxl = pytest.importorskip('openpyxl')
    book = openpyxl.Workbook()
    sheet = book.active
    for row in head:
        sheet.append(row)
    if units:
        sheet.append(['Stamp', 'AO', 'P act', 'Travel'])
        sheet.append([None, 'mA', 'kPa', 'mm'])
    else:
        sheet.append(['Stamp', 'AO [mA]', 'P act [kPa]', 'Travel [mm]'])
    for t, i, p, x in rows():
        sheet.append([datetime(2024, 5, 1) + timedelta(seconds=t), 1e3 * i, p / 1e3, 1e3 * x])
    sheet.cell(sheet.max_row - 3, 9).font = openpyxl.styles.Font(bold=True)  # nothing is in it
    path = tmp_path / 'a.xlsx'
    book.save(path)
    found = inspect(path)
    assert len(found.table.names) == 4
    assert found.table.layout.header == len(head) + 1
    check(mapped(path))


def test_a_preamble_that_a_spreadsheet_filled_up_with_commas(tmp_path):
    check(mapped(write(tmp_path, ['FV-7,,,', 'Operator,N. N.,,', ',,,', *lines()])))


def test_a_sheet_that_a_workbook_lacks_is_named_with_those_it_has(tmp_path):
    openpyxl = pytest.importorskip('openpyxl')
    book = openpyxl.Workbook()
    book.create_sheet('notes').append(['nothing', 'here'])
    path = tmp_path / 'a.xlsx'
    book.save(path)
    with pytest.raises(RecordError, match="has no sheet 'data'; it has Sheet, notes"):
        read_record(path, mapping=given(
            tmp_path, 'file: {sheet: data}\ncolumns: {chamber_pressure: P act}'))


def test_matlab_vectors_structures_and_version_7_3(tmp_path):
    from scipy.io import savemat
    savemat(tmp_path / 'a.mat', {'run': {**COLUMNS, 'rate': 1.0}, 'comment': 'x'})
    names = {f'run.{name}' for name in NAMES}
    path = tmp_path / 'a.mat'
    assert {str(one.source) for one in mapping_in(path).columns.values()} <= names
    h5py = pytest.importorskip('h5py')
    savemat(path, {name: values[:, None] for name, values in COLUMNS.items()})
    check(read_record(path))
    with h5py.File(path, 'w') as file:
        for name, values in COLUMNS.items():
            file[name] = values[None, :]
    check(read_record(path))
    path.write_bytes(path.read_bytes()[:300])
    with pytest.raises(RecordError, match='is no readable MATLAB file'):
        read_record(path)


def test_json_lines(tmp_path):
    text = [json.dumps(dict(zip(NAMES, row))) for row in rows()]
    check(mapped(write(tmp_path, text, 'a.jsonl')))
    path = write(tmp_path, [*text[:5], '{broken', *text[5:]], 'a.jsonl')
    with pytest.raises(RecordError, match='is not one JSON object a line'):
        mapped(path)


@pytest.mark.parametrize(('content', 'says'), [
    (b'\xd0\xcf\x11\xe0' + bytes(50), 'old Excel file'), (b'%PDF-1.4', 'is a PDF'),
    (b'PK\x03\x04' + bytes(50), 'is a zip archive'), (b'', 'is empty'),
    (b'hello\nworld\n', 'no line has numbers'), (b'\x00\x01\x02' * 50, 'binary|no table')])
def test_what_is_no_table_is_told(tmp_path, content, says):
    path = write(tmp_path, content)
    with pytest.raises(RecordError, match=says):
        mapping_in(path)


def test_a_compressed_file_that_is_damaged_within_is_refused(tmp_path):
    packed = gzip.compress('\n'.join(lines()).encode())
    for place in range(12, len(packed) - 8, 5):
        damaged = bytearray(packed)
        damaged[place] ^= 0x55
        with pytest.raises(RecordError):
            read_record(write(tmp_path, bytes(damaged), 'a.csv.gz'))


def test_a_workbook_whose_rows_are_damaged_is_refused(tmp_path):
    pytest.importorskip('openpyxl')
    whole, broken = io.BytesIO(), io.BytesIO()
    pd.DataFrame(dict(zip(NAMES, COLUMNS.values()))).to_excel(whole, index=False)
    with zipfile.ZipFile(whole) as before, zipfile.ZipFile(broken, 'w') as after:
        for name in before.namelist():
            content = before.read(name)
            after.writestr(name, content[:-300] if 'sheet1' in name else content)
    with pytest.raises(RecordError, match=r'a\.xlsx: is no readable workbook'):
        mapped(write(tmp_path, broken.getvalue(), 'a.xlsx'))


def test_json_lines_of_another_encoding_are_asked_about(tmp_path):
    text = '\n'.join(json.dumps(dict(zip(NAMES, row))) for row in rows())
    path = write(tmp_path, text.encode() + b'\n{"note": "\x81"}\n', 'a.jsonl')
    with pytest.raises(RecordError, match=r'is not .* throughout; say what it is in the mapping'):
        mapped(path)


def test_what_pandas_put_beside_a_table_may_be_damaged(tmp_path):
    pyarrow = pytest.importorskip('pyarrow')
    parquet = pytest.importorskip('pyarrow.parquet')
    path = tmp_path / 'a.parquet'
    table = pyarrow.Table.from_pandas(pd.DataFrame(dict(zip(NAMES, COLUMNS.values()))))
    notes = table.schema.metadata[b'pandas'].replace(b'numpy_type', b'mumpy_type')
    parquet.write_table(table.replace_schema_metadata({b'pandas': notes}), path)
    check(mapped(path))


@pytest.mark.parametrize('form', ['parquet', 'feather'])
def test_the_index_of_a_table_is_a_column_like_others(tmp_path, form):
    pytest.importorskip('pyarrow')
    frame = pd.DataFrame({name: COLUMNS[name] for name in NAMES[1:]},
                         index=pd.Index(COLUMNS['time'], name='time'))
    path = tmp_path / f'a.{form}'
    if form == 'parquet':
        frame.to_parquet(path)
    else:
        frame.reset_index().to_feather(path)
    check(mapped(path))


def test_a_matlab_file_that_breaks_its_reader_is_refused(tmp_path, monkeypatch):
    """This damage ends the process that scipy reads it in, at least on some machines."""
    from scipy.io import savemat
    whole, random = io.BytesIO(), np.random.default_rng(38)
    savemat(whole, {'run': COLUMNS})
    damaged = bytearray(whole.getvalue())
    for place in random.integers(128, len(damaged), 3):
        damaged[place] = random.integers(256)
    path = write(tmp_path, bytes(damaged), 'a.mat')
    with suppress(RecordError):
        inspect(path)
    path.write_bytes(whole.getvalue())
    monkeypatch.setattr(sys, 'executable', shutil.which('false'))  # any reader that breaks
    with pytest.raises(RecordError, match=r'a\.mat: is no readable MATLAB file \(it ends the proc'):
        inspect(path)
