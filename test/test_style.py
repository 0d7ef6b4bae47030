# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The style of the source: linters, types, and who holds the copyright."""

from pathlib import Path
import subprocess
import sys

import pytest
from ros_process import ROOT

SOURCES = [ROOT / name for name in (
    'booster_ros', 'examples', 'launch', 'scripts', 'setup.py', 'test')]
HEADER = [
    '# Copyright 2026 The booster_ros authors',
    '# SPDX-License-Identifier: Apache-2.0',
]


def source_files() -> list[Path]:
    folders = [source for source in SOURCES if source.is_dir()]
    python = [path for folder in folders for path in folder.rglob('*.py')]
    others = [ROOT / 'setup.py', ROOT / 'Makefile', ROOT / '.ci' / 'run', ROOT / 'Dockerfile']
    return [*python, *others, *(ROOT / 'config').glob('*.yaml')]


def run_module(name: str, *arguments: str) -> None:
    """Run a tool of this environment on the sources, and show what it says where it complains."""
    pytest.importorskip(name)
    done = subprocess.run(
        [sys.executable, '-m', name, *arguments],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.linter
def test_ruff():
    run_module('ruff', 'check', '--no-cache', *map(str, SOURCES))


@pytest.mark.mypy
@pytest.mark.linter
def test_mypy():
    run_module('mypy')


@pytest.mark.flake8
@pytest.mark.linter
def test_flake8():
    ament_flake8 = pytest.importorskip('ament_flake8.main')
    status, errors = ament_flake8.main_with_errors(
        ['--config', str(ROOT / 'setup.cfg'), *map(str, SOURCES)]
    )
    assert status == 0, '\n'.join(errors)


@pytest.mark.pep257
@pytest.mark.linter
def test_pep257():
    ament_pep257 = pytest.importorskip('ament_pep257.main')
    # D401 and D402 as ruff sees them: properties are nouns, and prose may hold a function's name.
    ignored = [*(f'D10{n}' for n in range(8)), 'D401', 'D402']
    options = ['--convention', 'pep257', '--add-ignore', *ignored]
    assert ament_pep257.main([*map(str, SOURCES), *options]) == 0


def has_header(path: Path) -> bool:
    lines = path.read_text().splitlines()
    first = 1 if lines and lines[0].startswith('#!') else 0
    return lines[first:first + 2] == HEADER


@pytest.mark.linter
def test_every_source_file_names_holder_and_licence():
    files = source_files()
    assert len(files) > 20
    assert [path for path in files if not has_header(path)] == []
