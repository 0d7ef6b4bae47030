# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Files that take their place when they are complete: under safe names, all of them or none."""

import os
from pathlib import Path
import signal
import stat
import subprocess
import sys

import pytest

from booster_ros.writing import unfinished
from booster_ros.writing.replacement import Replacement, replace_all, write_file

KILLED_AS_IT_WRITES = """
import os, sys, time
from pathlib import Path
from booster_ros.writing import unfinished
from booster_ros.writing.replacement import Replacement
file = Replacement(Path(sys.argv[1]))
made = unfinished.make_folder(Path(sys.argv[1]))
print('begun', flush=True)
time.sleep(100)
"""


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def writing_process(target: Path) -> subprocess.Popen:
    """Return a process that is writing to the target, and has begun to."""
    process = subprocess.Popen(
        [sys.executable, '-c', KILLED_AS_IT_WRITES, str(target)], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == 'begun\n'
    return process


def test_a_file_that_is_replaced_keeps_its_permissions(tmp_path):
    path = tmp_path / 'private.csv'
    path.write_text('old')
    for mode in (0o600, 0o664, 0o444):
        path.chmod(mode)
        write_file(path, b'new')
        assert stat.S_IMODE(path.stat().st_mode) == mode
    assert path.read_text() == 'new'


def test_while_it_is_written_it_is_as_private_as_what_it_replaces(tmp_path):
    path = tmp_path / 'private.csv'
    path.write_text('old')
    path.chmod(0o600)
    with Replacement(path):
        made, = (entry for entry in tmp_path.iterdir() if entry != path)
        assert stat.S_IMODE(made.stat().st_mode) == 0o600


def test_a_new_file_is_as_the_user_wants_new_files(tmp_path):
    before = os.umask(0o027)
    try:
        write_file(tmp_path / 'new', b'')
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / 'new').stat().st_mode) == 0o640


def test_two_that_write_to_one_place_do_not_share_a_file(tmp_path):
    """As two processes of the same number do, in two containers: the last one to end counts."""
    path = tmp_path / 'shared.csv'
    first, second = Replacement(path), Replacement(path)
    first.write(b'first ' * 1000)
    second.write(b'second')
    first.complete()
    second.complete()
    assert path.read_bytes() == b'second'
    assert names(tmp_path) == {'shared.csv'}


def test_a_link_under_the_temporary_name_is_not_followed(tmp_path, monkeypatch):
    """Another user who knew the name could let a private file be overwritten."""
    private = tmp_path / 'private'
    private.write_text('mine')
    drawn = iter(['00' * 8, '11' * 8])
    monkeypatch.setattr(unfinished.secrets, 'token_hex', lambda _: next(drawn))
    (tmp_path / f'.out.csv.{"00" * 8}.partial').symlink_to(private)
    with pytest.raises(FileExistsError):
        Replacement(tmp_path / 'out.csv')
    assert private.read_text() == 'mine'


def test_what_a_killed_process_has_left_is_removed_by_the_next(tmp_path):
    target = tmp_path / 'out.csv'
    process = writing_process(target)
    try:
        assert len(names(tmp_path)) == 2
        write_file(target, b'another')  # what is in use stays
        assert len(names(tmp_path)) == 3
    finally:
        process.send_signal(signal.SIGKILL)
        process.communicate()
    other = tmp_path / '.out.csv.mine.partial'
    other.write_text('no name of ours')
    write_file(target, b'again')
    assert names(tmp_path) == {'out.csv', other.name}


def test_a_long_name_leaves_room_for_the_temporary_one(tmp_path):
    write_file(tmp_path / ('ü' * 127), b'')
    assert names(tmp_path) == {'ü' * 127}


def made_and_there(tmp_path: Path) -> tuple[Path, Path, Path]:
    """Return the folders of new files, of those that were there, and one for the latter."""
    made, there, earlier = (tmp_path / name for name in ('made', 'there', 'earlier'))
    for folder in (made, there, earlier):
        folder.mkdir()
    for name in 'abc':
        (made / name).write_text('new')
    for name in 'ab':
        (there / name).write_text('old')
    (there / 'a').chmod(0o600)
    return made, there, earlier


def test_several_files_take_their_places(tmp_path):
    made, there, earlier = made_and_there(tmp_path)
    replace_all(made, there, 'abc', earlier)
    assert {path.name: path.read_text() for path in there.iterdir()} == dict.fromkeys('abc', 'new')
    assert stat.S_IMODE((there / 'a').stat().st_mode) == 0o600


@pytest.mark.parametrize('missing', 'abc')
def test_of_several_files_all_take_their_places_or_none(tmp_path, missing):
    """One of them cannot be moved: here it is not even there."""
    made, there, earlier = made_and_there(tmp_path)
    (made / missing).unlink()
    with pytest.raises(FileNotFoundError):
        replace_all(made, there, 'abc', earlier)
    assert {path.name: path.read_text() for path in there.iterdir()} == dict.fromkeys('ab', 'old')
    assert stat.S_IMODE((there / 'a').stat().st_mode) == 0o600
