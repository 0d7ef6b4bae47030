# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Tables in MATLAB files: vectors of equal length, whatever they lie in.

Files up to version 7 are read by scipy (`mat_file`), those of version 7.3, which are HDF5, by h5py.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping
import importlib
from typing import Any

import numpy as np

from booster_ros.records.guarded import MOST_COLUMNS, check_count
from booster_ros.records.mapping import Layout
from booster_ros.records.mat_file import arrays_in, damaged
from booster_ros.records.open_table import needs
from booster_ros.records.record import Array, RecordError
from booster_ros.records.table import Portion, Table


def open_mat(source: str, is_old: bool) -> Table:
    """Return the vectors in a MATLAB file as a table; RecordError where there are none."""
    found = arrays_in(source) if is_old else _hdf5(source)
    vectors = _as_vectors(found)
    lengths = Counter(len(values) for values in vectors.values() if len(values) > 1)
    if not lengths:
        raise RecordError(f'{source}: holds no vectors of numbers')
    length = max(lengths, key=lambda one: (lengths[one], one))
    names = tuple(name for name, values in vectors.items() if len(values) == length)[:MOST_COLUMNS]
    others = [f'{name} ({len(values)} values)' for name, values in vectors.items()
              if len(values) not in (length, 1)]
    blank = ('',) * len(names)

    def portions(texts: Collection[int], wanted: Collection[int]) -> Iterator[Portion]:
        import pandas as pd

        frame = pd.DataFrame({place: vectors[names[place]] for place in sorted(wanted)},
                             index=range(1, length + 1))
        for place in set(texts) & set(wanted):
            frame[place] = frame[place].astype('str')
        yield Portion(frame.index.to_numpy(), frame)

    told = (f'of another length, left out: {", ".join(others[:10])}',) if others else ()
    return Table(source, 'MATLAB', names, blank, blank, told, Layout(), portions)


def _hdf5(source: str) -> dict[str, Any]:
    try:
        h5py = importlib.import_module('h5py')
    except ModuleNotFoundError:
        raise needs('h5py', source, 'reading a MATLAB file of version 7.3, or HDF5,') from None
    found: dict[str, Any] = {}
    total = 0

    def take(name: str, item: Any) -> None:
        nonlocal total
        if isinstance(item, h5py.Dataset) and item.dtype.kind in 'iufb' and (
                not name.startswith('#')):
            total += item.size
            check_count(total, source)
            found[name.replace('/', '.')] = np.asarray(item[()])

    try:
        with h5py.File(source, 'r') as file:
            file.visititems(take)
    except RecordError:
        raise
    except (OSError, ValueError, RuntimeError, KeyError, TypeError) as error:
        raise damaged(source, error) from None
    return found


def _as_vectors(found: Mapping[str, Array]) -> dict[str, Array]:
    """Return vectors as they are, and the columns of a matrix as name(1), name(2) and so on."""
    vectors = {}
    for name, value in found.items():
        squeezed = np.squeeze(value)
        if squeezed.ndim == 1:
            vectors[name] = squeezed
        elif squeezed.ndim == 2:
            table = squeezed if squeezed.shape[0] >= squeezed.shape[1] else squeezed.T
            if table.shape[1] <= 100:
                vectors.update({f'{name}({k + 1})': table[:, k] for k in range(table.shape[1])})
    return vectors
