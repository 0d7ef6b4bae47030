# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the user is told about compilation, and that the model runs without it."""

from pathlib import Path

import numpy as np
from positioner_runs import PAPER_CURRENT, positioner, rows
import pytest
from test_simulate import GOOD, read, start, write

from booster_ros.model import compiled
from booster_ros.model.simulation import simulate
from booster_ros.programs.compiling import compilation_notice

MINIMAL = '/**:\n  ros__parameters:\n    supply:\n      pressure: 400000.0\n'


def test_nothing_is_announced_once_the_machine_code_is_there():
    if not compiled.available():
        pytest.skip('numba is not installed')
    time = rows(0.1)
    simulate(positioner(), time, np.full_like(time, PAPER_CURRENT))
    assert compiled.is_cached()
    assert compilation_notice() == ''


def test_an_empty_cache_is_announced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    if not compiled.available():
        pytest.skip('numba is not installed')
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path))
    assert not compiled.is_cached()
    assert 'once for this machine' in compilation_notice()


def test_a_cache_that_cannot_be_written_is_announced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    if not compiled.available():
        pytest.skip('numba is not installed')
    write(tmp_path / 'file', '')
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path / 'file' / 'below'))
    assert compiled.cache_folder() is None
    assert 'XDG_CACHE_HOME' in compilation_notice()


def test_without_numba_the_same_comes_out_and_it_is_said(tmp_path: Path):
    params = write(tmp_path / 'params.yaml', MINIMAL)
    source, out = write(tmp_path / 'in.csv', GOOD), tmp_path / 'out.csv'
    done = start(params, source, out, "import sys; sys.modules['numba'] = None")
    assert done.returncode == 0
    assert 'numba is not installed' in done.stderr
    assert done.stderr.count('\n') == 1
    expected = simulate(positioner(), np.array([0.0, 1.0]), np.array([4e-4, 4e-4]))
    assert read(out)['chamber_pressure'] == pytest.approx(expected['chamber_pressure'], abs=1e-3)
