# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
What is being written, under a name of its own beside the place that it will take.

The name is drawn at random and made anew: a link that somebody planted under it is not followed,
and two processes never share one, also where they have the same number, as in two containers.
Whoever writes holds a lock on it until the end. What a process that was killed has left is not
locked, and is removed by the next one that writes to the same place.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
import fcntl
import os
from pathlib import Path
import re
import secrets
import shutil
import stat

SUFFIX = '.partial'

_LONGEST_PREFIX = 100
"""Bytes of the wanted name that a temporary one begins with: a name has 255 at most."""

_RANDOM_BYTES = 8

EVERYBODY = 0o777
"""The permissions of owner, group and others."""


def make_file(target: Path) -> tuple[Path, int]:
    """
    Return a new, locked file beside `target`, and its descriptor for writing.

    It has the permissions of the file at `target`, or those of any new file where there is none.
    OSError where it cannot be made.
    """
    remove_leftovers(target)
    kept = _permissions(target)
    while True:
        path = _new_name(target)
        flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC
        descriptor = os.open(path, flags, 0o666 if kept is None else kept.st_mode & EVERYBODY)
        if kept is not None:
            with suppress(OSError):  # the group is changed by members only
                os.fchown(descriptor, -1, kept.st_gid)
            with suppress(OSError):
                os.fchmod(descriptor, kept.st_mode & EVERYBODY)
        if _locked(descriptor, path):
            return path, descriptor
        os.close(descriptor)


@contextmanager
def folder(target: Path) -> Iterator[Path]:
    """
    Yield a new, locked folder beside `target`, and remove what is left of it at the end.

    OSError where it cannot be made.
    """
    path, descriptor = make_folder(target)
    try:
        yield path
    finally:
        shutil.rmtree(path, ignore_errors=True)
        os.close(descriptor)


def make_folder(target: Path) -> tuple[Path, int]:
    """
    Return a new, locked folder beside `target`, and the descriptor that holds the lock.

    OSError where it cannot be made.
    """
    remove_leftovers(target)
    while True:
        path = _new_name(target)
        try:  # before the folder exists: an interruption may come the moment it does
            path.mkdir()
            descriptor = os.open(
                path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC)
            if _locked(descriptor, path):
                return path, descriptor
            os.close(descriptor)
        except KeyboardInterrupt:
            shutil.rmtree(path, ignore_errors=True)
            raise


def remove_leftovers(target: Path) -> None:
    """Remove what processes that were killed have left beside `target`, of this user's alone."""
    ours = re.compile(f'{re.escape(_prefix(target))}[0-9a-f]{{{2 * _RANDOM_BYTES}}}{SUFFIX}')
    with suppress(OSError):
        for name in filter(ours.fullmatch, os.listdir(target.parent)):
            _remove_unless_locked(target.parent / name)


def _remove_unless_locked(path: Path) -> None:
    with suppress(OSError):
        descriptor = os.open(
            path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
        try:
            found = os.fstat(descriptor)
            if found.st_uid != os.geteuid():
                return
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)  # BlockingIOError: in use
            if stat.S_ISDIR(found.st_mode):
                shutil.rmtree(path, ignore_errors=True)
            elif stat.S_ISREG(found.st_mode):
                path.unlink()
        finally:
            os.close(descriptor)


def _locked(descriptor: int, path: Path) -> bool:
    """
    Lock what is open; tell whether it still has its name.

    Between its making and its lock another process may have taken it for a leftover. Where a file
    system knows no locks nothing is removed either.
    """
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX)
    except OSError:
        return True
    try:
        there = os.stat(path, follow_symlinks=False)
    except FileNotFoundError:
        return False
    here = os.fstat(descriptor)
    return (here.st_dev, here.st_ino) == (there.st_dev, there.st_ino)


def _permissions(target: Path) -> os.stat_result | None:
    try:
        return os.stat(target)
    except FileNotFoundError:
        return None


def _new_name(target: Path) -> Path:
    return target.with_name(f'{_prefix(target)}{secrets.token_hex(_RANDOM_BYTES)}{SUFFIX}')


def _prefix(target: Path) -> str:
    """Return how the names begin of what is being written to `target`."""
    return f'.{os.fsdecode(os.fsencode(target.name)[:_LONGEST_PREFIX])}.'
