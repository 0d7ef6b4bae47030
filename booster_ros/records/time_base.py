# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Put signals that were sampled at different times on one time base.

The time base is the stamps of one measured signal, so that its samples stay as they were. A command
holds until the next one; a row has the command that is in force in the middle between its stamp and
the next, so that commands come neither late nor early on average. Other measured signals are
interpolated linearly between two samples, never across a gap and never beyond their ends.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from booster_ros.records.record import MEASURED, Array, Defect
from booster_ros.records.time_axis import GAP_PERIODS


@dataclass(frozen=True)
class Signal:
    """Samples of one column: where they are from, their times (s, ascending) and their values."""

    source: str
    time: Array
    values: Array


def merge(signals: Mapping[str, Signal]) -> tuple[dict[str, Array], Array, list[Defect]]:
    """Return the columns on one time base, the row numbers, and how it was done."""
    reference = _reference(signals)
    time = signals[reference].time
    columns = {'time': time, reference: signals[reference].values}
    how = [f'on the {time.size} stamps of {signals[reference].source}']
    for name, signal in signals.items():
        if name == reference:
            continue
        if name == 'control_current':
            columns[name] = hold(signal, _middles(time))
            how.append(f'{name} holds until its next message')
        else:
            columns[name] = interpolate(signal, time)
            how.append(f'{name} is interpolated between messages')
    rows = np.arange(1, time.size + 1)
    defects = [Defect('time_base', '', 0, 0, time.size, ', '.join(how))]
    return *_from_first_command(columns, rows, defects), defects


def hold(signal: Signal, time: Array) -> Array:
    """Return the last value at or before each time, NaN before the first."""
    last = np.searchsorted(signal.time, time, side='right') - 1
    return np.where(last >= 0, signal.values[last], np.nan)


def interpolate(signal: Signal, time: Array) -> Array:
    """Return the values between two samples, NaN in gaps and outside."""
    values = np.interp(time, signal.time, signal.values, left=np.nan, right=np.nan)
    steps = np.diff(signal.time)
    if steps.size < 2:
        return values
    after = np.searchsorted(signal.time, time, side='left').clip(1, steps.size)
    is_sample = signal.time[after] == time
    is_gap = steps > GAP_PERIODS * np.median(steps)
    return np.where(is_gap[after - 1] & ~is_sample & (time > signal.time[0]), np.nan, values)


def _middles(time: Array) -> Array:
    """Return the middle between each time and the next, the last time as it is."""
    return np.append((time[:-1] + time[1:]) / 2.0, time[-1:])


def _reference(signals: Mapping[str, Signal]) -> str:
    """Return the measured signal with the most samples; the most downstream ones come first."""
    measured = [name for name in MEASURED if name in signals] or list(signals)
    return max(measured, key=lambda name: signals[name].time.size)


def _from_first_command(
    columns: dict[str, Array], rows: Array, defects: list[Defect]
) -> tuple[dict[str, Array], Array]:
    """Drop the rows before the first command: what drove the valve then is not in the bag."""
    if 'control_current' not in columns:
        return columns, rows
    unknown = np.isnan(columns['control_current'])
    first = int(unknown.argmin())
    if first == 0:
        return columns, rows
    text = f'{first} rows before the first message of control_current, dropped'
    defects.append(Defect('no_command_yet', 'control_current', 1, first, first, text))
    return {name: values[first:] for name, values in columns.items()}, rows[first:]
