# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Trends and alarms of months in an SQLite file, which outlives whoever writes it."""

from collections.abc import Mapping
from pathlib import Path
import sqlite3

_TABLES = """
CREATE TABLE IF NOT EXISTS trend (time REAL NOT NULL, name TEXT NOT NULL, value REAL NOT NULL);
CREATE INDEX IF NOT EXISTS trend_by_name ON trend (name, time);
CREATE TABLE IF NOT EXISTS alarm (
    time REAL NOT NULL, since REAL NOT NULL, channel TEXT NOT NULL, kind TEXT NOT NULL,
    shift REAL NOT NULL, sentence TEXT NOT NULL);
"""


class StoreError(ValueError):
    """A file that cannot be a store; the message is one sentence that names it."""


class Store:
    """
    Appends to the file; what a call has written is on disk when it returns.

    The write-ahead log with full synchronisation keeps whole transactions, whenever the process is
    killed (https://sqlite.org/wal.html).
    """

    def __init__(self, path: str | Path) -> None:
        """Open or make the file; StoreError where that cannot be."""
        try:
            self._connection = sqlite3.connect(path)
            self._connection.execute('PRAGMA journal_mode=WAL')
            self._connection.execute('PRAGMA synchronous=FULL')
            self._connection.executescript(_TABLES)
        except sqlite3.Error as error:
            raise StoreError(f'{path} cannot be a store of trends: {error}') from None

    def trends(self, time: float, values: Mapping[str, float]) -> None:
        """Append values at a time, s since 1970, together."""
        with self._connection:
            self._connection.executemany(
                'INSERT INTO trend VALUES (?, ?, ?)',
                [(time, name, value) for name, value in values.items()])

    def alarm(self, time: float, since: float, channel: str, kind: str, shift: float,
              sentence: str) -> None:
        """Append an alarm."""
        with self._connection:
            self._connection.execute(
                'INSERT INTO alarm VALUES (?, ?, ?, ?, ?, ?)',
                (time, since, channel, kind, shift, sentence))

    def latest(self) -> dict[str, float]:
        """Return the last value of every trend."""
        return dict(self._connection.execute(
            'SELECT name, value FROM trend WHERE rowid IN '
            '(SELECT max(rowid) FROM trend GROUP BY name)'))

    def close(self) -> None:
        """Close the file."""
        self._connection.close()
