# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a program finds around it: signals, streams, locale, working folder, names of files."""

import os
from pathlib import Path
import signal
import subprocess
import sys

import pytest
from ros_process import ROOT

from booster_ros.__main__ import PROGRAMS
from booster_ros.legible import legible

PYTHON = (sys.executable, '-c')
PROCESS = """
import sys, time
from booster_ros.__main__ import in_a_process_of_its_own
def run():
    {body}
    return 0
sys.exit(in_a_process_of_its_own({name!r}, run))
"""
CLEANS_UP = """
import sys, time
from booster_ros.__main__ import in_a_process_of_its_own
from booster_ros.programs.interruption import kept_interruption

def run():
    with kept_interruption():
        try:
            try:
                print('begun', flush=True)
                time.sleep(60)
            finally:
                print('cleaning', flush=True)
                time.sleep(0.5)
                print('clean', flush=True)
        except KeyboardInterrupt:
            time.sleep(0.2)
            return 130
    return 0

sys.exit(in_a_process_of_its_own('simulate', run))
"""


def process(body: str, name: str = 'simulate') -> str:
    return PROCESS.format(body=body, name=name)


def environment(**changes: str) -> dict[str, str]:
    return {**os.environ, 'PYTHONPATH': str(ROOT), **changes}


def with_default_signals() -> None:
    """Undo what whatever runs the tests may have done: under nohup, SIGHUP is ignored."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
@pytest.mark.parametrize(('name', 'status'), [('simulate', 130), ('positioner', 0)])
def test_a_signal_while_libraries_load_ends_a_program_as_later_ones_do(number, name, status):
    started = subprocess.Popen(
        [*PYTHON, process("print('begun', flush=True); time.sleep(60)", name)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment(),
        preexec_fn=with_default_signals)
    assert started.stdout is not None
    assert started.stdout.readline() == 'begun\n'
    started.send_signal(number)
    _, said = started.communicate(timeout=300)
    assert (started.returncode, said) == (status, f'{name}: interrupted\n')


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_second_signal_does_not_cut_short_what_the_first_began(number):
    started = subprocess.Popen(
        [*PYTHON, CLEANS_UP], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env=environment(), preexec_fn=with_default_signals)
    assert started.stdout is not None
    assert started.stdout.readline() == 'begun\n'
    started.send_signal(signal.SIGINT)
    assert started.stdout.readline() == 'cleaning\n'
    started.send_signal(number)
    assert started.stdout.readline() == 'clean\n'
    started.send_signal(number)
    rest = started.communicate(timeout=300)
    assert (started.returncode, *rest) == (130, '', '')


@pytest.mark.parametrize('name', PROGRAMS)
def test_a_deleted_working_folder_is_said(tmp_path: Path, name: str):
    gone = tmp_path / 'gone'
    gone.mkdir()
    # the interpreter itself starts there only with its path isolated from the folder
    script = f'import os; os.chdir({str(gone)!r}); os.rmdir({str(gone)!r})\n' + process(
        'from booster_ros.__main__ import start; start(sys.argv[1])', name)
    done = subprocess.run([*PYTHON, script, name], capture_output=True, text=True,
                          env=environment(), timeout=300, check=False)
    assert done.returncode == 2
    assert done.stderr == f'{name}: the working folder has been deleted, change to another one\n'


@pytest.mark.parametrize('encoding', ['ascii', 'latin-1', 'utf-8'])
def test_a_sign_that_a_stream_lacks_becomes_a_question_mark(encoding: str):
    body = "print('k, m²/N → 1 kPa'); print('−1', file=sys.stderr)"
    done = subprocess.run([*PYTHON, process(body)], capture_output=True,
                          env=environment(PYTHONIOENCODING=encoding), timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout == 'k, m²/N → 1 kPa\n'.encode(encoding, 'replace')
    assert done.stderr == '−1\n'.encode(encoding, 'replace')


PRINTED = "print('x' * 100_000); print('still here', file=sys.stderr)"


@pytest.mark.parametrize(('redirected', 'status', 'said'), [
    ('>/dev/full', 2, 'still here\nsimulate: what it prints cannot be written: No space left on '
     'device\n'),
    ('>&-', 0, 'still here\n'),
    ('2>&- >/dev/null', 0, ''),
    ('2>/dev/full >/dev/null', 0, ''),
    ('<&- >&- 2>&-', 0, ''),
    ('| true; exit ${PIPESTATUS[0]}', 0, 'still here\n'),
])
def test_output_that_cannot_be_written_ends_no_program(redirected, status, said):
    command = f'"$0" -c "$1" {redirected}'
    done = subprocess.run(
        ['bash', '-c', command, sys.executable, process(PRINTED)], capture_output=True, text=True,
        env=environment(), timeout=300, check=False)
    assert (done.returncode, done.stderr) == (status, said)


def test_a_file_that_is_opened_does_not_become_a_closed_stream(tmp_path: Path):
    """Else what is printed later would be written into it."""
    path = tmp_path / 'record.csv'
    body = f"file = open({str(path)!r}, 'w'); print('printed'); file.write('written')"
    subprocess.run(['bash', '-c', '"$0" -c "$1" >&- 2>&-', sys.executable, process(body)],
                   env=environment(), timeout=300, check=True)
    assert path.read_text() == 'written'


@pytest.mark.parametrize('name', ['close_loop', 'paper'])
def test_a_choice_of_windows_for_figures_does_not_matter(name: str):
    done = subprocess.run(
        [sys.executable, '-m', 'booster_ros', name, '--help'], capture_output=True, text=True,
        cwd=ROOT, env=environment(MPLBACKEND='nonesuch'), timeout=300, check=False)
    assert (done.returncode, done.stderr) == (0, '')


def test_names_are_shown_on_one_line_and_obeyed_by_no_terminal():
    assert legible('a\nb\x1b[2J\x07\u202e\u2028') == r'a\nb\x1b[2J\x07\u202e\u2028'
    assert legible(Path('Prüfung 7 µm.csv')) == 'Prüfung 7 µm.csv'
    assert legible(os.fsdecode(b'Pr\xfcfung')) == 'Pr\ufffdfung'
    assert legible('\ud800') == r'\ud800'


@pytest.mark.parametrize('arguments', [
    ('simulate', '--params', 'a\n\x1b[2J', '--input', 'i', '--out', 'o'),
    ('close_loop', '--record', 'r', '--params', 'a\n\x1b[2J', '--out', 'o'),
    ('\x1b[2J\n',),
])
def test_a_sentence_stays_one_whatever_a_file_is_called(arguments: tuple[str, ...]):
    done = subprocess.run([sys.executable, '-m', 'booster_ros', *arguments], capture_output=True,
                          text=True, cwd=ROOT, timeout=300, check=False)
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1
    assert '\x1b' not in done.stderr
    assert r'\x1b[2J' in done.stderr
