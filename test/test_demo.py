# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The demo: its table, and its end when it is interrupted."""

import contextlib
import os
from pathlib import Path
import subprocess
import sys

from ros_process import PATIENCE, RosProcess, program

from booster_ros.paper.comparison import comparison
from booster_ros.paper.indices import StepIndices
from booster_ros.paper.printed import table_3
from booster_ros.programs import demo


def test_the_table_shows_the_paper_and_every_step():
    played = [StepIndices(270.0, 6.1, 9.6, 38000.0), StepIndices(271.0, 6.2, 9.7, 38400.0)]
    lines = comparison(played, table_3()).splitlines()
    rows = {line[:24].strip(): line[32:].split() for line in lines}
    assert rows['final pressure'] == ['270.3', '270.3', '270.0', '271.0', '+0.07%']
    assert rows['rise time, 10 to 90 %'] == ['6.46', '6.10', '6.10', '6.20', '+0.82%']
    assert rows['settling time, 5 %'] == ['9.68', '9.62', '9.60', '9.70', '+0.31%']
    assert rows['integral square error'] == ['40899', '38087', '38000', '38400', '+0.30%']


def processes_with(mark: str) -> list[Path]:
    """Return the processes of this machine in whose environment the mark stands."""
    found = []
    for path in Path('/proc').glob('[0-9]*/environ'):
        with contextlib.suppress(OSError):  # it has ended, or is somebody else's
            if mark.encode() in path.read_bytes():
                found.append(path.parent)
    return found


def test_an_interrupted_demo_ends_both_nodes(tmp_path):
    mark = f'DEMO_UNDER_TEST={tmp_path}'
    environment = dict(os.environ, DEMO_UNDER_TEST=str(tmp_path))
    with RosProcess(program('demo', '--out', str(tmp_path)), environment) as running:
        running.wait_for('playing')
        assert len(processes_with(mark)) == 3
        assert running.interrupt() == 130, running.output
        assert processes_with(mark) == []
    assert 'Traceback' not in running.output
    assert 'Traceback' not in (tmp_path / 'positioner.log').read_text()


INTERRUPTED_ELSEWHERE = """
import signal, subprocess, sys, threading
from booster_ros.programs.demo import ended

sleeper = subprocess.Popen([sys.executable, '-c', 'import time; time.sleep(600)'])

def as_a_library() -> None:
    signal.pthread_kill(threading.get_ident(), signal.SIGINT)

threading.Timer(1.0, as_a_library).start()
try:
    ended(sleeper)
except KeyboardInterrupt:
    print('interrupted')
finally:
    sleeper.kill()
"""


def test_an_interruption_that_comes_to_another_thread_ends_the_wait():
    done = subprocess.run([sys.executable, '-c', INTERRUPTED_ELSEWHERE], capture_output=True,
                          text=True, check=False, timeout=PATIENCE)
    assert (done.returncode, done.stdout.strip()) == (0, 'interrupted'), done.stderr


def test_a_folder_that_cannot_be_made_is_named(tmp_path):
    (tmp_path / 'file').touch()
    with RosProcess(program('demo', '--out', str(tmp_path / 'file' / 'out'))) as running:
        assert running.wait() == 2
    assert running.stdout == []
    (complaint,) = running.stderr
    assert str(tmp_path / 'file') in complaint


def test_where_no_domain_is_left_it_says_so(tmp_path, monkeypatch, capsys):
    def none_left():
        raise RuntimeError('no ROS domain is free')

    monkeypatch.delenv('ROS_DOMAIN_ID')
    monkeypatch.setattr(demo, 'claim_domain', none_left)
    assert demo.main(['--out', str(tmp_path)]) == 2
    assert capsys.readouterr().err == 'demo: no ROS domain is free\n'
