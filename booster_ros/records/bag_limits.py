# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How much of a bag is unpacked: a few kilobytes of it may stand for gigabytes, or for no end."""

from pathlib import Path

from rosbags.rosbag2 import Reader
from rosbags.rosbag2.storage_mcap import DECOMPRESSORS, zstd
import yaml

from booster_ros.records.record import RecordError

LARGEST_METADATA = 2_000_000
"""Bytes of `metadata.yaml`; a bag of a hundred topics has 100 kB."""

LARGEST_MESSAGE = 16_000_000
"""Bytes of a message; a state of the positioner has 2 kB."""

LARGEST_CHUNK = 512_000_000
"""Bytes that are compressed together in an MCAP file; recorders write a few megabytes."""

LARGEST_RATIO = 1000
"""By how much a file is compressed as a whole; that of a valve which stands still is so by 100."""

_PIECE = 1 << 22

_EVENTS = getattr(yaml, 'CSafeLoader', yaml.SafeLoader)


def check_metadata(folder: Path) -> None:
    """Raise RecordError where the metadata of a bag are too long, or have aliases."""
    path = folder / 'metadata.yaml'
    with path.open('rb') as file:
        text = file.read(LARGEST_METADATA + 1)
    if len(text) > LARGEST_METADATA:
        raise RecordError(
            f'metadata.yaml has more than {LARGEST_METADATA} bytes, which no recorder writes')
    for event in yaml.parse(text, Loader=_EVENTS):
        if isinstance(event, yaml.AliasEvent):
            line = event.start_mark.line + 1 if event.start_mark else '?'
            raise RecordError(
                f'metadata.yaml has an alias (*name) in line {line}, which no recorder writes')


def unpack_myself(bag: Reader) -> bool:
    """Tell whether the messages of an open bag are compressed one by one; it gives them so then."""
    one_by_one = bag.compression_mode == 'message'
    if one_by_one:
        bag.storage.metadata = bag.storage.metadata._replace(compression_mode=None)
    return one_by_one


def unpacked_message(data: bytes) -> bytes:
    """Return a message that was compressed alone; RecordError where it is too large."""
    return _unpacked(data, LARGEST_MESSAGE, 'message')


def check_packed_files(folder: Path) -> None:
    """Raise RecordError where a file that is compressed as a whole is too large unpacked."""
    for path in sorted(folder.glob('*.zstd')):
        with zstd.open(path, 'rb') as file:
            size = 0
            while piece := file.read(_PIECE):
                size += len(piece)
                if size > LARGEST_RATIO * path.stat().st_size + _PIECE:
                    raise RecordError(f'{path.name} is too large once it is unpacked')


def _unpacked(data: bytes, most: int, what: str) -> bytes:
    unpacking = zstd.ZstdDecompressor()
    found = unpacking.decompress(data, max_length=most + 1)
    if len(found) > most:
        raise RecordError(
            f'a compressed {what} of {len(data)} bytes has more than {most} once it is unpacked')
    if not unpacking.eof:
        raise RecordError(f'a compressed {what} is cut short')
    return found


def _zstd_chunk(data: bytes, size: int) -> bytes:
    return _unpacked(data, min(size, LARGEST_CHUNK), 'chunk')


def _lz4_chunk(data: bytes, size: int) -> bytes:
    if size > LARGEST_CHUNK:
        raise RecordError(
            f'a compressed chunk of {len(data)} bytes has {size} once it is unpacked')
    return _UNBOUNDED_LZ4(data, size)


_UNBOUNDED_LZ4 = DECOMPRESSORS['lz4']
# rosbags unpacks a chunk whatever its size, and compares that with what the file says afterwards
DECOMPRESSORS.update({'zstd': _zstd_chunk, 'lz4': _lz4_chunk})
