# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Files of others, changed at random: inspected and read as that says, or refused."""

from __future__ import annotations

from contextlib import suppress
import functools
import gzip
import io
import json
import random
import zipfile

import numpy as np
import pandas as pd

from booster_ros.records import RecordError
from booster_ros.records.inspection import inspect
from booster_ros.records.mapped import Runs
from booster_ros.records.mapping import read_mapping
from booster_ros.records.mapping_text import mapping_text

from .folder import folder
from .mutation import mutated

ROWS = 80
TRAVEL = 0.016
"""Of the stem, m."""


@functools.cache
def _frame() -> pd.DataFrame:
    rows = np.arange(ROWS)
    return pd.DataFrame({
        'Timestamp': pd.Timestamp('2026-03-01') + pd.to_timedelta(0.5 * rows, 's'),
        'Set point [%]': np.where(rows < 40, 20.0, 70.0),
        'P act (kPag)': 120.0 + rows,
        'valve_position': 1e-4 * rows})


def _text(separator: str, decimal: str) -> bytes:
    head = f'Logger 7{separator}\nSite{separator}Boiler 2\n\n'
    return (head + _frame().to_csv(sep=separator, decimal=decimal, index=False)).encode()


def _long() -> bytes:
    frame = _frame().astype({'Timestamp': str}).melt('Timestamp', var_name='Tag',
                                                     value_name='Value')
    return frame.to_csv(index=False).encode()


def _lines() -> bytes:
    return _frame().astype({'Timestamp': str}).to_json(orient='records', lines=True).encode()


def _workbook() -> bytes:
    out = io.BytesIO()
    _frame().to_excel(out, index=False)
    return out.getvalue()


def _matlab() -> bytes:
    from scipy.io import savemat

    out = io.BytesIO()
    frame = _frame()
    savemat(out, {'run': {'t': 0.5 * np.arange(ROWS), 'pressure': frame['P act (kPag)'].to_numpy(),
                          'valve_position': frame['valve_position'].to_numpy()}})
    return out.getvalue()


def _hdf5() -> bytes:
    import h5py

    out = io.BytesIO()
    with h5py.File(out, 'w') as file:
        file['run/t'] = 0.5 * np.arange(ROWS)
        file['run/valve_position'] = _frame()['valve_position'].to_numpy()
    return out.getvalue()


def _arrow(name: str) -> bytes:
    out = io.BytesIO()
    getattr(_frame(), f'to_{name}')(out)
    return out.getvalue()


@functools.cache
def _files() -> dict[str, bytes]:
    """Return a good file of each format by its name."""
    return {
        'log.csv': _text(',', '.'),
        'german.csv': _text(';', ','),
        'long.csv': _long(),
        'log.jsonl': _lines(),
        'log.csv.gz': gzip.compress(_text('\t', '.'), mtime=0),
        'log.xlsx': _workbook(),
        'log.mat': _matlab(),
        'new.mat': _hdf5(),
        'log.parquet': _arrow('parquet'),
        'log.feather': _arrow('feather'),
    }


def run(rng: random.Random) -> None:
    """Inspect a file that has been changed; read it as the mapping says, which may be changed."""
    name = rng.choice(sorted(_files()))
    with folder() as place:
        path, mapping = place / name, place / 'm.yaml'
        path.write_bytes(_changed(_files()[name], rng))
        with suppress(RecordError):
            text = mapping_text(inspect(path), name).encode()
            mapping.write_bytes(mutated(text, rng) if rng.random() < 0.3 else text)
            runs = Runs(path, read_mapping(mapping), TRAVEL)
            for number in range(1, len(runs) + 1):
                runs.record(number)


def _changed(data: bytes, rng: random.Random) -> bytes:
    """Return a file changed; of an archive one member, so that more than its sum is looked at."""
    if rng.random() < 0.3:
        return mutated(data, rng)
    if data.startswith(b'PK'):
        return _with_changed_member(data, rng)
    if data.startswith(b'\x1f\x8b'):
        return gzip.compress(mutated(gzip.decompress(data), rng), mtime=0)
    return mutated(data, rng)


def _with_changed_member(data: bytes, rng: random.Random) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(data)) as before, zipfile.ZipFile(out, 'w') as after:
        names = before.namelist()
        chosen = rng.choice(names)
        for name in names:
            content = before.read(name)
            after.writestr(name, mutated(content, rng) if name == chosen else content)
    return out.getvalue()


def mapping_file(rng: random.Random) -> None:
    """Read a mapping that has been changed."""
    with folder() as place:
        path = place / 'm.yaml'
        path.write_bytes(mutated(_mapping(), rng))
        with suppress(RecordError):
            read_mapping(path)


@functools.cache
def _mapping() -> bytes:
    return json.dumps({
        'time': {'columns': ['date', 'time'], 'format': '%Y-%m-%d %H:%M:%S',
                 'zone': 'Asia/Taipei'},
        'columns': {'set_point': {'from': 'FV_211', 'unit': '%', 'of': 'travel'},
                    'chamber_pressure': {'from': 'P act', 'unit': 'psi', 'gauge': True}},
        'missing': [-9999, 'NULL'], 'quality': {'column': 'Q', 'good': ['Good', 192]},
        'travel': '16 mm', 'held': ['set_point'], 'run': 1}, indent=1).encode()
