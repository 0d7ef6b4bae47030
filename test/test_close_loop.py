# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""`close_loop`: what it writes, what it refuses, and what an interruption leaves."""

from contextlib import redirect_stderr, redirect_stdout
import errno
import io
import json
import os
from pathlib import Path
import signal
import subprocess
import sys
import threading
import weakref

from made_diagnosis import nothing_found, swept_columns, timed_columns
import numpy as np
import pytest

from booster_ros.model.parameters import from_values
from booster_ros.model.simulation import simulate
from booster_ros.model.system import PositionerParameters
from booster_ros.parameters.file import read_parameter_file, write_parameter_file
from booster_ros.programs import close_loop as program
from booster_ros.programs.interruption import ignore_interruptions, kept_interruption
from booster_ros.programs.progress_bar import ProgressBar
from booster_ros.records import CsvWriter, RecordError
from booster_ros.report import html_report

COMMAND = (sys.executable, '-m', 'booster_ros', 'close_loop')
INTERRUPTED_AS_A_THREAD_STARTS = """
import sys
from threading import Event, Thread

from booster_ros.programs.close_loop import main


def interrupt(frame, event, _):
    if frame.f_code is Event.wait.__code__ and frame.f_back.f_code is Thread.start.__code__:
        raise KeyboardInterrupt


sys.setprofile(interrupt)
sys.exit(main(sys.argv[1:]))
"""
WRITTEN = {'report.html', 'report.json', 'positioner.yaml', 'positioner_before.yaml'}


def close_loop(*arguments):
    """Run the program in this process; return its status and what it said as of a process."""
    said, complained = io.StringIO(), io.StringIO()
    command = list(map(str, arguments))
    with redirect_stdout(said), redirect_stderr(complained):
        try:
            status = program.main(command)
        except SystemExit as end:
            status = end.code
    return subprocess.CompletedProcess(command, status, said.getvalue(), complained.getvalue())


def close_loop_process(*arguments):
    return subprocess.run(
        [*COMMAND, *map(str, arguments)], capture_output=True, text=True, check=False)


def write(path, columns):
    with CsvWriter(path, tuple(columns)) as writer:
        writer.write_rows(np.column_stack(list(columns.values())))
    return path


@pytest.fixture
def declared(tmp_path):
    """Return a parameter file."""
    write_parameter_file(tmp_path / 'declared.yaml', PositionerParameters())
    return tmp_path / 'declared.yaml'


@pytest.fixture
def record(tmp_path):
    """Return a record of a valve that is as declared."""
    return write(tmp_path / 'record.csv', timed_columns())


def assert_refused(done, *words):
    """Assert that one clear sentence was said, beside that the model is being compiled."""
    assert done.returncode == 2
    assert done.stdout == ''
    assert len([line for line in done.stderr.splitlines() if 'compiling' not in line]) == 1
    for word in words:
        assert word in done.stderr


def test_a_leaking_chamber_is_told_and_the_written_model_leaks(tmp_path):
    closed = PositionerParameters()
    closed = closed._replace(booster=closed.booster._replace(opening_gain=0.0))
    leaking = closed._replace(actuator=closed.actuator._replace(leak_area=4e-8))
    clock = 0.1 * np.arange(300)
    run = simulate(leaking, clock, np.zeros(300), {'chamber_pressure': 140e3})
    noise = 100.0 * np.random.default_rng(5).standard_normal((2, 300))
    record, again = (write(tmp_path / name, {
        'time': clock, 'chamber_pressure': run['chamber_pressure'] + one})
        for name, one in zip((os.fsdecode(b'Pr\xfcfung\n\x1b.csv'), 'again.csv'), noise))
    node = {'publish_rate': 50.0, 'current_limits': (0.0, 0.022)}
    write_parameter_file(tmp_path / 'closed.yaml', closed, node=node)
    out = tmp_path / 'made' / 'here'
    done = close_loop_process('--record', record, '--params', tmp_path / 'closed.yaml',
                              '--out', out, '--validation', again,
                              '--only', 'chamber_leak', 'exhaust_seat_leak', 'pressure_sensor_bias')
    assert done.returncode == 0, done.stderr
    assert {path.name for path in out.iterdir()} == WRITTEN
    report = json.loads((out / 'report.json').read_text())
    assert report['verdict'] == 'effect'
    assert report['effects'][0]['location'] == 'chamber'
    assert report['validation']['chamber_pressure']['after'] < 1.3 * 100.0
    assert report['record']['file'] == str(
        tmp_path / 'Pr\ufffdfung\\n\\x1b.csv')  # no UTF-8, a line feed, a control character
    assert str(out / 'report.html') in done.stdout
    written = read_parameter_file(out / 'positioner.yaml')
    assert written.node == node
    model = from_values(written.physical)
    decay = simulate(model, clock, np.zeros(300), {'chamber_pressure': 140e3})
    misses = decay['chamber_pressure'] - run['chamber_pressure']
    assert np.sqrt(np.mean(misses**2)) < 100.0


def test_bad_input_is_refused_in_one_sentence_and_nothing_is_written(
        tmp_path, declared, record):
    out = tmp_path / 'out'
    good = ('--record', record, '--params', declared, '--out', out)
    absent = tmp_path / 'absent.csv'
    assert_refused(close_loop(*good, '--record', absent), 'absent.csv')
    assert_refused(close_loop(*good, '--validation', absent), 'absent.csv')
    assert_refused(close_loop(*good, '--params', tmp_path / 'absent.yaml'), 'absent.yaml')
    assert_refused(close_loop(*good, '--params', 'a\n\x1b[2J'), r'a\n\x1b[2J')
    alone = write(tmp_path / 'alone.csv', {
        'time': np.arange(40.0), 'control_current': np.full(40, 0.4e-3)})
    assert_refused(close_loop(*good, '--record', alone), 'alone.csv', 'nothing can be compared')
    declared.write_text('/**:\n  ros__parameters:\n    actuator:\n      travell: 0.016\n')
    assert_refused(close_loop(*good), 'declared.yaml', 'actuator.travell')
    assert not out.exists()


def test_an_output_that_is_a_file_is_refused_and_kept(tmp_path, declared, record):
    out = tmp_path / 'out'
    out.write_text('mine')
    assert_refused(close_loop('--record', record, '--params', declared, '--out', out), str(out))
    assert out.read_text() == 'mine'
    assert_refused(close_loop('--record', record, '--params', declared, '--out', out / 'inside'),
                   str(out), 'is not a folder')
    nowhere = tmp_path / 'nowhere'
    nowhere.symlink_to(tmp_path / 'gone')
    assert_refused(close_loop('--record', record, '--params', declared, '--out', nowhere),
                   str(nowhere), 'is a link to what is not there')


def test_a_result_that_would_replace_an_input_or_a_folder_is_refused_before_it_is_sought(
        tmp_path, declared, record):
    given = declared.rename(tmp_path / 'positioner.yaml')
    before = given.read_text()
    run = ('--record', record, '--params', given)
    assert_refused(close_loop(*run, '--out', tmp_path), str(given), 'would be overwritten')
    assert given.read_text() == before
    (tmp_path / 'out' / 'report.json').mkdir(parents=True)
    assert_refused(close_loop(*run, '--out', tmp_path / 'out'), 'report.json', 'is a folder')
    assert_refused(close_loop(*run, '--out', tmp_path / 'new', '--validation', record),
                   str(record), 'is the record itself')
    copy = tmp_path / 'copy.csv'
    copy.write_bytes(record.read_bytes())
    assert_refused(close_loop(*run, '--out', tmp_path / 'new', '--validation', copy),
                   str(copy), 'has the rows of the record itself')
    assert not (tmp_path / 'new').exists()


def test_a_folder_that_cannot_be_written_is_named_as_it_was_given(
        tmp_path, declared, record, monkeypatch, capsys):
    def refuse(path):
        raise PermissionError(errno.EACCES, 'Permission denied', str(path))

    monkeypatch.setattr(Path, 'mkdir', refuse)
    out = tmp_path / 'out'
    asked = ['--record', str(record), '--params', str(declared), '--out', str(out)]
    assert program.main(asked) == 2
    assert capsys.readouterr().err == f'close_loop: {out}: Permission denied\n'


def test_declared_pressures_in_kpa_are_refused(tmp_path, declared, record):
    for line, name in (('supply: {pressure: 400.0}', 'supply.pressure'),
                       ('actuator: {bench_set: [150.0, 300.0]}', 'actuator.bench_set')):
        declared.write_text(f'/**:\n  ros__parameters:\n    {line}\n')
        assert_refused(
            close_loop('--record', record, '--params', declared, '--out', tmp_path / 'out'),
            f'{declared}, {name}: ', '00 Pa looks like kPa')


@pytest.mark.parametrize('arguments', [
    ('--topics', 'control_current'), ('--dwell', '-1'), ('--dwell', 'soon'), ('--stamps', 'mine')])
def test_bad_arguments_are_refused(tmp_path, declared, record, arguments):
    done = close_loop('--record', record, '--params', declared, '--out', tmp_path / 'out',
                      *arguments)
    assert done.returncode == 2
    assert arguments[-1] in done.stderr
    assert 'Traceback' not in done.stderr


@pytest.mark.parametrize('arguments', [
    ('--topics', 'chamber_pressure=/p'), ('--stamps', 'header'), ('--dwell', '2')])
def test_an_option_that_would_do_nothing_is_refused(
        tmp_path, declared, record, capsys, arguments):
    out = tmp_path / 'out'
    other = write(tmp_path / 'other.csv', timed_columns())
    run = ['--record', record, '--params', declared, '--out', out, *arguments]
    purpose = 'a sweep without time' if '--dwell' in arguments else 'a bag'
    option = '--stamps header' if '--stamps' in arguments else arguments[0]
    for more, which in (
        ([], f'{record} is'), (['--validation', other], f'{record} and {other} are'),
    ):
        assert program.main(list(map(str, [*run, *more]))) == 2
        assert capsys.readouterr().err == (
            f'close_loop: {option} is for {purpose}, and {which} none\n')
    assert not out.exists()


@pytest.fixture
def no_search(monkeypatch):
    """End a run where its search would begin."""
    def stopped(*_, **__):
        raise RecordError('as far as here')

    monkeypatch.setattr(program, 'diagnose', stopped)


@pytest.fixture
def found_at_once(monkeypatch):
    """Let a run find nothing, as it would in the record of a valve that is as declared."""
    monkeypatch.setattr(program, 'diagnose', lambda *_, **__: nothing_found())
    monkeypatch.setattr(html_report, 'svg', lambda *_: '')  # drawing takes long


@pytest.mark.usefixtures('no_search')
def test_what_a_record_was_taken_for_is_said_before_the_search(tmp_path, declared, capsys):
    sweep = swept_columns()
    first = write(tmp_path / 'first.csv', {'counter': np.arange(60.0)} | sweep)
    sweep['valve_position'] = sweep['valve_position'][::-1]
    second = write(tmp_path / 'second.csv', sweep)
    status = program.main(['--record', str(first), '--params', str(declared), '--validation',
                           str(second), '--out', str(tmp_path / 'out')])
    assert status == 2
    *notes, end = capsys.readouterr().err.splitlines()
    assert end == f'close_loop: {first}: as far as here'
    taken = 'no time: read as a quasi-static sweep in row order, 0.25 s a row'
    assert f'{first}: row 1, column counter: not a column of a record, ignored' in notes
    assert [note for note in notes if 'sweep' in note] == [
        f'{path}: {taken}' for path in (first, second)]


@pytest.mark.usefixtures('no_search')
def test_an_option_for_one_of_two_records_is_taken(tmp_path, declared, record, capsys):
    """What is wrong is another thing: the bag is not there, the search is not made."""
    run = ['--record', record, '--params', declared, '--out', tmp_path / 'out', '--validation']
    for arguments, says in (
        ((tmp_path / 'absent.mcap', '--stamps', 'header'), 'absent.mcap: No such file'),
        ((write(tmp_path / 'sweep.csv', swept_columns()), '--dwell', '2'), 'as far as here'),
    ):
        assert program.main(list(map(str, [*run, *arguments]))) == 2
        assert says in capsys.readouterr().err


@pytest.fixture
def hangup():
    """Let what a hangup does be set."""
    before = signal.getsignal(signal.SIGHUP)
    yield lambda handler: signal.signal(signal.SIGHUP, handler)
    signal.signal(signal.SIGHUP, before)


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_an_interruption_leaves_an_earlier_report_as_it_was(
        tmp_path, declared, record, number, monkeypatch, hangup):
    """It comes amid the search, when that first tells how far it is."""
    hangup(signal.SIG_DFL)  # under nohup it is ignored
    out = tmp_path / 'out'
    out.mkdir()
    (out / 'report.html').write_text('earlier')
    diagnose, there = program.diagnose, []

    def interrupted(experiment, declared, tell, **_):
        def tell_and_interrupt(*said):
            tell(*said)
            there.append(len(list(out.iterdir())))
            os.kill(os.getpid(), number)

        return diagnose(experiment, declared, tell_and_interrupt)

    monkeypatch.setattr(program, 'diagnose', interrupted)
    done = close_loop('--record', record, '--params', declared, '--out', out)
    assert there == [2]  # the temporary folder was there as well
    assert done.returncode == 130
    assert done.stdout == ''
    assert 'nothing was written' in done.stderr
    assert [path.name for path in out.iterdir()] == ['report.html']
    assert (out / 'report.html').read_text() == 'earlier'


def test_an_interruption_as_a_thread_starts_ends_the_process(tmp_path, declared, record):
    done = subprocess.run(
        [sys.executable, '-c', INTERRUPTED_AS_A_THREAD_STARTS, '--record', record,
         '--params', declared, '--out', tmp_path / 'out'],
        capture_output=True, text=True, check=False)
    assert done.returncode == 130, done.stderr
    assert 'nothing was written' in done.stderr
    assert not (tmp_path / 'out').exists()


@pytest.mark.filterwarnings('ignore::pytest.PytestUnraisableExceptionWarning')
def test_an_interruption_that_comes_where_python_drops_it_is_not_lost(
        tmp_path, declared, record, monkeypatch, capsys):
    reached = []

    class Held:
        pass

    def interrupt_in_a_callback():
        held = Held()
        watch = weakref.ref(held, lambda _: os.kill(os.getpid(), signal.SIGINT))
        del held
        reached.append(watch() is None)  # the callback is through, and nothing was raised here

    monkeypatch.setattr(program, 'announce_compilation', interrupt_in_a_callback)
    before = signal.getsignal(signal.SIGINT)
    out = tmp_path / 'out'
    status = program.main(['--record', str(record), '--params', str(declared), '--out', str(out)])
    assert reached == [True]
    assert status == 130
    assert 'nothing was written' in capsys.readouterr().err
    assert not out.exists()
    assert signal.getsignal(signal.SIGINT) is before


def test_a_hangup_that_is_ignored_stays_so(hangup):
    hangup(signal.SIG_IGN)
    try:
        with kept_interruption() as check:
            os.kill(os.getpid(), signal.SIGHUP)
            check()
            ignore_interruptions()
    except KeyboardInterrupt:
        pytest.fail('interrupted')
    assert signal.getsignal(signal.SIGHUP) == signal.SIG_IGN


def test_a_second_hangup_does_not_cut_short_what_the_first_began(hangup):
    hangup(signal.SIG_DFL)
    cleaned = []

    def hung_up_twice():
        with kept_interruption():
            try:
                os.kill(os.getpid(), signal.SIGHUP)
            finally:
                os.kill(os.getpid(), signal.SIGHUP)
                cleaned.append(True)

    with pytest.raises(KeyboardInterrupt):
        hung_up_twice()
    assert cleaned == [True]
    assert signal.getsignal(signal.SIGHUP) == signal.SIG_DFL


@pytest.mark.usefixtures('found_at_once')
def test_an_interruption_among_the_last_moves_is_too_late(
        tmp_path, declared, record, monkeypatch):
    """Of a result all files are new, or none is."""
    out = tmp_path / 'out'
    out.mkdir()
    (out / 'positioner.yaml').write_text('earlier')
    move = os.replace

    def moved_and_interrupted(source, target):
        move(source, target)
        if str(source).endswith('.json'):
            os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr(os, 'replace', moved_and_interrupted)
    status = program.main(['--record', str(record), '--params', str(declared), '--out', str(out)])
    assert status == 0
    assert {path.name for path in out.iterdir()} == WRITTEN
    assert (out / 'positioner.yaml').read_text() != 'earlier'


@pytest.mark.usefixtures('found_at_once')
def test_of_the_files_of_a_result_none_is_new_where_one_cannot_be_replaced(
        tmp_path, declared, record, monkeypatch, capsys):
    """Here somebody makes a folder in the place of one before they are moved."""
    out = tmp_path / 'out'
    out.mkdir()
    for name in WRITTEN - {'positioner_before.yaml'}:
        (out / name).write_text('earlier')
    page = html_report.html_page

    def page_and_a_folder(*given):
        (out / 'positioner_before.yaml').mkdir()
        return page(*given)

    monkeypatch.setattr(html_report, 'html_page', page_and_a_folder)
    status = program.main(['--record', str(record), '--params', str(declared), '--out', str(out)])
    assert status == 2
    assert capsys.readouterr().err.splitlines()[-1].startswith(f'close_loop: {out}')
    (out / 'positioner_before.yaml').rmdir()
    assert {path.name: path.read_text() for path in out.iterdir()} == dict.fromkeys(
        WRITTEN - {'positioner_before.yaml'}, 'earlier')


def test_where_nothing_may_be_written_no_record_is_read(tmp_path, declared, monkeypatch, capsys):
    """The search, minutes later, would find it too late."""
    def refuse(path):
        raise PermissionError(errno.EACCES, 'Permission denied', str(path))

    monkeypatch.setattr(Path, 'mkdir', refuse)
    out = tmp_path / 'out'
    asked = ['--record', 'absent.csv', '--params', str(declared), '--out', str(out)]
    assert program.main(asked) == 2
    assert capsys.readouterr().err == f'close_loop: {out}: Permission denied\n'


def test_what_a_killed_process_has_left_is_swept(tmp_path, declared, record):
    left = tmp_path / f'.{program.WORKING}.{"ab" * 8}.partial'
    left.mkdir()
    (left / 'report.json').write_text('half')
    absent = tmp_path / 'absent.csv'
    assert_refused(close_loop('--record', absent, '--params', declared, '--out', tmp_path / 'out'),
                   'absent.csv')
    assert not left.exists()


@pytest.mark.usefixtures('found_at_once')
def test_a_terminal_that_lacks_a_sign_gets_another(tmp_path, declared, record, monkeypatch):
    printed = io.BytesIO()
    monkeypatch.setattr(sys, 'stdout', io.TextIOWrapper(printed, encoding='latin-1'))
    monkeypatch.setattr(program, 'verdict_title', lambda _: '12\u202f345 Pa')
    status = program.main(
        ['--record', str(record), '--params', str(declared), '--out', str(tmp_path / 'out')])
    sys.stdout.flush()
    assert status == 0
    assert printed.getvalue().startswith(b'12?345 Pa.')


def test_a_bar_starts_no_thread_that_an_interruption_could_leave_waiting():
    before = threading.active_count()
    with ProgressBar(total=1.0, disable=None):
        assert threading.active_count() == before
