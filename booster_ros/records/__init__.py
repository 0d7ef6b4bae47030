# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Records of a positioner: CSV and rosbag2, read with their defects handled, and written."""

from collections.abc import Mapping
import os
from pathlib import Path

from booster_ros.records.cleaning import clean
from booster_ros.records.csv_file import (
    CsvWriter, csv_columns, csv_header_notes, first_row, iterate_csv, read_csv)
from booster_ros.records.mapping import FileMapping, read_mapping
from booster_ros.records.open_table import is_table
from booster_ros.records.record import COLUMNS, FURTHER, Defect, Record, RecordError, needs_rosbags
from booster_ros.records.target import check_inputs_stay

__all__ = [
    'COLUMNS', 'FURTHER', 'CsvWriter', 'Defect', 'FileMapping', 'Record', 'RecordError',
    'check_inputs_stay', 'csv_columns', 'csv_header_notes', 'first_row', 'is_bag', 'iterate_csv',
    'read_mapping', 'read_record',
]

_BAG_SUFFIXES = {'.mcap', '.db3'}


def is_bag(path: str | os.PathLike[str]) -> bool:
    """Tell whether a record is read as a bag: a folder, or a file with the suffix of one."""
    return Path(path).is_dir() or Path(path).suffix in _BAG_SUFFIXES


def read_record(
    path: str | os.PathLike[str],
    topics: Mapping[str, str] | None = None,
    stamps: str = 'bag',
    mapping: FileMapping | None = None,
    travel: float | None = None,
) -> Record:
    """
    Return the record in a CSV, in a rosbag2 folder (sqlite3 or mcap), or in what is mapped.

    `topics` maps columns to topics of a bag where the default mapping does not fit; `stamps` is
    'bag' for the time of recording or 'header' for the time in the messages. `mapping` says how a
    file of others is read, and `travel` (m) what per cent of travel are of. RecordError is one
    sentence.
    """
    if is_bag(path):
        # Reading CSV needs no rosbags.
        try:
            from booster_ros.records.bag_reader import read_bag
        except ModuleNotFoundError as missing:
            raise needs_rosbags(f'{path}: reading a bag', missing) from None
        return clean(*read_bag(path, topics, stamps, mapping))
    if mapping is not None or is_table(path):
        # nor does it need pandas and pint
        from booster_ros.records.own_names import mapping_of_own_names
        from booster_ros.records.mapped import read_mapped
        return read_mapped(path, mapping or mapping_of_own_names(path), travel)
    columns, rows, defects = read_csv(path)
    return clean(columns, rows, str(path), defects)
