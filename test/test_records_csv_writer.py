# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""CSV records as they are written: whole or not at all, and to the last digit."""

import os
from pathlib import Path
import re
import resource

from made_csv import HEADER, write
import numpy as np
import pytest

from booster_ros.records import CsvWriter, RecordError, read_record
from booster_ros.records.csv_digits import fixed_lines


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


def test_a_file_that_is_spared_stays_and_the_new_one_is_beside_it(tmp_path):
    for name, beside, alone in (('record.csv', 'record.partial.csv', 'new.csv'),
                                ('record', 'record.partial', 'new')):
        (tmp_path / name).write_text('old')
        (tmp_path / beside).write_text('an earlier one')
        for path, place in ((name, beside), (alone, alone)):
            writer = CsvWriter(tmp_path / path, ['time'])
            writer.write_rows(np.zeros((1, 1)))
            writer.spare()
            writer.close()
            assert writer.path == tmp_path / place
            assert writer.path.read_text() == 'time\n0.000000\n'
        assert (tmp_path / name).read_text() == 'old'
    assert len(list(tmp_path.iterdir())) == 6


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
