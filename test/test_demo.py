# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The demo: its tables, its closed loop, and its end when it is interrupted."""

import contextlib
import os
from pathlib import Path
import subprocess
import sys

import numpy as np
import pytest
from ros_process import PATIENCE, RosProcess, program

from booster_ros.paper.comparison import comparison
from booster_ros.paper.indices import StepIndices
from booster_ros.paper.printed import table_3
from booster_ros.programs import demo, demo_closed_loop, demo_twin
from booster_ros.records import read_record


def test_the_table_shows_the_paper_and_every_step():
    played = [StepIndices(270.0, 6.1, 9.6, 38000.0), StepIndices(271.0, 6.2, 9.7, 38400.0)]
    lines = comparison(played, table_3()).splitlines()
    rows = {line[:24].strip(): line[32:].split() for line in lines}
    assert rows['final pressure'] == ['270.3', '270.3', '270.0', '271.0', '+0.07%']
    assert rows['rise time, 10 to 90 %'] == ['6.46', '6.10', '6.10', '6.20', '+0.82%']
    assert rows['settling time, 5 %'] == ['9.68', '9.62', '9.60', '9.70', '+0.31%']
    assert rows['integral square error'] == ['40899', '38087', '38000', '38400', '+0.30%']


def test_the_closed_loop_follows_its_set_points_over_topics(tmp_path, capsys, monkeypatch):
    def play(settings, start, *others):
        # fewer samples than the demo shows; each costs both nodes computing time
        original({**settings, 'rate': 25.0}, {**start, 'publish_rate': 25.0}, *others)

    original = demo_closed_loop.play
    monkeypatch.setattr(demo_closed_loop, 'play', play)
    with demo.own_domain(os.environ) as environment:
        demo_closed_loop.show_closed_loop(tmp_path, environment, dwell=3.9)
    record = read_record(tmp_path / 'closed_loop.csv')
    for start, level in ((0.0, 4e-3), (3.9, 12e-3), (7.8, 4e-3)):
        resting = (record['time'] > start + 3.5) & (record['time'] < start + 3.85)
        assert np.count_nonzero(resting) >= 5
        np.testing.assert_allclose(record['set_point'][resting], level)
        np.testing.assert_allclose(record['valve_position'][resting], level, atol=0.15e-3)
    assert np.ptp(record['chamber_pressure']) == pytest.approx(75e3, rel=0.05)
    rows = {line[:24].strip(): line[36:].split() for line in capsys.readouterr().out.splitlines()}
    assert rows['step'] == ['+50.0', '-50.0']
    assert [float(text) for text in rows['T63']] == pytest.approx([1.13, 1.86], abs=0.1)
    assert [float(text) for text in rows['T86']] == pytest.approx([1.63, 2.50], abs=0.1)
    assert [float(text) for text in rows['dead time']] == pytest.approx([0.02, 0.04], abs=0.1)
    assert all(0.0 <= float(text) < 2.0 for text in rows['overshoot'])
    assert (tmp_path / 'closed_loop.png').read_bytes().startswith(b'\x89PNG')


def test_the_demo_goes_on_to_the_closed_loop_in_the_same_domain(tmp_path, monkeypatch):
    seen = []
    monkeypatch.setattr(demo, 'play_step_test', lambda _, environment: seen.append(environment))
    monkeypatch.setattr(demo, 'report', lambda *_: None)
    monkeypatch.setattr(demo, 'show_closed_loop',
                        lambda _, environment: seen.append(environment))
    monkeypatch.setattr(demo, 'show_twin', seen.append)
    assert demo.main(['--out', str(tmp_path)]) == 0
    assert seen[2:] == [tmp_path]
    assert seen[0] is seen[1]


def test_the_twin_of_a_valve_that_begins_to_rub_adopts_friction(tmp_path, capsys, monkeypatch):
    """Of a valve that it learns, and diagnoses, by less than the demo does."""
    monkeypatch.setattr(demo_twin, 'HYPOTHESES', ('stem_friction',))
    monkeypatch.setattr(demo_twin, 'SETTINGS', demo_twin.SETTINGS._replace(learning=60.0))
    for name, seconds in (
            ('CHANGE', 65.0), ('HISTORY', 12.0), ('TRIAL', 10.0), ('AFTERWARDS', 2.0)):
        monkeypatch.setattr(demo_twin, name, seconds)
    demo_twin.show_twin(tmp_path)
    said = capsys.readouterr().out
    assert 'alarm: valve_position' in said
    assert 'verdict: the valve has stem friction' in said
    assert 's  adopted: it predicted the next 10 s better' in said
    assert (tmp_path / 'twin.png').read_bytes().startswith(b'\x89PNG')


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
from booster_ros.programs.demo_nodes import ended

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


def test_a_folder_that_cannot_be_made_is_named(tmp_path, capfd):
    (tmp_path / 'file').touch()
    assert demo.main(['--out', str(tmp_path / 'file' / 'out')]) == 2
    printed = capfd.readouterr()
    assert printed.out == ''
    (complaint,) = printed.err.splitlines()
    assert str(tmp_path / 'file') in complaint


def test_where_no_domain_is_left_it_says_so(tmp_path, monkeypatch, capsys):
    def none_left():
        raise RuntimeError('no ROS domain is free')

    monkeypatch.delenv('ROS_DOMAIN_ID')
    monkeypatch.setattr(demo, 'claim_domain', none_left)
    assert demo.main(['--out', str(tmp_path)]) == 2
    assert capsys.readouterr().err == 'demo: no ROS domain is free\n'
