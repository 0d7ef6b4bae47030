# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Where machine code is kept from run to run, and whether it may be run.

Machine code is run as it is found. So a folder counts only where nobody but the user can have
written into it, and a file only where it is as it was written: a power cut or a full disk leaves
files that are cut short, which the interpreter would meet with an exception or a crash.
"""

from collections.abc import Iterable, Iterator
import contextlib
import fcntl
import functools
import hashlib
import os
from pathlib import Path
import pickle
import stat
import tempfile
from typing import Any, NamedTuple

NAME = 'booster_ros'

_DIGEST_BYTES = 32
_OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH


class Place(NamedTuple):
    """The folder for machine code, None where there is none, and the one that is not trusted."""

    folder: Path | None
    distrusted: Path | None


def place(digest: str) -> Place:
    """
    Return the folder for what has this digest.

    It is below `$XDG_CACHE_HOME`, `~/.cache` without that. Where others may have written to that
    folder it is one below the folder for temporary files, which nobody else may write to.
    """
    home = Path(os.environ.get('XDG_CACHE_HOME') or os.path.expanduser('~/.cache'))
    first = home / NAME / digest
    if not _is_there(first):
        return Place(None, None)
    if _is_private(first):
        return Place(first, None)
    second = Path(tempfile.gettempdir()) / f'{NAME}-{os.geteuid()}' / digest
    return Place(second if _is_there(second) and _is_private(second) else None, first)


def _is_there(folder: Path) -> bool:
    """Tell whether a folder can be written to; it is made where it is not there."""
    try:
        folder.parent.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        for each in (folder.parent, folder):
            each.mkdir(mode=0o700, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def _is_private(folder: Path) -> bool:
    """Tell whether a folder, that which it is in, and all in it are this user's alone."""
    try:
        shielded = all(
            not _may_be_swapped(above) for above in folder.resolve().parent.parents)
        own = [os.stat(each, follow_symlinks=False) for each in (folder.parent, folder)]
        within = [os.stat(each, follow_symlinks=False) for each in folder.rglob('*')]
    except OSError:
        return False
    user = os.geteuid()
    return (shielded
            and not any(each.st_mode & _OTHERS_WRITE or stat.S_ISLNK(each.st_mode) for each in own)
            and all(each.st_uid == user for each in (*own, *within)))


def _may_be_swapped(above: Path) -> bool:
    """Tell whether anybody may put another folder in the place of one in this folder."""
    mode = os.stat(above).st_mode
    return bool(mode & stat.S_IWOTH) and not mode & stat.S_ISVTX


def sealed(data: bytes) -> bytes:
    """Return data with what tells whether it has been damaged."""
    return data + hashlib.sha256(data).digest()


def unsealed(data: bytes) -> bytes | None:
    """Return what has been sealed, None where it is damaged."""
    content, seal = data[:-_DIGEST_BYTES], data[-_DIGEST_BYTES:]
    return content if hashlib.sha256(content).digest() == seal else None


def remove_damaged(folder: Path) -> list[Path]:
    """Remove the damaged files of a folder with machine code; return their paths."""
    damaged = [path for path in _files(folder) if not _is_whole(path)]
    for path in damaged:
        path.unlink(missing_ok=True)
    return damaged


def _files(folder: Path) -> Iterable[Path]:
    return (path for kind in ('nbi', 'nbc') for path in folder.rglob(f'*.{kind}'))


def _is_whole(path: Path) -> bool:
    try:
        return unsealed(path.read_bytes()) is not None
    except OSError:
        return False


def keep_sealed(dispatcher: Any) -> None:
    """Let numba keep the code of a function, for which it keeps files already, in sealed files."""
    kept = dispatcher._cache._cache_file
    kept.__class__ = _sealed_files(type(kept))  # type: ignore[arg-type]


def compile_in_turn(dispatcher: Any, folder: Path) -> None:
    """
    Let one process at a time compile a function, so that those that wait find its machine code.

    Nodes that a launch file starts together would all do the same minute's work.
    """
    compiled = dispatcher.compile

    def in_turn(signature: Any) -> Any:
        with _turn(folder):
            return compiled(signature)

    dispatcher.compile = in_turn


@contextlib.contextmanager
def _turn(folder: Path) -> Iterator[None]:
    """Wait for what other processes do in a folder; where that cannot be told, do not wait."""
    with contextlib.ExitStack() as held:
        with contextlib.suppress(OSError):  # a file system without locks, or no folder any more
            descriptor = os.open(folder, os.O_RDONLY)
            held.callback(os.close, descriptor)
            fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield


@functools.cache
def _sealed_files(base: Any) -> Any:
    """Return the class of numba's that keeps files, with files that are sealed as a whole."""

    class Sealed(base):
        """The index of a function and its machine code, a file each; damaged ones are not there."""

        def _load_index(self) -> Any:
            content = self._unsealed(self._index_path)
            if content is None:
                return {}
            version, stamp, overloads = pickle.loads(content)
            return overloads if (version, stamp) == (self._version, self._source_stamp) else {}

        def _save_index(self, overloads: Any) -> None:
            content = self._dump((self._version, self._source_stamp, overloads))
            with self._open_for_write(self._index_path) as file:
                file.write(sealed(content))

        def _load_data(self, name: str) -> Any:
            content = self._unsealed(self._data_path(name))
            if content is None:
                raise OSError(f'{name} is damaged')  # to numba as if it were not there
            return pickle.loads(content)

        def _save_data(self, name: str, data: Any) -> None:
            content = self._dump(data)
            with self._open_for_write(self._data_path(name)) as file:
                file.write(sealed(content))

        def _unsealed(self, path: str) -> bytes | None:
            try:
                return unsealed(Path(path).read_bytes())
            except OSError:
                return None

    return Sealed
