# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
`campaign run`: every case is run once, whatever happens to the others.

The program that is judged is a stand-in for another checkout: what it says of a record is written
in the record's first line.
"""

from dataclasses import replace
import json
import os
from pathlib import Path
import signal
import subprocess
import sys
import time

from dask_scheduler import scheduler
import pytest
from ros_process import PATIENCE, ROOT

from booster_ros.campaign import running
from booster_ros.campaign.results import read_results
from booster_ros.campaign.scoring import Outcome
from booster_ros.programs.campaign import main

STAND_IN = """
import json, pathlib, sys, time
name, words = sys.argv[1], dict(zip(sys.argv[2::2], sys.argv[3::2]))
with open('runs', 'a') as file:
    file.write(name + ' ' + pathlib.Path(words.get('--record', words.get('--input'))).stem + '\\n')
out = pathlib.Path(words['--out'])
if name == 'simulate':
    off = 100.0 if 'before' in words['--params'] else 0.0
    lines = open(words['--input']).read().splitlines()[1:]
    values = [line.split(',') for line in lines]
    out.write_text('time,chamber_pressure\\n' + ''.join(
        f'{t},{float(p) + off}\\n' for t, p in values))
    sys.exit(0)
said = open(words['--record']).readline().strip()
if said == 'refused':
    sys.exit('close_loop: something is wrong with it')
if said == 'slow':
    time.sleep(60.0)
for file in ('positioner.yaml', 'positioner_before.yaml', 'report.html'):
    (out / file).write_text('-')
effects = [] if said == 'none' else [{
    'name': said, 'location': 'chamber', 'confused_with': [],
    'parameters': {'actuator.leak_area': {'value': 2.0, 'low': 1.0, 'high': 3.0, 'unit': 'm^2'}}}]
(out / 'report.json').write_text('{' if said == 'broken' else json.dumps(
    {'verdict': 'effect' if effects else 'none', 'effects': effects}))
"""


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    package = tmp_path / 'checkout' / 'booster_ros'
    package.mkdir(parents=True)
    (package / '__init__.py').write_text('')
    (package / '__main__.py').write_text(STAND_IN)
    return package.parent


def written(folder: Path, **said: str) -> Path:
    """Write a set whose records tell the stand-in what to say; a leak is hidden in all but one."""
    folder.mkdir()
    key = {}
    for case, word in said.items():
        (folder / f'{case}.yaml').write_text('-')
        (folder / f'{case}_fit.csv').write_text(f'{word}\n')
        (folder / f'{case}_val.csv').write_text('time,chamber_pressure\n0,1000\n1,2000\n')
        key[case] = {'names': ['none'], 'location': 'none'} if case == 'clean' else {
            'names': ['chamber_leak'], 'location': 'chamber',
            'parameters': {'actuator.leak_area': 2.5}}
    (folder / 'key.json').write_text(json.dumps(key))
    return folder


def command(folder: Path, checkout: Path, *words: str) -> list[str]:
    return ['run', str(folder), '--out', str(folder.parent / 'out'),
            '--program', f'{sys.executable} -m booster_ros', '--cwd', str(checkout), *words]


def runs(checkout: Path) -> list[str]:
    """Return which records were diagnosed since this was asked last."""
    path = checkout / 'runs'
    lines = path.read_text().splitlines() if path.exists() else []
    path.unlink(missing_ok=True)
    return sorted(line.split()[1] for line in lines if line.startswith('close_loop'))


def test_every_case_is_scored_and_a_bad_one_stops_none(tmp_path, checkout, capsys):
    folder = written(tmp_path / 'set', bad='refused', broken='broken', clean='none',
                     leak='chamber_leak', long='slow', other='dead_time')
    assert main(command(folder, checkout, '--timeout', '3')) == 0
    assert runs(checkout) == [
        'bad_fit', 'broken_fit', 'clean_fit', 'leak_fit', 'long_fit', 'other_fit']
    found = {outcome.case: outcome for outcome in read_results(tmp_path / 'out')}
    assert {name: (o.status, o.said, o.named, o.placed) for name, o in found.items()} == {
        'bad': ('failed', 'failed', False, False), 'broken': ('failed', 'failed', False, False),
        'clean': ('answered', 'none', True, True), 'long': ('timeout', 'timeout', False, False),
        'leak': ('answered', 'chamber_leak', True, True),
        'other': ('answered', 'dead_time', False, True)}
    assert found['bad'].message == 'close_loop: something is wrong with it'
    assert found['leak'].before == {'chamber_pressure': 100.0}
    assert found['leak'].after == {'chamber_pressure': 0.0}
    assert found['leak'].intervals[0].widths == 0.25
    kept = tmp_path / 'out' / 'reports' / 'set'
    assert sorted(path.name for path in (kept / 'leak').iterdir()) == [
        'positioner.yaml', 'positioner_before.yaml', 'report.json']
    assert list((kept / 'bad').iterdir()) == []
    said = capsys.readouterr().out
    assert 'min to go' in said
    assert 'NO ANSWER: close_loop: something is wrong with it' in said
    row = '| set | 6 | 3 | 2 of 6 | 3 of 6 | 1 of 1 | 3 of 6 | 2 of 2 | – |'
    assert row in said
    assert row in (tmp_path / 'out' / 'table.md').read_text()
    assert 'NO ANSWER' not in (tmp_path / 'out' / 'page.html').read_text()


def test_what_has_been_run_is_run_again_only_where_something_changed(tmp_path, checkout, capsys):
    folder = written(tmp_path / 'set', bad='refused', clean='none', leak='chamber_leak')
    assert main(command(folder, checkout, '--case', 'clean')) == 0
    assert runs(checkout) == ['clean_fit']
    assert main(command(folder, checkout)) == 0
    assert runs(checkout) == ['bad_fit', 'leak_fit']
    assert '1 of 3 cases have been run before' in capsys.readouterr().out
    assert main(command(folder, checkout)) == 0
    assert runs(checkout) == ['bad_fit']  # it failed: that may have been the machine
    (folder / 'clean_fit.csv').write_text('dead_time\n')
    assert main(command(folder, checkout)) == 0
    assert runs(checkout) == ['bad_fit', 'clean_fit']
    (checkout / 'booster_ros' / 'more.py').write_text('')
    assert main(command(folder, checkout, '--case', 'clean', 'leak')) == 0
    assert runs(checkout) == ['clean_fit', 'leak_fit']
    assert len(read_results(tmp_path / 'out')) == 2  # what another program said of `bad` is gone


def test_what_took_too_long_is_run_again_with_more_time(tmp_path, checkout):
    folder = written(tmp_path / 'set', long='slow')
    for timeout, again in (('0.5', True), ('0.4', False), ('1', True)):
        assert main(command(folder, checkout, '--timeout', timeout)) == 0
        assert runs(checkout) == ['long_fit'] * again


def wait_for(case: str, checkout: Path) -> None:
    """Wait until a case is being diagnosed."""
    path, deadline = checkout / 'runs', time.monotonic() + 60.0
    while not path.exists() or f'close_loop {case}_fit' not in path.read_text():
        assert time.monotonic() < deadline
        time.sleep(0.05)


def interrupted(words: list[str], number: int, checkout: Path, case: str) -> str:
    """Send a signal to a campaign as it diagnoses a case; return what it says in the end."""
    process = subprocess.Popen([sys.executable, '-m', 'booster_ros', 'campaign', *words],
                               cwd=ROOT, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL,
                               text=True, start_new_session=True)
    wait_for(case, checkout)
    os.killpg(process.pid, number)  # as a terminal does: all that it started get it too
    said = process.communicate(timeout=20.0)[1]
    assert process.returncode == 130
    return said


def still_run(folder: Path) -> bytes:
    """Return the processes that have this folder among their arguments."""
    return subprocess.run(['pgrep', '-f', str(folder)], capture_output=True, check=False).stdout


def test_interrupted_it_ends_what_it_started_and_goes_on_later(tmp_path, checkout):
    folder = written(tmp_path / 'set', a='chamber_leak', b='slow', clean='none')
    words = command(folder, checkout, '--jobs', '1')
    assert interrupted(words, signal.SIGINT, checkout, 'b') == (
        'campaign: interrupted; the same command goes on from here\n')
    assert not still_run(folder)
    assert [outcome.case for outcome in read_results(tmp_path / 'out')] == ['a']
    assert '1 of 3 cases' in (tmp_path / 'out' / 'table.md').read_text()
    runs(checkout)
    (folder / 'b_fit.csv').write_text('none\n')
    assert main(words) == 0
    assert runs(checkout) == ['b_fit', 'clean_fit']


def said_of(out: Path) -> list[Outcome]:
    """Return the outcomes of a campaign by case, without the time that each took."""
    found = sorted(read_results(out), key=lambda outcome: outcome.case)
    return [replace(outcome, seconds=0.0, cpu_seconds=0.0) for outcome in found]


def test_a_worker_in_another_process_gives_the_same(tmp_path, checkout, monkeypatch):
    """It has other variables, and is told to end what it runs; one that dies stops none."""
    pytest.importorskip('distributed')
    monkeypatch.setenv('OMP_NUM_THREADS', '2')
    folder = written(tmp_path / 'set', a='chamber_leak', bad='refused', clean='none')
    assert main(command(folder, checkout)) == 0
    local = said_of(tmp_path / 'out')
    assert [outcome.message for outcome in local] == [
        '', 'close_loop: something is wrong with it', '']
    with scheduler(tmp_path, 1, OMP_NUM_THREADS='7', OPENBLAS_CORETYPE='Haswell') as address:
        there = command(folder, checkout, '--scheduler', address)
        there[there.index('--out') + 1] = str(tmp_path / 'there')
        assert main(there) == 0
        assert said_of(tmp_path / 'there') == local
        files, others = ({path.relative_to(out): path.read_bytes()
                          for path in out.glob('reports/*/*/*')}
                         for out in (tmp_path / 'out', tmp_path / 'there'))
        assert files == others
        assert len(files) == 6
        (folder / 'bad_fit.csv').write_text('slow\n')
        runs(checkout)
        assert 'goes on from here' in interrupted(there, signal.SIGTERM, checkout, 'bad')
        deadline = time.monotonic() + 10.0
        while still_run(folder):
            assert time.monotonic() < deadline
            time.sleep(0.05)
        assert [one.case for one in said_of(tmp_path / 'there')] == ['a', 'clean']


def test_a_case_whose_worker_fails_has_no_answer(tmp_path, checkout, monkeypatch):
    folder = written(tmp_path / 'set', clean='none', leak='chamber_leak')
    diagnosed = running.run_case

    def failing(case, *others):
        if case.name == 'leak':
            raise RuntimeError('lost\n it')
        return diagnosed(case, *others)

    monkeypatch.setattr(running, 'run_case', failing)
    assert main(command(folder, checkout)) == 0
    found = {one.case: (one.status, one.message) for one in read_results(tmp_path / 'out')}
    assert found == {'clean': ('answered', ''), 'leak': ('failed', 'a worker failed: lost it')}
    monkeypatch.undo()
    runs(checkout)
    assert main(command(folder, checkout)) == 0
    assert runs(checkout) == ['leak_fit']


def test_without_dask_it_is_said_what_to_install(tmp_path, checkout, monkeypatch, capsys):
    folder = written(tmp_path / 'set', clean='none', leak='chamber_leak')
    only = command(folder, checkout, '--case', 'clean')
    assert main(only) == 0
    before = (tmp_path / 'out' / 'cases.jsonl').read_text()
    monkeypatch.setitem(sys.modules, 'distributed', None)
    assert main(only) == 0  # it has been run
    capsys.readouterr()
    assert main(command(folder, checkout)) == 2
    assert capsys.readouterr().err == (
        'campaign: many runs need the Python package distributed, which is not installed: '
        'pip install distributed\n')
    assert (tmp_path / 'out' / 'cases.jsonl').read_text() == before


@pytest.mark.parametrize(('words', 'why'), [
    (['--program', 'python3'], 'is not of the form PYTHON -m booster_ros'),
    (['--program', 'no-such-python -m booster_ros'], 'no-such-python: No such file'),
    (['--cwd', 'nowhere'], 'there is no folder nowhere'),
    (['--case', 'zzz'], 'no case is called zzz'),
])
def test_what_cannot_be_run_is_said_in_a_sentence(tmp_path, checkout, capsys, words, why):
    folder = written(tmp_path / 'set', clean='none')
    assert main([*command(folder, checkout), *words]) == 2
    said = capsys.readouterr().err
    assert why in said
    assert said.count('\n') == 1
    assert not (tmp_path / 'out').exists()


def test_a_checkout_without_the_package_is_said(tmp_path, capsys):
    folder = written(tmp_path / 'set', clean='none')
    empty = tmp_path / 'empty'
    empty.mkdir()
    words = command(folder, empty)
    words[words.index('--program') + 1] = f'{sys.executable} -I -m booster_ros'
    assert main(words) == 2
    assert 'does not start in' in capsys.readouterr().err


def test_two_campaigns_are_compared(tmp_path, checkout, capsys):
    folder = written(tmp_path / 'set', clean='none', leak='chamber_leak')
    for name in ('one', 'two'):
        assert main([*command(folder, checkout), '--out', str(tmp_path / name)]) == 0
        (folder / 'leak_fit.csv').write_text('dead_time\n')
    capsys.readouterr()
    page = tmp_path / 'page.md'
    assert main(['compare', str(tmp_path / 'one'), str(tmp_path / 'two'), '--out', str(page)]) == 0
    said = capsys.readouterr().out
    assert said == page.read_text()
    assert '| name | 2 of 2 | 1 of 2 | 1 | 0 | 1 |' in said
    assert '| leak | chamber_leak | chamber_leak | dead_time | right → wrong |  |  |' in said
    assert main(['compare', str(tmp_path / 'one'), str(tmp_path)]) == 2
    assert f'{tmp_path}: there are no outcomes of a campaign' in capsys.readouterr().err


def test_a_second_run_at_the_same_time_says_nothing_of_ports():
    command = [sys.executable, '-c', (
        'from booster_ros.running import on_dask\n'
        "with on_dask._client('', 1), on_dask._client('', 1):\n    pass\n")]
    ended = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=PATIENCE)
    assert (ended.returncode, ended.stderr) == (0, '')
