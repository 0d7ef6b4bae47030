# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The program `simulate`, as a user starts it."""

from __future__ import annotations

import csv
from pathlib import Path
import subprocess
import sys

import numpy as np
from positioner_runs import PAPER_CURRENT, positioner, rows
import pytest

from booster_ros.model.parameters import from_values
from booster_ros.model.simulation import simulate
from booster_ros.programs import input_rows, simulate as program
from booster_ros.programs.interruption import kept_interruption
from booster_ros.run_error import RunError

ROOT = Path(__file__).resolve().parent.parent
COLUMNS = [
    'time', 'control_current', 'back_pressure', 'supply_pressure', 'mass_flow',
    'chamber_pressure', 'valve_position',
]
PARAMETERS = """
/**:
  ros__parameters:
    supply:
      pressure: 390000
    sensors:
      position_bias: 0.001
"""


@pytest.fixture
def params(tmp_path: Path) -> Path:
    path = tmp_path / 'params.yaml'
    path.write_text(PARAMETERS)
    return path


def write(path: Path, text: str) -> Path:
    path.write_text(text)
    return path


def start(params: Path, source: Path, out: Path, code: str = '') -> subprocess.CompletedProcess:
    """Run the program in a process of its own, after `code`."""
    script = f'{code}\nimport sys\nfrom booster_ros.programs.simulate import main\nsys.exit(main())'
    arguments = ['--params', str(params), '--input', str(source), '--out', str(out)]
    return subprocess.run(
        [sys.executable, '-c', script, *arguments],
        cwd=ROOT, capture_output=True, text=True, check=False,
    )


def read(path: Path) -> dict[str, np.ndarray]:
    with path.open() as file:
        header, *lines = csv.reader(file)
    return dict(zip(header, np.array(lines, dtype=float).T, strict=True))


def test_a_table_of_currents_becomes_what_a_record_would_hold(tmp_path, params):
    time = rows(8.0)
    current = np.where(time < 1.0, 0.0, PAPER_CURRENT)
    lines = [f'{t:.2f},{i!r}' for t, i in zip(time.tolist(), current.tolist(), strict=True)]
    source = write(tmp_path / 'in.csv', 'time,control_current\n' + '\n'.join(lines))
    out = tmp_path / 'out.csv'
    # the program needs no ROS: here it could not have it
    done = start(params, source, out, "import sys; sys.modules['rclpy'] = None")
    assert (done.returncode, done.stdout) == (0, '')
    result = read(out)
    assert list(result) == COLUMNS
    expected = simulate(
        positioner({'supply.pressure': 390e3, 'sensors.position_bias': 1e-3}), time, current)
    for column, name in program.OUTPUT.items():
        scale = np.abs(expected[name]).max()
        assert np.abs(result[column] - expected[name]).max() < 1e-6 * scale, column
    assert result['valve_position'][0] == pytest.approx(0.001, abs=30e-6)
    assert [entry.name for entry in tmp_path.iterdir() if 'partial' in entry.name] == []


def run_here(tmp_path: Path, params: Path, text: str) -> dict[str, np.ndarray]:
    source, out = write(tmp_path / 'in.csv', text), tmp_path / 'out.csv'
    status = program.main(['--params', str(params), '--input', str(source), '--out', str(out)])
    assert status == 0
    return read(out)


def test_starts_where_the_first_row_says(tmp_path, params):
    result = run_here(
        tmp_path, params,
        'chamber_pressure,time,valve_position,control_current\n'
        '200000,5.0,0.006,0.0004\n,5.1,,0.0004\n',
    )
    assert result['time'].tolist() == [5.0, 5.1]
    assert result['chamber_pressure'][0] == 200e3
    assert result['valve_position'][0] == 0.006  # read so: the stem is at 5 mm, the bias is 1 mm
    assert result['chamber_pressure'][1] != 200e3


def test_of_pressure_and_position_the_first_row_alone_is_read(tmp_path, params):
    head = 'time,control_current,chamber_pressure,valve_position\n0,0.0004,200000,0.006\n'
    clean, odd = (run_here(tmp_path, params, head + row) for row in (
        '1,0.0004,200000,0.006\n', '1,0.0004,inf,37 %\n'))
    for name, column in clean.items():
        assert np.array_equal(odd[name], column), name


def test_a_column_of_nearly_a_known_name_is_asked_for(tmp_path, params, capfd):
    """The run starts vented without that pressure, which nothing else would tell."""
    run_here(tmp_path, params, 'time,control_current,chamber_presure\n0,0.0004,2e5\n')
    assert (f'{tmp_path / "in.csv"}: row 1, column chamber_presure: not a column of a record, '
            'ignored (is it chamber_pressure?)') in capfd.readouterr().err.splitlines()


def test_an_empty_current_keeps_the_one_before(tmp_path, params):
    result = run_here(
        tmp_path, params, 'time,control_current\n0,0.0004\n0.5,\n1.0,\n1.0,0.0003\n2.0,\n')
    assert result['control_current'].tolist() == [4e-4, 4e-4, 4e-4, 3e-4, 3e-4]


def test_what_goes_by_time_begins_with_the_first_row(tmp_path):
    params = write(tmp_path / 'swings.yaml', """positioner:
  ros__parameters:
    supply:
      ripple: 20000.0
      ripple_frequency: 0.1
    ep_converter:
      drift: 5000.0
""")

    def at(begin: float) -> dict[str, np.ndarray]:
        return run_here(tmp_path, params, 'time,control_current\n' + ''.join(
            f'{begin + 0.25 * row!r},0.00044\n' for row in range(80)))

    early, late = at(0.0), at(1.8e9)
    assert np.ptp(early['supply_pressure']) == pytest.approx(40e3, rel=0.05)
    assert late.pop('time').tolist() == (1.8e9 + early.pop('time')).tolist()
    for name, column in early.items():
        assert np.array_equal(late[name], column), name


def check_portions(folder, params, text, monkeypatch):
    """Check that an input read in portions gives the same as one read at once."""
    whole = run_here(folder, params, text)
    original = input_rows.iterate_csv
    monkeypatch.setattr(
        input_rows, 'iterate_csv', lambda path, columns: original(path, columns, rows_per_chunk=97))
    portions = run_here(folder, params, text)
    for name, column in whole.items():
        assert np.array_equal(portions[name], column), name


def test_a_long_file_in_portions_is_the_same_as_at_once(tmp_path, params, monkeypatch):
    time = rows(20.0)
    text = 'time,control_current\n' + ''.join(
        f'{t:.2f},{0.43e-3 + 0.02e-3 * np.sin(t):.9f}\n' for t in time)
    check_portions(tmp_path, params, text, monkeypatch)


def test_portions_are_the_same_as_the_whole_with_a_dead_time_as_well(tmp_path, monkeypatch):
    """Currents that stand and jump, rows that are even or far apart, a long time before."""
    params = write(tmp_path / 'late.yaml', """/**:
  ros__parameters:
    ep_converter:
      dead_time: 0.137
""")
    random = np.random.default_rng(3)
    time = 1.7e9 + np.cumsum(random.choice([0.01, 0.013, 0.3], 1500))
    current = np.repeat(random.uniform(3e-4, 5e-4, 500), 3)
    text = 'time,control_current\n' + ''.join(
        f'{t:.6f},{i!r}\n' for t, i in zip(time.tolist(), current.tolist(), strict=True))
    check_portions(tmp_path, params, text, monkeypatch)


GOOD = 'time,control_current\n0,0.0004\n1,0.0004\n'


@pytest.mark.parametrize(
    ('text', 'complaint'),
    [
        ('time,current_command_x\n0,1\n', 'control_current'),
        ('control_current\n0.0004\n', 'no column time'),
        ('', 'in.csv'),
        ('time,control_current\n', 'no rows'),
        ('time,control_current\n0,0.0004\n1,abc\n', 'row 3'),
        ('time,control_current\n0,0.0004\n1,inf\n', 'row 3'),
        ('time,control_current\n0,\n1,0.0004\n', 'row 2, column control_current'),
        ('time,control_current,chamber_pressure\n0,0.0004,\n1,0.0004,2e5\n',
         'row 2, column chamber_pressure'),
        ('time,control_current,valve_position\n0,0.0004,6.0\n1,0.0004,6.0\n',
         'row 2, column valve_position'),
        ('time,control_current\n1,0.0004\n0,0.0004\n', 'row 3, column time'),
        ('time,control_current\n0,0.0004\n,0.0004\n', 'row 3, column time'),
        ('time,control_current\n0,0.0004\n1e7,0.0004\n', 'row 3, column time: 1e+07 s after'),
        ('time,control_current\n0,0.45\n1,0.45\n', 'mA'),
    ],
)
def test_bad_input_is_one_sentence_and_status_2(tmp_path, params, capfd, text, complaint):
    source, out = write(tmp_path / 'in.csv', text), write(tmp_path / 'out.csv', 'as it was')
    status = program.main(['--params', str(params), '--input', str(source), '--out', str(out)])
    printed = capfd.readouterr()
    message = [line for line in printed.err.splitlines() if 'compiling' not in line]
    assert status == 2
    assert len(message) == 1
    assert message[0].startswith('simulate: ')
    assert complaint in message[0]
    assert 'in.csv' in message[0]
    assert out.read_text() == 'as it was'
    assert sorted(entry.name for entry in tmp_path.iterdir()) == [
        'in.csv', 'out.csv', 'params.yaml']


@pytest.mark.parametrize(
    ('text', 'complaint'),
    [
        ('/**:\n  ros__parameters:\n    supply:\n      presure: 4e5\n', 'supply.pressure'),
        ('/**:\n  ros__parameters:\n    booster:\n      s1: -1.0\n', 'booster.s1'),
        ('/**:\n  ros__parameters:\n    booster:\n      s1: 1.0e-06\n', 'booster.s1'),
        ('}{', 'params.yaml'),
    ],
)
def test_bad_parameters_are_one_sentence_and_status_2(tmp_path, params, capfd, text, complaint):
    source = write(tmp_path / 'in.csv', GOOD)
    write(params, text)
    status = program.main(
        ['--params', str(params), '--input', str(source), '--out', str(tmp_path / 'out.csv')])
    message = capfd.readouterr().err.splitlines()
    assert status == 2
    assert len(message) == 1
    assert complaint in message[0]
    assert 'params.yaml' in message[0]


def test_a_model_without_solution_ends_a_run_and_is_no_bad_parameter(tmp_path):
    source = write(tmp_path / 'in.csv', 'time,control_current\n0,0.0006\n1,0.0006\n')
    p = from_values({'actuator.dead_volume': 1e-9})
    with kept_interruption() as check, pytest.raises(RunError, match='no solution'):
        program.run(p, input_rows.CsvRows(source, 'control_current'), tmp_path / 'out.csv', check)


@pytest.mark.parametrize('portion', [1, 100])
def test_a_model_without_solution_is_one_sentence_and_status_2(
        tmp_path, params, capfd, monkeypatch, portion):
    """A chamber of less than the end stop yields: the stem would press it to nothing."""
    source = write(tmp_path / 'in.csv', 'time,control_current\n' + ''.join(
        f'{5.0 + 0.01 * k:.2f},0.0006\n' for k in range(60)))
    write(params, '/**:\n  ros__parameters:\n    actuator:\n      dead_volume: 1.0e-9\n')
    out = write(tmp_path / 'out.csv', 'as it was')
    original = input_rows.iterate_csv
    monkeypatch.setattr(input_rows, 'iterate_csv', lambda path, columns: original(
        path, columns, rows_per_chunk=portion))
    status = program.main(['--params', str(params), '--input', str(source), '--out', str(out)])
    message = [line for line in capfd.readouterr().err.splitlines() if 'compiling' not in line]
    assert status == 2
    assert message == [
        'simulate: with these parameters the model has no solution from 5.01 s on']
    assert out.read_text() == 'as it was'
    assert sorted(entry.name for entry in tmp_path.iterdir()) == [
        'in.csv', 'out.csv', 'params.yaml']


@pytest.mark.parametrize('missing', ['params', 'input', 'out'])
def test_files_that_are_not_there(tmp_path, params, capfd, missing):
    paths = {'params': params, 'input': write(tmp_path / 'in.csv', GOOD),
             'out': tmp_path / 'out.csv'}
    paths[missing] = tmp_path / 'no' / 'such' / 'file'
    status = program.main([f'--{name}={path}' for name, path in paths.items()])
    message = [line for line in capfd.readouterr().err.splitlines() if 'compiling' not in line]
    assert status == 2
    assert len(message) == 1
    assert str(paths[missing]) in message[0]


INTERRUPTED_AT = """
import os, signal, weakref
from booster_ros.programs import input_rows, simulate as program
signal.signal(signal.SIGHUP, signal.SIG_DFL)  # whatever runs the tests may ignore it

class Held:
    pass

def lost():
    held = Held()
    watch = weakref.ref(held, lambda _: os.kill(os.getpid(), signal.SIGTERM))
    del held

begin, move = program.start_of_run, os.replace
def begin_and(stop):
    def interrupted(*given):
        stop()
        return begin(*given)
    program.start_of_run = interrupted
def move_and(stop):
    def interrupted(*paths):
        move(*paths)
        stop()
    os.replace = interrupted
"""


def interrupted_at(tmp_path: Path, params: Path, where: str) -> subprocess.CompletedProcess:
    """Run the program, interrupted in this line of Python; what was at --out is `as it was`."""
    source, out = write(tmp_path / 'in.csv', GOOD), write(tmp_path / 'out.csv', 'as it was')
    done = start(params, source, out, INTERRUPTED_AT + where)
    assert sorted(entry.name for entry in tmp_path.iterdir()) == [
        'in.csv', 'out.csv', 'params.yaml']
    return done


@pytest.mark.parametrize('stop', [
    'lambda: os.kill(os.getpid(), signal.SIGINT)',
    'lambda: os.kill(os.getpid(), signal.SIGTERM)',
    'lambda: os.kill(os.getpid(), signal.SIGHUP)',
    'lost',  # where Python drops it
])
def test_an_interruption_leaves_the_file_as_it_was(tmp_path, params, stop):
    done = interrupted_at(tmp_path, params, f'begin_and({stop})')
    assert done.returncode == 130
    assert done.stderr.endswith('simulate: interrupted, nothing was written\n')
    assert (tmp_path / 'out.csv').read_text() == 'as it was'


def test_an_interruption_of_the_last_move_is_too_late(tmp_path, params):
    done = interrupted_at(
        tmp_path, params, 'move_and(lambda: os.kill(os.getpid(), signal.SIGTERM))')
    assert done.returncode == 0, done.stderr
    assert list(read(tmp_path / 'out.csv')) == COLUMNS


@pytest.mark.parametrize('read', ['in.csv', 'params.yaml'])
def test_a_file_that_is_read_is_not_overwritten(tmp_path, params, capfd, monkeypatch, read):
    source = write(tmp_path / 'in.csv', GOOD)
    before = (tmp_path / read).read_text()
    (tmp_path / 'link').symlink_to(read)
    monkeypatch.chdir(tmp_path)
    for out in (read, 'link', f'../{tmp_path.name}/{read}'):
        status = program.main(['--params', str(params), '--input', str(source), '--out', out])
        assert status == 2
        assert capfd.readouterr().err == (
            f'simulate: {tmp_path / read}: is read, and would be overwritten; '
            'choose another --out\n')
    assert (tmp_path / read).read_text() == before


def test_wrong_arguments_end_with_status_2(capsys):
    with pytest.raises(SystemExit) as end:
        program.main(['--params', 'p.yaml'])
    assert end.value.code == 2
    assert '--input' in capsys.readouterr().err
