# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The time of the rows of a mapped table: numbers of any unit, or text in one or two columns."""

from __future__ import annotations

from typing import Any
import zoneinfo

import numpy as np

from booster_ros.records.conversion import conversion, parsed_unit, units_for
from booster_ros.records.mapping import ASKED, TimeMapping
from booster_ros.records.record import Array, Defect, RecordError
from booster_ros.records.time_format import ISO, formats_of, has_date

DAY = 86400.0
_CALENDAR = 1e8


class TimeColumn:
    """Collects the times of portions; `seconds` has them counted from the first one."""

    def __init__(self, mapping: TimeMapping, numeric: bool, where: str):
        self._mapping = mapping
        self._where = where
        self._numeric = numeric
        self._parts: list[Array] = []
        self._form = mapping.format
        if ASKED in (mapping.format, mapping.unit, mapping.zone):
            raise self._asked()
        if mapping.zone:
            check_zone(mapping.zone, where)
        if numeric:
            self._unit = self._conversion()

    def add(self, values: Any, rows: Array) -> None:
        """Take the times of a portion: a pandas series of numbers, of text or of dates."""
        if self._numeric:
            self._parts.append(self._numbers(values, rows))
        elif getattr(values.dtype, 'kind', 'O') == 'M':
            self._parts.append(self._nanoseconds(values, values, rows))
        else:
            self._parts.append(self._texts(values, rows))

    def seconds(self) -> tuple[Array, list[Defect]]:
        """Return the times, s, NaN where missing, and what was done."""
        raw = np.concatenate(self._parts) if self._parts else np.empty(0)
        if self._numeric:
            return self._seconds_of_numbers(raw), []
        known = raw != _NOT_A_TIME
        begin = int(raw[known][0]) if known.any() else 0
        time = np.where(known, (raw - begin) / 1e9, np.nan)
        defects: list[Defect] = []
        if self._mapping.zone and known.any() and has_date(self._form or ISO):
            time, defects = _in_zone(raw, known, begin, self._mapping.zone)
        elif not has_date(self._form or ISO):
            time = over_midnight(time)
        return time, defects

    def _seconds_of_numbers(self, raw: Array) -> Array:
        unit = self._unit
        known = np.isfinite(raw) if raw.dtype.kind == 'f' else np.ones(len(raw), dtype=bool)
        begin: Any = raw[known][0] if known.any() else 0
        shift = begin if abs(float(begin)) * unit.factor / unit.divisor > _CALENDAR else 0
        return np.asarray(unit.of((raw - shift).astype(float)))

    def _conversion(self) -> Any:
        if self._mapping.unit is None:
            raise self._asked()
        unit = parsed_unit(self._mapping.unit)
        if unit is None:
            raise RecordError(f'{self._where}: {self._mapping.unit[:40]!r} is no unit of time; '
                              f'there are {", ".join(units_for("time"))} and more')
        return conversion(unit, 'time', self._where)

    def _asked(self) -> RecordError:
        if self._mapping.format == ASKED:
            return RecordError(f'{self._where}.format: day and month could be either way round; '
                               'write the format, as in "%d/%m/%Y %H:%M:%S"')
        if self._mapping.zone == ASKED:
            return RecordError(f'{self._where}.zone: the clock on the wall was changed by an '
                               'hour; say in which zone it hung, as in Europe/Berlin')
        return RecordError(f'{self._where}.unit: the unit of the time is not known; it is one of '
                           f'{", ".join(units_for("time"))}')

    def _numbers(self, values: Any, rows: Array) -> Array:
        import pandas as pd

        if values.dtype.kind in 'iu':
            return np.asarray(values)
        if values.dtype.kind == 'f':
            return np.asarray(values, dtype=float)
        text = values.astype('str').str.strip()
        numbers = pd.to_numeric(text, errors='coerce')
        odd = np.flatnonzero((numbers.isna() & values.notna() & (text != '')).to_numpy())
        if odd.size:
            raise self._odd(text.iloc[int(odd[0])], rows[odd[0]])
        return np.asarray(numbers, dtype=float)

    def _texts(self, values: Any, rows: Array) -> Array:
        import pandas as pd

        text = values.astype('str').str.strip().where(values.notna())
        if self._form is None:
            self._form = self._found(text)
        zoned = self._form == ISO or '%z' in self._form
        try:
            moments = pd.to_datetime(
                text, format='ISO8601' if self._form == ISO else self._form, errors='coerce',
                utc=zoned)
        except (ValueError, TypeError, OverflowError) as error:
            raise RecordError(f'{self._where}.format: {str(error)[:120]}') from None
        odd = np.flatnonzero((moments.isna() & text.notna() & (text != '')).to_numpy())
        if odd.size:
            raise self._odd(text.iloc[int(odd[0])], rows[odd[0]])
        return self._nanoseconds(moments, text, rows)

    def _nanoseconds(self, moments: Any, shown: Any, rows: Array) -> Array:
        """Return times as whole nanoseconds of a clock without a zone, the least for none."""
        import pandas as pd

        index = pd.DatetimeIndex(moments)
        if index.tz is not None:
            index = index.tz_convert('UTC').tz_localize(None)
        years = index.year
        far = np.flatnonzero((years < _YEARS[0]) | (years > _YEARS[1]))
        if far.size:
            raise RecordError(f'{self._where}, row {rows[far[0]]}: the time '
                              f'{str(shown.iloc[int(far[0])])[:40]!r} is not within the years '
                              f'{_YEARS[0]} to {_YEARS[1]}')
        return np.asarray(index.as_unit('ns').asi8)

    def _found(self, text: Any) -> str:
        sample = list(text.dropna().iloc[:200])
        formats = formats_of(sample)
        if len(formats) > 1:
            raise RecordError(f'{self._where}: {sample[0]!r} is {" or ".join(formats[:3])}; write '
                              'which as the format in the mapping')
        if not formats:
            raise RecordError(f'{self._where}: {str(sample[:1])[1:-1]} is in no format that is '
                              'known; write it as the format in the mapping, as in '
                              '"%d.%m.%Y %H:%M:%S"')
        return formats[0]

    def _odd(self, text: str, row: int) -> RecordError:
        how = f'in the format {self._form}' if self._form else 'a number'
        return RecordError(f'{self._where}, row {row}: the time {text[:40]!r} is not {how}')


_NOT_A_TIME = np.iinfo(np.int64).min

_YEARS = (1680, 2260)
"""First and last year whose nanoseconds from 1970 on fit into 64 bits."""


def over_midnight(time: Array) -> Array:
    """Return the times of a day, s, running on where midnight passed."""
    known = np.isfinite(time)
    steps = np.diff(time[known], prepend=time[known][:1])
    running = time.copy()
    running[known] += DAY * np.cumsum(steps < -0.5 * DAY)
    return running


def _in_zone(raw: Array, known: Array, begin: int, zone: str
             ) -> tuple[Array, list[Defect]]:
    """Return seconds from the first of the times that a clock on a wall of this zone showed."""
    import pandas as pd

    wall = pd.DatetimeIndex(raw[known].astype('datetime64[ns]'))
    # in the hour that comes twice, summer time ends where the clock jumps back
    back = np.diff(raw[known], prepend=raw[known][:1])
    falling = bool(np.mean(back < 0) > 0.5)
    jumped = np.cumsum((back > 0) if falling else (back < 0)) > 0
    summer = jumped if falling else ~jumped
    moments = wall.tz_localize(zone, ambiguous=summer, nonexistent='shift_forward')
    at = moments.tz_convert('UTC').tz_localize(None).as_unit('ns').asi8
    time = np.full(len(raw), np.nan)
    time[known] = (at - at[0]) / 1e9
    shown = (raw[known] - begin) / 1e9
    moved = np.flatnonzero(np.abs(np.diff(time[known] - shown)) > 1.0)
    if not moved.size:
        return time, []
    return time, [Defect('clock_change', 'time', 0, 0, len(moved),
                         f'the clock was changed {len(moved)} times in {zone}; time runs on')]


def check_zone(zone: str, where: str) -> None:
    """Raise RecordError where there is no such zone."""
    try:
        zoneinfo.ZoneInfo(zone)
    except (KeyError, ValueError, OSError):
        raise RecordError(f'{where}.zone: there is no zone {zone[:40]!r}; they are called as in '
                          'Europe/Berlin or Asia/Taipei') from None
