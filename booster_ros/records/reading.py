# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""From the numbers of a mapped column to SI units and gauge pressures, with a note on each step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from booster_ros.records.conversion import (
    Conversion, Unit, conversion, gauge_offset, parsed_unit, quantity, si_units, units_for)
from booster_ros.records.mapping import ASKED, TRAVEL, ColumnMapping
from booster_ros.records.record import COLUMNS, Array, Defect, RecordError
from booster_ros.records.unit_in_name import named, normalised

HALF_VACUUM = 50e3
"""Pa. A pressure that falls below this is gauge pressure: no absolute one in a valve does."""

_PERCENT_OF_TRAVEL = ('valve_position', 'set_point', 'process_set_point')
AS_THEY_ARE = ('pressure_drop', 'process_value', 'process_set_point')
"""Pressures that are differences, or of the process: gauge or absolute, they stay so."""

_SHOWN = {'': '1'}


@dataclass(frozen=True)
class Reading:
    """How a column is read: conversion, whether its pressure is gauge (None: judged), and notes."""

    column: str
    conversion: Conversion
    gauge: bool | None
    is_pressure: bool
    where: str
    notes: tuple[str, ...]

    def of(self, values: Array) -> tuple[Array, list[Defect]]:
        """Return values in SI units, gauge; RecordError where nothing tells gauge from absolute."""
        found = self.conversion.of(values)
        notes = list(self.notes)
        if self.is_pressure and self.column not in AS_THEY_ARE:
            gauge = self.gauge
            if gauge is None:
                gauge = judged_gauge(found)
                if gauge is None:
                    least = float(np.nanmin(found)) if np.isfinite(found).any() else 0.0
                    raise RecordError(
                        f'{self.where}.gauge: never falls below {least:.4g} Pa, and may be gauge '
                        'or absolute pressure; say gauge: true or gauge: false, or a unit such as '
                        'kPag or kPaa')
                notes.append('falls below 50 kPa, so it is gauge pressure')
            if not gauge:
                notes.append('absolute pressure, 101325 Pa taken off')
            found = found + gauge_offset(gauge)
        return found, [Defect('converted', self.column, 0, 0, len(found), note) for note in notes]


def judged_gauge(pressure: Array) -> bool | None:
    """Return True where a pressure, Pa, can only be gauge pressure, None where it may be either."""
    known = pressure[np.isfinite(pressure)]
    return True if known.size and np.quantile(known, 0.01) < HALF_VACUUM else None


def reading(
    column: str, mapping: ColumnMapping, name: str, unit_row: str, travel: float | None,
    where: str,
) -> Reading:
    """
    Return how a column is read.

    `name` is that in the file, `unit_row` what stands below it, `travel` that of the stem, m, where
    it is known. RecordError asks for what neither the mapping nor the file says.
    """
    if mapping.gauge == ASKED:
        raise RecordError(f'{where}.gauge: say gauge: true or gauge: false (absolute pressure)')
    own = normalised(named(name).name) == column
    unit, origin = _unit(column, mapping, name, unit_row, own, where)
    gauge = unit.gauge if mapping.gauge is None else bool(mapping.gauge)
    if unit.gauge is not None and mapping.gauge is not None and unit.gauge != mapping.gauge:
        raise RecordError(f'{where}: the unit {unit.written} and gauge: '
                          f'{str(mapping.gauge).lower()} contradict each other')
    if gauge is None and own:
        gauge = True  # as all pressures of a record
    if unit.pint.check('[]') and si_units(column) not in ((), ('Pa',)):
        low, high, text = _range(column, mapping.of, travel, where)
        share = float(unit.pint.to('dimensionless').magnitude)
        target = next(one for one in si_units(column) if one != 'Pa')
        divisor = round(1.0 / share) if share < 1.0 else 1.0
        scale = Conversion((high - low) * (1.0 if share < 1.0 else share), divisor, low, target)
        notes: tuple[str, ...] = (f'read from {name!r}, {unit.written} of {text}',)
        return Reading(column, scale, None, False, where, notes)
    scale = conversion(unit, column, where)
    shown = _SHOWN.get(scale.target, scale.target)
    changed = scale[:3] != (1.0, 1.0, 0.0)
    notes = ()
    if changed:
        notes = (f'read from {name!r}, converted from {unit.written} to {shown}{origin}',)
    elif name.strip() != column:
        notes = (f'read from {name!r}, in {shown}{origin}',)
    return Reading(column, scale, gauge, unit.is_pressure, where, notes)


def _unit(column: str, mapping: ColumnMapping, name: str, unit_row: str, own: bool, where: str
          ) -> tuple[Unit, str]:
    """Return the unit of a column, and where it is from if not from the mapping."""
    if mapping.unit is not None and mapping.unit != ASKED:
        unit = parsed_unit(mapping.unit)
        if unit is None:
            raise RecordError(f'{where}.unit: {mapping.unit[:40]!r} is no unit that is known; '
                              f'usual ones are {_either(units_for(column))}')
        return unit, ''
    if mapping.unit != ASKED:
        for text, origin in ((named(name).unit, ''), (unit_row.strip('[](){} '), '')):
            unit = parsed_unit(text)
            if unit is not None:
                return unit, origin
        if own and column in COLUMNS:
            unit = parsed_unit(COLUMNS[column].unit)
            assert unit is not None
            return unit, ''
    raise RecordError(f'{where}.unit: the unit of {name!r} is not known; say unit: '
                      f'{_either(units_for(column))}')


def _range(column: str, of: object, travel: float | None, where: str) -> tuple[float, float, str]:
    """Return what 0 and 100 % are, in the column's unit, and what they are called."""
    target = next(one for one in si_units(column) if one != 'Pa')
    if isinstance(of, Sequence) and not isinstance(of, str) and len(of) == 2:
        low, high = (quantity(end, target, f'{where}.of') for end in of)
        return low, high, f'{of[0]} to {of[1]}'
    if of not in (None, TRAVEL, ASKED):
        return 0.0, quantity(of, target, f'{where}.of'), str(of)
    if column in _PERCENT_OF_TRAVEL:
        if travel is None:
            raise RecordError(f'{where}.of: is in per cent of the travel, which is not known; say '
                              'travel: 20 mm, or what it is')
        return 0.0, travel, f'the travel of {travel:.4g} m'
    usual = '[4 mA, 20 mA]' if column == 'control_current' else f'1 {target}'
    raise RecordError(f'{where}.of: is a share, of what is not known; say of: {usual}, or what it '
                      'is')


def _either(units: Sequence[str]) -> str:
    return f'{", ".join(units[:-1])} or {units[-1]}' if len(units) > 1 else units[0]
