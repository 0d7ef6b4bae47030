# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Files for each reader, changed at random: read, or refused in one sentence."""

from __future__ import annotations

from contextlib import suppress
import functools
from pathlib import Path
import random

import numpy as np

from booster_ros.model.parameters import ParameterError, from_values
from booster_ros.parameters.file import parameter_text, read_parameter_file
from booster_ros.records import RecordError, iterate_csv, read_record
from booster_ros.records import csv_text
from booster_ros.records.bag_writer import BagWriter

from .folder import folder
from .mutation import mutated

COLUMNS = ('time', 'control_current', 'chamber_pressure', 'valve_position')
LINES = 300
PORTION = 997
"""Bytes of a portion, so that a file of these sizes has many."""


def _table() -> str:
    return ','.join(COLUMNS) + '\n' + ''.join(
        f'{0.01 * k:.2f},{4e-4 + 1e-7 * k:.9f},{150_000 + 100 * k},{2e-6 * k:.6f}\n'
        for k in range(LINES))


def csv(rng: random.Random) -> None:
    """Read a table whole and in portions: the same comes of both."""
    text = _table()
    if rng.random() < 0.3:
        text = text.replace(',', ';').replace('.', rng.choice(',.'))
    with folder() as place:
        path = place / 'record.csv'
        path.write_bytes(mutated(text.encode(), rng))
        with suppress(RecordError):
            read_record(path)
        large, small = _iterated(path, csv_text._BLOCK_BYTES), _iterated(path, PORTION)
        assert type(large) is type(small), (large, small)
        if isinstance(large, np.ndarray):  # of several things that are wrong either may be said
            np.testing.assert_array_equal(large, small)


def _iterated(path: Path, block: int) -> np.ndarray | str:
    """Return the rows of a table read in blocks of so many bytes, or why it is refused."""
    before = csv_text._BLOCK_BYTES
    csv_text._BLOCK_BYTES = block
    try:
        chunks = list(iterate_csv(path, COLUMNS[:2]))
        return np.concatenate([np.column_stack([one.rows, one.values]) for one in chunks])
    except RecordError as error:
        return str(error)
    finally:
        csv_text._BLOCK_BYTES = before


@functools.cache
def _bag_files(storage: str) -> dict[str, bytes]:
    """Return the files of a good bag by name."""
    with folder() as place:
        with BagWriter(place / 'bag', [f'/{name}' for name in COLUMNS[1:]], storage) as bag:
            for tick in range(60):
                for name in COLUMNS[1:]:
                    bag.write(f'/{name}', 1e-4 * tick, 10**18 + tick * 10**7)
        return {path.name: path.read_bytes() for path in (place / 'bag').iterdir()}


def bag(rng: random.Random) -> None:
    """Read a bag of which one file has been changed."""
    files = dict(_bag_files(rng.choice(('mcap', 'sqlite3'))))
    name = rng.choice(sorted(files))
    files[name] = mutated(files[name], rng)
    with folder() as place:
        for name, data in files.items():
            (place / name).write_bytes(data)
        with suppress(RecordError):
            read_record(place)


@functools.cache
def _parameter_text() -> bytes:
    return parameter_text(from_values({'actuator.coulomb_friction': 20.0}), 'a model', {},
                          {'publish_rate': 50.0, 'current_limits': (0.0, 2e-3)}).encode()


def parameter_file(rng: random.Random) -> None:
    """Read a parameter file that has been changed; what is read has a model."""
    with folder() as place:
        path = place / 'p.yaml'
        path.write_bytes(mutated(_parameter_text(), rng))
        try:
            from_values(read_parameter_file(path).physical)
        except ParameterError as error:
            if '\n' in str(error):
                raise AssertionError(f'several lines: {error}') from error
