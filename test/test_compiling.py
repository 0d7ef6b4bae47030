# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the user is told about compilation, and that the model runs without it."""

import fcntl
import os
from pathlib import Path
import shutil
import threading

import numpy as np
from positioner_runs import PAPER_CURRENT, positioner, rows
import pytest
from test_simulate import GOOD, read, start, write

from booster_ros.model import code_cache, compiled
from booster_ros.model.simulation import simulate
from booster_ros.programs.compiling import compilation_notices

MINIMAL = '/**:\n  ros__parameters:\n    supply:\n      pressure: 400000.0\n'


def test_nothing_is_announced_once_the_machine_code_is_there():
    if not compiled.available():
        pytest.skip('numba is not installed')
    time = rows(0.1)
    simulate(positioner(), time, np.full_like(time, PAPER_CURRENT))
    assert compiled.is_cached()
    assert compilation_notices() == ()


def test_an_empty_cache_is_announced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    if not compiled.available():
        pytest.skip('numba is not installed')
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path))
    assert not compiled.is_cached()
    assert 'once for this machine' in compilation_notices()[-1]


def test_a_cache_that_cannot_be_written_is_announced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    if not compiled.available():
        pytest.skip('numba is not installed')
    write(tmp_path / 'file', '')
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path / 'file' / 'below'))
    assert compiled.cache_folder() is None
    assert 'XDG_CACHE_HOME' in compilation_notices()[-1]


def test_without_numba_the_same_comes_out_and_it_is_said(tmp_path: Path):
    params = write(tmp_path / 'params.yaml', MINIMAL)
    source, out = write(tmp_path / 'in.csv', GOOD), tmp_path / 'out.csv'
    done = start(params, source, out, "import sys; sys.modules['numba'] = None")
    assert done.returncode == 0
    assert 'numba is not installed' in done.stderr
    assert done.stderr.count('\n') == 1
    expected = simulate(positioner(), np.array([0.0, 1.0]), np.array([4e-4, 4e-4]))
    assert read(out)['chamber_pressure'] == pytest.approx(expected['chamber_pressure'], abs=1e-3)


def twice(x):
    return 2.0 * x


def called(folder: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[float, int]:
    """Return what a function gives that is kept as machine code, and how often that was found."""
    import numba

    monkeypatch.setattr(numba.config, 'CACHE_DIR', str(folder))
    machine = numba.njit(cache=True)(twice)
    code_cache.keep_sealed(machine)
    return machine(21.0), sum(machine.stats.cache_hits.values())


DAMAGES = {
    'empty': lambda data: b'',
    'cut short': lambda data: data[:len(data) // 2],
    'garbage': lambda data: b'\x93garbage' * 100,
    'a bit': lambda data: data[:200] + bytes([data[200] ^ 1]) + data[201:],
}


@pytest.mark.parametrize('kind', ['nbi', 'nbc'])
def test_damaged_machine_code_is_made_anew(tmp_path: Path, monkeypatch, kind: str):
    """What a power cut or a full disk leaves ended every program, every time."""
    if not compiled.available():
        pytest.skip('numba is not installed')
    assert called(tmp_path, monkeypatch) == (42.0, 0)
    assert called(tmp_path, monkeypatch) == (42.0, 1)
    file, = tmp_path.rglob(f'*.{kind}')
    whole = file.read_bytes()
    for damage in DAMAGES.values():
        file.write_bytes(damage(whole))
        assert called(tmp_path, monkeypatch) == (42.0, 0)
    assert called(tmp_path, monkeypatch) == (42.0, 1)


def test_who_waits_while_another_process_compiles_finds_its_machine_code(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    if not compiled.available():
        pytest.skip('numba is not installed')
    import numba

    monkeypatch.setattr(numba.config, 'CACHE_DIR', str(tmp_path))
    machine = numba.njit(cache=True)(twice)
    code_cache.keep_sealed(machine)
    code_cache.compile_in_turn(machine, tmp_path)
    waiting = threading.Thread(target=machine, args=(21.0,))
    another = os.open(tmp_path, os.O_RDONLY)  # a lock is that of who has opened the folder
    try:
        fcntl.flock(another, fcntl.LOCK_EX)
        waiting.start()
        assert called(tmp_path, monkeypatch) == (42.0, 0)
    finally:
        os.close(another)
    waiting.join()
    assert sum(machine.stats.cache_hits.values()) == 1


def test_python_calls_one_function_of_the_compiled_model_and_is_refused_the_others():
    """They have no machine code of their own: a call would run whatever is at address 0."""
    modules = compiled.compiled_modules()
    if modules is None:
        pytest.skip('numba is not installed')
    with pytest.raises(TypeError, match='only into what calls it'):
        modules['gas']['flow_function'](0.5)
    time = rows(0.1)
    simulate(positioner(), time, np.full_like(time, PAPER_CURRENT))
    kept = compiled.cache_folder()
    assert kept is not None
    assert {path.name.partition('-')[0] for path in kept.rglob('*.nbi')} == {'kernel.run'}


def private_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the folder for machine code below a private one, and use that from now on."""
    if not compiled.available():
        pytest.skip('numba is not installed')
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path / 'home'))
    monkeypatch.setattr(code_cache.tempfile, 'gettempdir', lambda: str(tmp_path / 'tmp'))
    (tmp_path / 'tmp').mkdir()
    folder = compiled.cache_folder()
    assert folder is not None
    return folder


def test_damaged_machine_code_is_removed_and_that_is_said(tmp_path, monkeypatch):
    folder = private_cache(tmp_path, monkeypatch)
    whole = folder / 'model' / f'kernel.run-1.{compiled._PYTHON}.1.nbc'
    whole.parent.mkdir()
    whole.write_bytes(code_cache.sealed(b'code'))
    assert compilation_notices() == ()
    for damage in DAMAGES.values():
        whole.write_bytes(damage(code_cache.sealed(b'code' * 100)))
        removed, anew = compilation_notices()
        assert removed == f'1 damaged file of the compiled model removed, as of {whole}'
        assert 'once for this machine' in anew
        assert not whole.exists()


@pytest.mark.parametrize('mode', [0o777, 0o770, 0o722])
@pytest.mark.parametrize('above', [False, True])
def test_machine_code_that_others_may_have_written_is_not_run(tmp_path, monkeypatch, mode, above):
    folder = private_cache(tmp_path, monkeypatch)
    (folder.parent if above else folder).chmod(mode)
    place = compiled.cache_place()
    assert place.distrusted == folder
    assert place.folder is not None
    assert place.folder.is_relative_to(tmp_path / 'tmp')
    assert place.folder.stat().st_mode & 0o777 == 0o700
    said = compilation_notices()
    assert str(folder) in said[0]
    assert str(place.folder) in said[0]
    assert 'once for this machine' in said[-1]
    place.folder.chmod(mode)  # nowhere is a folder to be trusted
    assert compiled.cache_folder() is None
    assert 'it is not kept' in compilation_notices()[0]


def test_a_folder_that_anybody_may_exchange_is_not_trusted(tmp_path, monkeypatch):
    folder = private_cache(tmp_path, monkeypatch)
    (tmp_path / 'home').chmod(0o777)
    assert compiled.cache_place().distrusted == folder
    (tmp_path / 'home').chmod(0o1777)  # as /tmp
    assert compiled.cache_place().folder == folder


def test_machine_code_of_another_user_is_not_run(tmp_path, monkeypatch):
    folder = private_cache(tmp_path, monkeypatch)
    if os.geteuid() != 0:
        pytest.skip('only root gives files away')
    planted = folder / 'planted.nbc'
    planted.write_bytes(b'')
    assert compiled.cache_folder() == folder
    os.chown(planted, 12345, 12345)
    assert compiled.cache_place().distrusted == folder
    shutil.rmtree(folder.parent)


def test_a_folder_made_for_machine_code_is_private_whatever_new_folders_are(tmp_path, monkeypatch):
    before = os.umask(0)
    try:
        folder = private_cache(tmp_path, monkeypatch)
    finally:
        os.umask(before)
    assert [each.stat().st_mode & 0o777 for each in (folder.parent, folder)] == [0o700, 0o700]
