# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""`python -m booster_ros`: what every program has in common."""

from functools import cache
import signal
import subprocess
import sys

import pytest

from booster_ros import __main__
from booster_ros.__main__ import PROGRAMS


NODES = {name for name, (module, _) in PROGRAMS.items()
         if module.startswith('booster_ros.nodes')}


@cache
def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    """Run the command, once for all tests that ask for it."""
    return subprocess.run(
        [sys.executable, '-m', 'booster_ros', *arguments],
        capture_output=True,
        text=True,
        check=False,
    )


def imported_by(module: str) -> set[str]:
    """Return the modules that importing this one brings along."""
    script = f'import sys, {module}; print(*sys.modules)'
    command = [sys.executable, '-c', script]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return set(done.stdout.split())


def test_help_lists_every_program_on_a_line():
    done = run('--help')
    assert done.returncode == 0
    assert done.stderr == ''
    listed = [line.split(maxsplit=1) for line in done.stdout.splitlines() if line[:2] == '  ']
    assert dict(listed) == {
        name: purpose for name, (_, purpose) in PROGRAMS.items()
    }


def test_without_a_name_it_shows_the_list_and_fails():
    done = run()
    assert done.returncode == 2
    assert done.stdout == ''
    assert 'positioner' in done.stderr


def test_an_unknown_name_is_answered_in_one_sentence():
    done = run('positionr', '--help')
    assert done.returncode == 2
    assert done.stdout == ''
    assert len(done.stderr.splitlines()) == 1
    assert "'positionr'" in done.stderr
    assert 'positioner' in done.stderr


@pytest.mark.parametrize('name', sorted(NODES))
def test_every_node_explains_itself(name):
    """In a process of its own, as it takes the signals over."""
    done = run(name, '--help')
    assert done.returncode == 0, done.stderr
    assert 'usage' in done.stdout.lower()


@pytest.mark.parametrize('name', sorted(set(PROGRAMS) - NODES))
def test_every_other_program_explains_itself(name, capsys):
    with pytest.raises(SystemExit) as end:
        __main__.main([name, '--help'])
    assert end.value.code == 0
    assert f'usage: {name}' in capsys.readouterr().out


@pytest.mark.parametrize(('node', 'page'), [
    ('positioner', 'docs/node.md'), ('fake_controller', 'docs/fake_controller.md')])
def test_a_node_shows_how_parameters_are_given_and_where_they_are_listed(node, page):
    text = run(node, '--help').stdout
    assert f'  {node} --ros-args --params-file ' in text
    assert page in text


@pytest.mark.parametrize(('name', 'option', 'others'), [
    ('simulate', '--params', ['--input', 'i', '--out', 'o']),
    ('simulate', '--input', ['--params', 'p', '--out', 'o']),
    ('simulate', '--out', ['--params', 'p', '--input', 'i']),
    ('close_loop', '--record', ['--params', 'p', '--out', 'o']),
    ('close_loop', '--params', ['--record', 'r', '--out', 'o']),
    ('close_loop', '--out', ['--record', 'r', '--params', 'p']),
    ('close_loop', '--validation', ['--record', 'r', '--params', 'p', '--out', 'o']),
    ('close_loop', '--map', ['--record', 'r', '--params', 'p', '--out', 'o']),
    ('inspect', '--map', ['f']),
    ('inspect', '--csv', ['f']),
    ('paper', '--out', []),
    ('demo', '--out', []),
])
def test_an_empty_path_is_not_the_current_folder(name, option, others, capsys):
    with pytest.raises(SystemExit) as end:
        __main__.main([name, *others, option, ''])
    assert end.value.code == 2
    assert capsys.readouterr().err.splitlines()[-1] == (
        f"{name}: error: argument {option}: '' is no path")


def test_the_list_of_programs_imports_none_of_them():
    assert not {'numpy', 'rclpy'} & imported_by('booster_ros.__main__')


@pytest.mark.parametrize('node', ['positioner', 'fake_controller'])
def test_a_node_needs_rclpy_and_numpy_alone(node):
    heavy = {'matplotlib', 'numba', 'pandas', 'pint', 'rosbags', 'scipy', 'tqdm'}
    assert not heavy & imported_by(f'booster_ros.nodes.{node}')


@pytest.mark.parametrize('program', ['close_loop', 'fleet', 'simulate', 'inspect'])
def test_no_program_waits_at_its_start_for_what_draws_or_for_statistics(program):
    assert not {'matplotlib', 'scipy.stats'} & imported_by(f'booster_ros.programs.{program}')


@pytest.fixture
def own_signals():
    """Leave signals as they were: a program sets them for the process that is its own."""
    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    before = {number: signal.getsignal(number) for number in numbers}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.usefixtures('own_signals')
def test_interrupted_while_libraries_load_it_says_so(monkeypatch, capsys):
    def interrupted(module):
        raise KeyboardInterrupt

    monkeypatch.setattr(__main__, 'import_module', interrupted)
    assert __main__.main(['close_loop']) == 130
    assert capsys.readouterr().err == 'close_loop: interrupted\n'
    # the executables that setup.py installs; nodes end with 0 when they are interrupted
    assert (__main__.simulate(), __main__.positioner()) == (130, 0)
    assert capsys.readouterr().err == 'simulate: interrupted\npositioner: interrupted\n'
