# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Record what is sent to a positioner and what comes back, to a CSV, a bag, both or neither."""

from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path

import numpy as np

from booster_ros.records.csv_file import CsvWriter
from booster_ros.records.record import needs_rosbags
from booster_ros.records.row_builder import Row, RowBuilder

_ROWS_AT_ONCE = 100
_NANOSECONDS = 1e-9


class Recording:
    """
    A recording under way; its files get their names in `close`.

    A message of the bag has its own stamp; the CSV has the rows of `RowBuilder`, and time counts
    from `start`. RecordError where a file cannot be written.
    """

    def __init__(
        self, csv_path: str, bag_path: str, bag_format: str, topics: Mapping[str, str],
        command: str = 'control_current',
    ) -> None:
        """
        Open the files whose paths are not empty; `topics` (by column) are those of the bag.

        `command` is the column of what is sent.
        """
        self.rows = 0
        """Rows so far."""
        self.start = 0
        """Stamp at which time is zero, ns."""
        self._topics = topics
        self._command = command
        self._builder = RowBuilder()
        self._waiting: list[Row] = []
        time, _, *outputs = Row._fields
        self._csv = CsvWriter(csv_path, (time, command, *outputs)) if csv_path else None
        self._bag = None
        if bag_path:
            # Only who asks for a bag needs rosbags.
            try:
                from booster_ros.records.bag_writer import BagWriter
                self._bag = BagWriter(bag_path, list(topics.values()), bag_format)
            except ModuleNotFoundError as missing:
                self.discard()
                raise needs_rosbags(f'{bag_path}: writing a bag', missing) from None
            except BaseException:
                self.discard()
                raise

    def sent(self, command: float, stamp: int) -> None:
        """Note a command (A or m) that was sent at `stamp`, ns."""
        self._builder.sent(command, self._seconds(stamp))
        self._write_message(self._command, command, stamp)

    def received(self, column: str, value: float, stamp: int) -> None:
        """Note an output of the positioner as it was at `stamp`, ns."""
        self._write_message(column, value, stamp)
        self._add(self._builder.received(column, value, self._seconds(stamp)))

    def close(self) -> None:
        """Complete the files and give them their names."""
        with ExitStack() as writers:  # each is closed, even if another one fails
            if self._bag is not None:
                writers.callback(self._bag.close)
            if self._csv is not None:
                writers.callback(self._csv.close)
                writers.callback(self._write_rows)
            self._add(self._builder.rest())

    def close_early(self) -> None:
        """
        Complete the files as far as they got, without replacing any that is there.

        The CSV then takes the name that `CsvWriter.spare` says; without any row nothing is left.
        """
        self._add(self._builder.rest())
        if not self.rows:
            self.discard()
            return
        if self._csv is not None:
            self._csv.spare()
        self.close()

    @property
    def paths(self) -> list[Path]:
        """Where the files are once they are complete."""
        return [writer.path for writer in (self._csv, self._bag) if writer is not None]

    def discard(self) -> None:
        """Remove what was written."""
        for writer in (self._csv, self._bag):
            if writer is not None:
                writer.discard()

    def _seconds(self, stamp: int) -> float:
        return (stamp - self.start) * _NANOSECONDS

    def _add(self, rows: list[Row]) -> None:
        self.rows += len(rows)
        if self._csv is None:
            return
        self._waiting += rows
        if len(self._waiting) >= _ROWS_AT_ONCE:
            self._write_rows()

    def _write_rows(self) -> None:
        assert self._csv is not None
        self._csv.write_rows(np.array(self._waiting).reshape(-1, len(Row._fields)))
        self._waiting.clear()

    def _write_message(self, column: str, value: float, stamp: int) -> None:
        if self._bag is not None:
            self._bag.write(self._topics[column], value, stamp)
