# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Files that replace others when they are complete: one, or several of which all do or none."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
import errno
import os
from pathlib import Path
import shutil

from .unfinished import EVERYBODY, make_file


class Replacement:
    """
    A file that takes its place when it is complete.

    Used in a `with`, an exception discards it. OSError where it cannot be written; what was at its
    place is then as it was.
    """

    def __init__(self, target: Path) -> None:
        """Begin to write to `target`, which must not be a link."""
        self.target = target
        """The place that it will take."""
        self._unfinished, descriptor = make_file(target)
        self._file = os.fdopen(descriptor, 'wb')

    def write(self, data: bytes) -> None:
        """Append."""
        self._file.write(data)

    def complete(self) -> None:
        """Put it on the disk and then in its place."""
        try:
            self._file.flush()
            os.fsync(self._file.fileno())
            os.replace(self._unfinished, self.target)  # while it is locked: it is no leftover
            self._file.close()
        except BaseException:
            self.discard()
            raise

    def discard(self) -> None:
        """Remove what was written."""
        with suppress(OSError):  # the first failure is worth more than this one
            self._unfinished.unlink(missing_ok=True)
        with suppress(OSError):  # a full disk takes not even the last of it
            self._file.close()

    def __enter__(self) -> Replacement:
        """Return the file."""
        return self

    def __exit__(self, kind: object, error: object, trace: object) -> None:
        """Complete the file, or discard it after an exception."""
        if kind is None:
            self.complete()
        else:
            self.discard()


def write_file(target: Path, data: bytes) -> None:
    """Write a file, complete or not at all; OSError where it cannot be."""
    with Replacement(target) as file:
        file.write(data)


def replace_all(made: Path, place: Path, names: Iterable[str], earlier: Path) -> None:
    """
    Let the files `names` in the folder `made` replace those in `place`: all of them, or none.

    Each gets the permissions of the one that it replaces. `earlier` is an empty folder of the same
    file system, which holds those that were there until all have been replaced. OSError where one
    cannot be; all are then as they were.
    """
    names = tuple(names)
    kept = {name for name in names if keep(place / name, earlier / name)}
    moved: list[str] = []
    try:
        for name in names:
            if name in kept:
                os.chmod(made / name, os.stat(earlier / name).st_mode & EVERYBODY)
            os.replace(made / name, place / name)
            moved.append(name)
    except BaseException:
        for name in moved:
            if name in kept:
                os.replace(earlier / name, place / name)
            else:
                (place / name).unlink()
        raise


def keep(path: Path, under: Path) -> bool:
    """
    Give what is at `path` the name `under` as well; tell whether there was anything.

    OSError where it is another file system's: then nothing can replace it.
    """
    try:
        os.link(path, under, follow_symlinks=False)
    except FileNotFoundError:
        return False
    except OSError as error:
        if error.errno == errno.EXDEV:
            raise OSError(errno.EXDEV, 'is mounted on its own, and nothing can take its place',
                          str(path)) from None
        shutil.copy2(path, under, follow_symlinks=False)  # a file system without hard links
    return True
