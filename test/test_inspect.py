# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The program `inspect`, and the options of other programs that use what it writes."""

import re

from made_foreign import lines, rows, write
from made_report import Page
import numpy as np
import pytest

from booster_ros.programs import close_loop, inspect, simulate
from booster_ros.programs.mapping_options import HINT, column_in_short
from booster_ros.records import read_record

PARAMETERS = '/**:\n  ros__parameters:\n    actuator:\n      travel: 0.02\n'
EXPORT = ['Exported by Historian', 'Stamp;P act (kPa);Travel [%];AO [mA]', *(
    f'{k};{20 + 2 * (k % 10)};{2.5 * (k % 10)};{4 + 0.4 * (k % 10)}'.replace('.', ',')
    for k in range(40))]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Return the current folder, with an export in it."""
    monkeypatch.chdir(tmp_path)
    write(tmp_path, EXPORT)
    return tmp_path


def test_it_says_what_a_file_holds_writes_a_mapping_and_reads_with_it(folder, capsys):
    assert inspect.main(['export.csv']) == 0
    text = capsys.readouterr().out
    assert 'columns separated by semicolons' in text
    assert re.search(r'P act \(kPa\) +20 +20 +38 +0 +chamber_pressure, kPa', text)
    assert re.search(r'Travel \[%\] .* valve_position, %', text)
    assert 'time: the unit of the time is not said' in text
    mapping = folder / 'export.map.yaml'
    written = mapping.read_text()
    assert inspect.main(['export.csv']) == 2  # it is there: it is read, and asks
    assert 'is in per cent of the travel, which is not known' in capsys.readouterr().err
    assert mapping.read_text() == written
    mapping.write_text(written.replace('unit: "?"', 'unit: s') + 'travel: 20 mm\n')
    assert inspect.main(['export.csv', '--csv', 'record.csv', '--plot', 'look.html']) == 0
    text = capsys.readouterr().out
    assert 'chamber_pressure: 20000 at first, 20000 to 38000 Pa gauge, 0 missing' in text
    assert 'close_loop --record export.csv --map export.map.yaml' in text
    record = read_record(folder / 'record.csv')
    np.testing.assert_allclose(record['chamber_pressure'], [row[2] for row in rows()])
    np.testing.assert_allclose(record['valve_position'], [row[3] for row in rows()], atol=1e-9)
    page = Page((folder / 'look.html').read_text())
    assert [one['name'].split(',')[0] for one in page.plots['look']['data']] == [
        'control_current', 'chamber_pressure', 'valve_position']
    assert page.references == []


def test_a_plot_of_a_file_that_is_not_mapped_yet(folder):
    assert inspect.main(['export.csv', '--map', 'm.yaml', '--plot', 'look.html']) == 0
    assert 'P act (kPa)' in (folder / 'look.html').read_text()


def test_it_overwrites_no_file_that_it_reads(folder, capsys):
    assert inspect.main(['export.csv', '--map', 'export.csv']) == 2
    assert inspect.main(['export.csv', '--csv', 'export.csv']) == 2
    assert 'would be overwritten' in capsys.readouterr().err
    assert (folder / 'export.csv').read_text().startswith('Exported by')


@pytest.mark.parametrize('file', ['/dev/zero', 'none.csv', 'empty.csv'])
def test_what_cannot_be_looked_at_is_one_sentence(folder, capsys, file):
    write(folder, b'', 'empty.csv')
    assert inspect.main([file]) == 2
    message = capsys.readouterr().err
    assert len(message.splitlines()) == 1
    assert not list(folder.glob('*.map.yaml'))


def started(program, folder, *arguments) -> list[str]:
    """Return the arguments of a program that reads a record, with a parameter file."""
    write(folder, PARAMETERS, 'p.yaml')
    option = '--record' if program is close_loop else '--input'
    return [option, *arguments, '--params', 'p.yaml', '--out', 'out']


@pytest.mark.parametrize('program', [close_loop, simulate])
def test_every_refusal_of_a_record_ends_in_the_line_that_helps(folder, capsys, program):
    bad = lines()
    bad[5] = '4,x,28000,0.002'
    files = {
        'export.csv': EXPORT, 'cell.csv': bad, 'back.csv': [*lines(), *lines()[1:]],
        'milli.csv': [*lines()[:2], '1,4.4,22000,0.0005'], 'none.csv': ['time,a', '0,1'],
        'empty.csv': ['time,control_current,chamber_pressure']}
    for name, text in files.items():
        write(folder, text, name)
        assert program.main(started(program, folder, name)) == 2
        message = [one for one in capsys.readouterr().err.splitlines() if f'{name}: row' not in one]
        assert message[-1].endswith(f'; {HINT} {name}'), message
    assert program.main(started(program, folder, 'not_there.csv')) == 2
    assert HINT not in capsys.readouterr().err


def test_records_that_the_model_cannot_be_compared_with_are_pointed_to_inspect_too(folder, capsys):
    write(folder, ['time,control_current', '0,0.004', '1,0.004'], 'alone.csv')
    assert close_loop.main(started(close_loop, folder, 'alone.csv')) == 2
    assert capsys.readouterr().err.endswith(f'; {HINT} alone.csv\n')


def test_simulate_reads_a_mapped_file_as_it_reads_the_same_in_si(folder, capsys):
    text = ['t_ms;AO [mA]', *(f'{10 * k};{0.40 + 0.001 * k:.3f}'.replace('.', ',')
                             for k in range(200))]
    write(folder, text, 'ao.csv')
    plain = ['time,control_current', *(f'{k / 100},{0.40e-3 + 1e-6 * k:.6f}' for k in range(200))]
    write(folder, plain, 'plain.csv')
    short = [*started(simulate, folder, 'ao.csv'), '--column', 'control_current=AO [mA]']
    assert simulate.main(short) == 0
    assert 'converted from mA to A' in capsys.readouterr().err
    mapped = (folder / 'out').read_text()
    assert simulate.main(started(simulate, folder, 'plain.csv')) == 0
    assert (folder / 'out').read_text() == mapped
    write(folder, 'time: t_ms\ncolumns: {control_current: "AO [mA]"}', 'm.yaml')
    assert simulate.main([*started(simulate, folder, 'ao.csv'), '--map', 'm.yaml']) == 0
    assert (folder / 'out').read_text() == mapped


@pytest.mark.parametrize('text', ['valve_position', 'valve_position=', 'valve=Travel', '=x'])
def test_a_column_in_short_needs_both_names(text):
    with pytest.raises(Exception, match='is not NAME=FROM'):
        column_in_short(text)
