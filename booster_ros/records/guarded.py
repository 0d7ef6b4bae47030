# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Files that may be read: none that is no file, has endless lines or would not fit into memory.

Whatever reads a record opens it here.
"""

from __future__ import annotations

import bz2
import gzip
import importlib
import io
import lzma
import os
import stat
from typing import Any, BinaryIO
import zlib

from booster_ros.records.record import RecordError

COMPRESSED = (b'\x1f\x8b', b'BZh', b'\xfd7zXZ', b'\x28\xb5\x2f\xfd')
"""How files begin that gzip, bzip2, xz and Zstandard have compressed."""

LONGEST_LINE = 1 << 20
"""Bytes of the longest line: more is no table."""

MOST_COLUMNS = 10_000
"""Most columns of a table."""

MOST_VALUES = 200_000_000
"""Most values of a record that is held in memory, 1.6 GB."""


def check_regular(path: str | os.PathLike[str]) -> None:
    """Raise RecordError for what is no file: a device or a pipe may never end."""
    try:
        mode = os.stat(path).st_mode
    except OSError as error:
        raise RecordError(f'{os.fspath(path)}: {error.strerror}') from None
    except ValueError:
        raise RecordError(f'{os.fspath(path)!r} is no path') from None
    if stat.S_ISDIR(mode):
        raise RecordError(f'{os.fspath(path)}: Is a directory')
    if not stat.S_ISREG(mode):
        raise RecordError(f'{os.fspath(path)}: is a device, a pipe or a socket, which may never '
                          'end; write what comes from it into a file first')


class GuardedStream(io.RawIOBase):
    """The bytes of a stream; RecordError where one line is longer than a table's can be."""

    def __init__(self, stream: BinaryIO, source: str, file: BinaryIO):
        super().__init__()
        self._stream = stream
        self._file = file
        self._source = source
        self._since_line_end = 0

    def readable(self) -> bool:
        """Return True."""
        return True

    def readinto(self, buffer: Any) -> int:
        """Read into a buffer, return the number of bytes."""
        try:
            block = self._stream.read(min(len(buffer), LONGEST_LINE))
        except (OSError, EOFError, lzma.LZMAError, zlib.error, ValueError) as error:
            raise RecordError(f'{self._source}: cannot be read, {error}') from None
        end = max(block.rfind(b'\n'), block.rfind(b'\r'))
        self._since_line_end = (self._since_line_end if end < 0 else -end - 1) + len(block)
        if self._since_line_end > LONGEST_LINE:
            raise endless_line(self._source)
        buffer[:len(block)] = block
        return len(block)

    def close(self) -> None:
        """Close the stream and the file behind it too."""
        if not self.closed:
            self._stream.close()
            self._file.close()
        super().close()


def endless_line(source: str) -> RecordError:
    """Return the error for a line that no table has."""
    return RecordError(f'{source}: has a line of more than {LONGEST_LINE >> 20} MB, which no table '
                       'has')


def check_count(values: int, source: str) -> None:
    """Raise RecordError where a record has more values than are held in memory."""
    if values > MOST_VALUES:
        raise RecordError(f'{source}: has more than {MOST_VALUES // 10**6} million values; cut it '
                          'into shorter records')


def opened_bytes(path: str | os.PathLike[str]) -> io.BufferedReader:
    """Return the bytes of a file, unpacked where it is compressed; no line is endless."""
    check_regular(path)
    source = os.fspath(path)
    try:
        file = open(path, 'rb')  # noqa: SIM115
        start = file.read(6)
        file.seek(0)
    except OSError as error:
        raise RecordError(f'{source}: {error.strerror}') from None
    return io.BufferedReader(GuardedStream(_unpacked(file, start, source), source, file), 1 << 18)


def _unpacked(file: BinaryIO, start: bytes, source: str) -> Any:
    gzip_mark, bzip2_mark, xz_mark, zstandard_mark = COMPRESSED
    if start.startswith(gzip_mark):
        return gzip.GzipFile(fileobj=file)
    if start.startswith(bzip2_mark):
        return bz2.BZ2File(file)
    if start.startswith(xz_mark):
        return lzma.LZMAFile(file)
    if start.startswith(zstandard_mark):
        return _zstandard(file, source)
    return file


class _Zstandard:
    """A file that Zstandard has compressed; ValueError where it is damaged."""

    def __init__(self, file: BinaryIO, module: Any):
        self._stream, self._damaged = module.ZstdFile(file), module.ZstdError

    def read(self, size: int) -> bytes:
        """Return unpacked bytes, so many at the most."""
        try:
            return bytes(self._stream.read(size))
        except self._damaged as error:
            raise ValueError(error) from None

    def close(self) -> None:
        """Close it."""
        self._stream.close()


def _zstandard(file: BinaryIO, source: str) -> Any:
    for module in ('compression.zstd', 'backports.zstd'):  # the first from Python 3.14 on
        try:
            return _Zstandard(file, importlib.import_module(module))
        except ModuleNotFoundError:
            continue
    file.close()
    raise RecordError(f'{source}: is compressed by zstd, which needs the Python package '
                      'backports.zstd')
