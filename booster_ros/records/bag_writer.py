# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Write a rosbag2 bag of Float64 topics, without a ROS installation."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
import os
from pathlib import Path
import shutil
import sqlite3

from rosbags.interfaces import (
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import StoragePlugin, Writer, WriterError
from rosbags.typesys import Stores, get_typestore

from booster_ros.records.record import RecordError
from booster_ros.writing.unfinished import make_folder

STORAGE = {'sqlite3': StoragePlugin.SQLITE3, 'mcap': StoragePlugin.MCAP}
"""The storage formats by their names in rosbag2."""

_FAILURES = (OSError, sqlite3.Error, WriterError)

_FLOAT64 = 'std_msgs/msg/Float64'
_FOREVER = QosTime(9223372036, 854775807)
_QUALITY = Qos(
    QosHistory.KEEP_LAST, 10, QosReliability.RELIABLE, QosDurability.VOLATILE, _FOREVER, _FOREVER,
    QosLiveliness.AUTOMATIC, _FOREVER, False,
)


class BagWriter:
    """
    Writes messages to a bag; the folder gets its name when it is complete.

    Until `close` the bag is in a temporary folder beside it. RecordError where it cannot be written
    or is there already: a bag is never overwritten.
    """

    def __init__(self, path: str | os.PathLike[str], topics: Sequence[str], storage: str):
        self.path = Path(path)
        """Where the bag is once it is complete."""
        if os.path.lexists(self.path):  # a folder cannot take the place of a link to nothing
            raise RecordError(f'{self.path} exists already; a bag is not overwritten')
        if storage not in STORAGE:
            raise RecordError(f'a bag is stored as {" or ".join(STORAGE)}, not as {storage!r}')
        try:
            self._folder, self._lock = make_folder(self.path)
        except OSError as error:
            raise self._failed(error) from None
        self._writer = Writer(
            self._folder / self.path.name,
            version=Writer.VERSION_LATEST, storage_plugin=STORAGE[storage],
        )
        self._types = get_typestore(Stores.ROS2_JAZZY)
        self._message = self._types.types[_FLOAT64]
        with self._discarded_on_failure():
            self._writer.open()
            self._connections = {
                topic: self._writer.add_connection(
                    topic, _FLOAT64, typestore=self._types, offered_qos_profiles=[_QUALITY]
                )
                for topic in topics
            }

    def write(self, topic: str, value: float, stamp: int) -> None:
        """Append a message that was sent or received at a stamp in nanoseconds."""
        data = self._types.serialize_cdr(self._message(data=value), _FLOAT64)
        try:
            self._writer.write(self._connections[topic], stamp, data)
        except _FAILURES as error:
            raise self._failed(error) from None

    def close(self) -> None:
        """Complete the bag and give it its name; a bag that cannot be completed is removed."""
        with self._discarded_on_failure():
            self._writer.close()
            os.rename(self._folder / self.path.name, self.path)
            self._folder.rmdir()
            os.close(self._lock)

    def discard(self) -> None:
        """Remove what was written."""
        with suppress(*_FAILURES):  # a full disk takes not even the last of it
            self._writer.abort()
        shutil.rmtree(self._folder, ignore_errors=True)
        with suppress(OSError):
            os.close(self._lock)

    @contextmanager
    def _discarded_on_failure(self) -> Iterator[None]:
        try:
            yield
        except _FAILURES as error:
            self.discard()
            raise self._failed(error) from None

    def _failed(self, error: Exception) -> RecordError:
        reason = error.strerror if isinstance(error, OSError) else error
        return RecordError(f'{self.path} cannot be written: {reason}')

    def __enter__(self) -> 'BagWriter':
        """Return the writer."""
        return self

    def __exit__(self, kind: object, error: object, trace: object) -> None:
        """Complete the bag, or discard it after an exception."""
        if kind is None:
            self.close()
        else:
            self.discard()
