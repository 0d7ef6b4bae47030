# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Make raw columns usable, and say what was done.

Every function takes the columns and the row numbers and returns what it changed or found; nothing
is filled in that was not measured, except that a command holds until the next one.
"""

from collections.abc import Collection, Iterator

import numpy as np

from booster_ros.records.clock import check_clock
from booster_ros.records.dropouts import dropouts, sentinels
from booster_ros.records.holding import held
from booster_ros.records.record import COMMANDS, Array, Defect, Record, RecordError
from booster_ros.records.remarks import below_atmosphere, resolution, start
from booster_ros.records.time_axis import gap_rows
from booster_ros.records.units import check_above_vacuum, check_pressure_scale

_UNEVEN_RATIO = 1.5
_LISTED_RUNS = 8
_EPOCH_SECONDS = 1e8
_WITHOUT_PEAKS = (
    'back_pressure', 'supply_pressure', 'chamber_pressure', 'valve_position', 'pressure_drop')
_FEWEST_ROWS = 200
_MOST_REPEATED = 0.9  # a row for each channel repeats five of six stamps
_WILD, _NOISY, _ALIKE = 0.3, 15.0, 10.0
_USUAL, _USUALLY, _STRAIGHT = 4.0, 0.98, 0.01

Columns = dict[str, Array]


def clean(
    columns: Columns, rows: Array, source: str, defects: tuple[Defect, ...] = (),
    stated: Collection[str] = (),
) -> Record:
    """
    Return the record with its defects handled; RecordError where one cannot be.

    Columns whose unit was `stated` may be as small as they are.
    """
    found = list(defects)
    columns, dropped = drop_empty_columns(columns, rows, source)
    found += dropped
    for name, values in columns.items():
        if name not in stated:
            check_pressure_scale(name, values, rows, source)
    if 'time' in columns:
        columns, rows, mended = _clean_time(columns, rows, source)
        # those whose only values were in rows without a time
        columns, dropped = drop_empty_columns(columns, rows, source)
        found += mended + dropped
    for name in COMMANDS:
        found += hold_command(name, columns, rows)
    for name in columns:
        found += missing_runs(name, columns[name], rows)
        for drop in (drop_wild_values, drop_unread):
            columns[name], dropped = drop(name, columns, rows)
            found += dropped
        check_above_vacuum(name, columns[name], rows, source)
        found += resolution(name, columns[name])
        found += below_atmosphere(name, columns[name])
    found += start(columns, rows)
    for values in (*columns.values(), rows):
        values.flags.writeable = False
    return Record(columns, source, tuple(found), rows)


def drop_empty_columns(
    columns: Columns, rows: Array, source: str
) -> tuple[Columns, list[Defect]]:
    """Leave out the columns without a single value."""
    empty = [name for name, values in columns.items() if np.isnan(values).all()]
    kept = {name: values for name, values in columns.items() if name not in empty}
    if not set(columns) - {'time'}:
        raise RecordError(f'{source}: has no column beside time')
    if not set(kept) - {'time'}:
        raise RecordError(f'{source}: column {empty[0]} has no value, and no other column is left')
    if 'time' in empty:
        raise RecordError(f'{source}: column time has no value')
    first, last, count = int(rows[0]), int(rows[-1]), len(rows)
    text = 'no value at all, left out'
    return kept, [Defect('empty_column', name, first, last, count, text) for name in empty]


def _clean_time(
    columns: Columns, rows: Array, source: str
) -> tuple[Columns, Array, list[Defect]]:
    columns, rows, found = _drop_rows_without_time(columns, rows, source)
    check_clock(columns['time'], rows, source)
    for mend in (_drop_duplicated_stamps, _start_near_zero):
        columns, rows, mended = mend(columns, rows, source)
        found += mended
    found += gaps(columns['time'], rows)
    found += uneven_sampling(columns['time'])
    return columns, rows, found


def _drop_rows_without_time(
    columns: Columns, rows: Array, source: str
) -> tuple[Columns, Array, list[Defect]]:
    missing = np.isnan(columns['time'])
    found = _listed('missing_time', 'time', missing, rows, 'row', 'without a time, dropped')
    return _select(columns, ~missing), rows[~missing], found


def _drop_duplicated_stamps(
    columns: Columns, rows: Array, source: str
) -> tuple[Columns, Array, list[Defect]]:
    """
    Keep the last of rows with one stamp: it was the newest when the next stamp came.

    Values that it lacks are taken from the others: one stamp may have a row for each channel.
    """
    steps = np.diff(columns['time'])
    repeated = np.append(steps == 0.0, False)
    if len(rows) > 1 and repeated[:-1].all():
        raise RecordError(f'{source}, row {rows[1]}, column time: stands still in all rows')
    if not repeated.any():
        return columns, rows, []
    if np.mean(repeated) > _MOST_REPEATED:
        raise RecordError(
            f'{source}, column time: has {np.count_nonzero(~repeated)} stamps in {len(rows)} rows: '
            'write it with more digits')
    begins = np.append(True, steps > 0.0)
    since = np.flatnonzero(begins)[np.cumsum(begins) - 1]
    merged = {name: held(values, since) for name, values in columns.items()}
    text = 'repeated in the next row, dropped but for what that one lacks'
    found = _listed('duplicated_stamp', 'time', repeated, rows, 'stamp', text)
    return _select(merged, ~repeated), rows[~repeated], found


def _start_near_zero(
    columns: Columns, rows: Array, source: str
) -> tuple[Columns, Array, list[Defect]]:
    """Count a calendar time from the first row: 64 bits resolve it to less than a microsecond."""
    start = columns['time'][0]
    if abs(start) < _EPOCH_SECONDS:
        return columns, rows, []
    row = int(rows[0])
    shifted = Defect('calendar_time', 'time', row, row, 1, f'time counted from {start:.6f} s')
    return {**columns, 'time': columns['time'] - start}, rows, [shifted]


def gaps(time: Array, rows: Array) -> list[Defect]:
    """Find the gaps in time."""
    after = gap_rows(time)
    if after.size > _LISTED_RUNS:
        total = float(np.sum(time[after] - time[after - 1]))
        text = f'{after.size} gaps in time, {total:.4g} s together, left open'
        first, last = int(rows[after[0] - 1]), int(rows[after[-1]])
        return [Defect('gap', 'time', first, last, after.size, text)]
    return [
        Defect(
            'gap', 'time', int(rows[row - 1]), int(rows[row]), 1,
            f'a gap of {time[row] - time[row - 1]:.4g} s, left open',
        )
        for row in after
    ]


def uneven_sampling(time: Array) -> list[Defect]:
    """Say how uneven the sampling is, apart from the gaps."""
    steps = np.diff(time)
    if steps.size < 10:
        return []
    low, middle, high = np.percentile(steps, [5.0, 50.0, 95.0])
    if high < _UNEVEN_RATIO * low:
        return []
    text = (
        f'sampled unevenly, every {middle:.4g} s in the median, {low:.4g} to {high:.4g} s in 90 % '
        'of the rows; used as it is'
    )
    return [Defect('uneven_sampling', 'time', 0, 0, steps.size, text)]


def hold_command(name: str, columns: Columns, rows: Array) -> list[Defect]:
    """Fill missing commands with the one before, never across a gap: a command holds."""
    if name not in columns:
        return []
    values = columns[name]
    since = np.zeros(values.size, dtype=int)
    if 'time' in columns:
        after = gap_rows(columns['time'])
        since[after] = after
    columns[name] = held(values, np.maximum.accumulate(since))
    filled = np.isnan(values) & np.isfinite(columns[name])
    text = 'held from the row before'
    return _listed('missing_command', name, filled, rows, 'missing value', text)


def drop_unread(name: str, columns: Columns, rows: Array) -> tuple[Array, list[Defect]]:
    """Take out zeros and other numbers that say that a sensor was not read."""
    coded, zero = sentinels(name, columns[name]), dropouts(name, columns)
    noted = _listed('sentinel', name, coded, rows, 'value',
                    'that loggers write where there is none, not used')
    noted += _listed('dropout', name, zero, rows, 'zero', 'amid a pressure, not used: a dropout')
    return np.where(coded | zero, np.nan, columns[name]), noted


def drop_wild_values(name: str, columns: Columns, rows: Array) -> tuple[Array, list[Defect]]:
    """
    Take out values of a single row that no valve can have gone to and come back from.

    They are far from both neighbours, which are like each other. How far is judged by the range of
    the signal, its noise and its steps; where the command ran on straight, by noise, steps and
    what is usual. Where there are many such values they are the signal. A flow has such peaks, and
    rows without time need not be in any order: both are left as they are.
    """
    values = columns[name]
    if name not in _WITHOUT_PEAKS or 'time' not in columns or len(values) < _FEWEST_ROWS:
        return values, []
    away = _away(values)
    if not np.isfinite(away).any():
        return values, []
    known = values[np.isfinite(values)]
    noise = float(np.nanmedian(away))
    step = float(np.min(np.diff(np.unique(known)), initial=np.inf))
    noisy = _NOISY * (noise + step)
    far = max(_WILD * float(np.ptp(np.quantile(known, [0.001, 0.999]))), noisy)
    odd = max(noisy, _USUAL * float(np.nanquantile(away, _USUALLY)))
    limit = np.where(_runs_on(columns.get('control_current')), min(odd, far), far)
    wild = np.zeros(len(values), dtype=bool)
    wild[1:-1] = (away > limit) & (away > _ALIKE * np.abs(values[2:] - values[:-2]))
    if not 0 < wild.sum() <= max(1, len(values) // _FEWEST_ROWS):
        return values, []
    text = 'far from the rows before and after, not used'
    return np.where(wild, np.nan, values), _listed(
        'wild_value', name, wild, rows, 'value', text)


def _runs_on(current: Array | None) -> Array | bool:
    """Return for each row but the first and last whether the command ran straight through it."""
    if current is None:
        return False
    bend = _away(current)
    bend = np.maximum(bend, np.append(bend[:1], bend[:-1]))  # a valve answers a row later
    return bend <= _STRAIGHT * np.ptp(current[np.isfinite(current)])


def _away(values: Array) -> Array:
    """Return how far each row but the first and last is from the mean of its neighbours."""
    return np.abs(values[1:-1] - 0.5 * (values[:-2] + values[2:]))


def missing_runs(column: str, values: Array, rows: Array) -> list[Defect]:
    """Find the runs of missing values of a column."""
    text = 'neither filled nor compared'
    return _listed('missing_values', column, np.isnan(values), rows, 'missing value', text)


def _select(columns: Columns, keep: Array) -> Columns:
    return {name: values[keep] for name, values in columns.items()}


def _listed(
    kind: str, column: str, affected: Array, rows: Array, noun: str, text: str
) -> list[Defect]:
    """Return one defect for each run of affected rows, or one for all where there are many runs."""
    runs = list(_runs(affected))
    if len(runs) > _LISTED_RUNS:
        runs = [(runs[0][0], runs[-1][1])]
    return [
        Defect(kind, column, int(rows[first]), int(rows[last - 1]), count,
               f'{count} {noun}{"s" if count > 1 else ""} {text}')
        for first, last in runs
        if (count := int(affected[first:last].sum()))
    ]


def _runs(affected: Array) -> Iterator[tuple[int, int]]:
    """Yield first and one after the last index of each run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], affected, [False]]).astype(np.int8)))
    yield from zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
