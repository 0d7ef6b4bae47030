# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tables in Parquet and Feather files, read by pyarrow batch by batch."""

from __future__ import annotations

from collections.abc import Collection, Iterator
import importlib
from typing import Any

from booster_ros.records.guarded import MOST_COLUMNS
from booster_ros.records.mapping import Layout
from booster_ros.records.open_table import needs
from booster_ros.records.record import RecordError
from booster_ros.records.table import Portion, Table

PORTION = 200_000


def open_arrow(source: str, is_parquet: bool) -> Table:
    """Return the table in a Parquet (else Feather) file; RecordError where it is not readable."""
    try:
        arrow = importlib.import_module('pyarrow')
        parquet = importlib.import_module('pyarrow.parquet')
        importlib.import_module('pyarrow.feather')
    except ModuleNotFoundError:
        raise needs('pyarrow', source, 'reading Parquet and Feather files') from None
    try:
        if is_parquet:
            names = parquet.ParquetFile(source).schema_arrow.names
        else:
            names = _stream(arrow, source).schema.names
    except (OSError, ValueError, arrow.ArrowException) as error:
        raise _damaged(source, error) from None
    names = tuple(map(str, names))
    if len(names) > MOST_COLUMNS:
        raise RecordError(f'{source}: has more than {MOST_COLUMNS} columns, which no record has')
    blank = ('',) * len(names)

    def portions(texts: Collection[int], wanted: Collection[int]) -> Iterator[Portion]:
        row = 1
        places = sorted(wanted)
        try:
            for batch in _batches(arrow, parquet, source, is_parquet, [names[k] for k in places]):
                # what pandas has put beside a table for itself may be damaged, and hides columns
                frame = batch.replace_schema_metadata(None).to_pandas()
                frame.columns = places
                for place in set(texts) & set(places):
                    if frame[place].dtype.kind != 'M':
                        frame[place] = frame[place].astype('str').where(frame[place].notna())
                frame.index = range(row, row + len(frame))
                row += len(frame)
                yield Portion(frame.index.to_numpy(), frame)
        except (OSError, ValueError, arrow.ArrowException) as error:
            if isinstance(error, RecordError):
                raise
            raise _damaged(source, error) from None

    return Table(source, 'Parquet' if is_parquet else 'Feather', names, blank, blank, (), Layout(),
                 portions)


def _batches(arrow: Any, parquet: Any, source: str, is_parquet: bool, names: list[str]
             ) -> Iterator[Any]:
    if is_parquet:
        yield from parquet.ParquetFile(source).iter_batches(PORTION, columns=names)
        return
    reader = _stream(arrow, source)
    for number in range(reader.num_record_batches):
        yield reader.get_batch(number).select(names)


def _stream(arrow: Any, source: str) -> Any:
    return arrow.ipc.open_file(arrow.memory_map(source))


def _damaged(source: str, error: Exception) -> RecordError:
    return RecordError(f'{source}: is damaged ({" ".join(str(error).split())[:80]})')
