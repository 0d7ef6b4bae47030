# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Convert the units that people write into SI units, by pint.

Pint is loaded when a unit is to be converted, which canonical records never ask for.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
import importlib
import math
import re
from typing import Any, NamedTuple

from booster_ros.model.gas import ATMOSPHERE
from booster_ros.records.record import COLUMNS, Array, RecordError

LONGEST_UNIT = 40
"""Characters of the longest text that is looked at as a unit."""

_SPELLINGS = {
    'a': 'ampere', 'amp': 'ampere', 'amps': 'ampere', 'ma': 'milliampere', 'ua': 'microampere',
    'µa': 'microampere', 'pa': 'pascal', 'hpa': 'hectopascal', 'kpa': 'kilopascal',
    'mpa': 'megapascal', 'bar': 'bar', 'mbar': 'millibar', 'psi': 'psi', 'atm': 'atmosphere',
    'torr': 'torr', 'mmhg': 'mmHg', 'inhg': 'inHg', 'cmh2o': 'cmH2O', 'mmh2o': '0.1 cmH2O',
    'inh2o': 'inH2O', 'inwc': 'inH2O', 'kgf/cm2': 'kgf/cm**2', 'kgf/cm²': 'kgf/cm**2',
    'kg/cm2': 'kgf/cm**2', 'kg/cm²': 'kgf/cm**2', '%': 'percent', 'pct': 'percent',
    'percent': 'percent', 'prozent': 'percent', '1': 'dimensionless', '-': 'dimensionless',
    'mm': 'millimeter', 'cm': 'centimeter', 'um': 'micrometer', 'µm': 'micrometer',
    'in': 'inch', 'inch': 'inch', '"': 'inch', 's': 'second', 'sec': 'second',
    'secs': 'second', 'seconds': 'second', 'ms': 'millisecond', 'msec': 'millisecond',
    'millis': 'millisecond', 'us': 'microsecond', 'µs': 'microsecond', 'usec': 'microsecond',
    'micros': 'microsecond', 'ns': 'nanosecond', 'nsec': 'nanosecond', 'min': 'minute',
    'h': 'hour', 'hr': 'hour', 'd': 'day', 'kg/s': 'kg/s', 'g/s': 'g/s', 'kg/h': 'kg/hour',
    'g/min': 'g/min', 'kg/min': 'kg/min', '°c': 'degC', 'degc': 'degC', 'm': 'meter',
}
"""Spellings of units in small letters, and pint's name for each."""

_MARKED = re.compile(r'(.*?)\s*[(_]?(abs|gauge|[ag])\)?\.?$', re.IGNORECASE)
_PRESSURE = '[mass] / [length] / [time] ** 2'


class Unit(NamedTuple):
    """A unit as it was written, pint's, and whether it says gauge (True) or absolute (False)."""

    written: str
    pint: Any
    gauge: bool | None

    @property
    def is_pressure(self) -> bool:
        """Tell whether it is a unit of pressure."""
        return bool(self.pint.check(_PRESSURE))


class Conversion(NamedTuple):
    """`values * factor / divisor + offset` are in the SI unit `target`."""

    factor: float
    divisor: float
    offset: float
    target: str

    def of(self, values: Array) -> Array:
        """Return values in the SI unit."""
        return values * self.factor / self.divisor + self.offset


@lru_cache(maxsize=1)
def _registry() -> Any:
    # not among the packages that ROS knows, and reading canonical records needs none
    try:
        return importlib.import_module('pint').UnitRegistry()
    except ModuleNotFoundError as missing:
        raise RecordError(f'converting a unit needs the Python package {missing.name}, which is '
                          'not installed: pip install pint') from None


@lru_cache(maxsize=1024)
def parsed_unit(text: str) -> Unit | None:
    """Return the unit that a text is, None where it is none; upper and lower case may be mixed."""
    written = text.strip()
    if not written or len(written) > LONGEST_UNIT:
        return None
    found = _quantity(written)
    if found is not None:
        return Unit(written, found, None)
    marked = _MARKED.fullmatch(written)
    if marked is None:
        return None
    found = _quantity(marked[1])
    if found is None or not found.check(_PRESSURE):
        return None
    return Unit(written, found, marked[2].lower().startswith('g'))


def _quantity(text: str) -> Any:
    """Return one of a unit, None for what is none or has a number in it."""
    spelling = text.strip().lower().replace(' ', '')
    known = _SPELLINGS.get(spelling)
    if text == 'Ms' or (known is None and not re.fullmatch(r'[A-Za-zµ°²³/·*^\d_]+', text)):
        return None
    try:
        if known and not known[0].isdigit():
            return _registry().Quantity(1.0, known)  # offset units allow nothing else
        found = 1.0 * _registry().Quantity(known or re.sub(r'(?<=[A-Za-z])(?=\d)', '**', text))
    except RecordError:
        raise
    except Exception:  # pint raises whatever its parser and its tables meet
        return None
    return found if known or found.magnitude == 1.0 else None


def si_units(column: str) -> tuple[str, ...]:
    """Return the SI units that a column may have; none where any will do."""
    if column == 'set_point':
        return COLUMNS[column].unit, 'Pa'  # of the stem, or of the chamber's pressure
    return (COLUMNS[column].unit,) if column in COLUMNS else ()


def is_usual(text: str) -> bool:
    """Tell whether a text is a usual spelling of a unit, not only something that pint knows."""
    marked = _MARKED.fullmatch(text)
    return text.lower() in _SPELLINGS or (
        marked is not None and marked[1].lower() in _SPELLINGS and len(marked[1]) > 1)


def conversion(unit: Unit, column: str, where: str) -> Conversion:
    """Return the conversion of a unit into the SI unit of a column; RecordError where none is."""
    targets = si_units(column)
    for target in targets or (_base(unit),):
        goal = _registry().Quantity(1.0, target or 'dimensionless')
        if unit.pint.is_compatible_with(goal):
            return _between(unit, goal, target)
    wanted = ' or '.join(targets)
    state = ''
    if targets == ('kg/s',) and unit.pint.check('[length] ** 3 / [time]'):
        state = ': it is a volume, of which the density is not known'
    raise RecordError(f'{where}: {unit.written} is no unit of {column}, which is in {wanted}'
                      f'{state}')


def _between(unit: Unit, goal: Any, target: str) -> Conversion:
    degrees = unit.pint.units
    zero = float(_registry().Quantity(0.0, degrees).to(goal.units).magnitude)
    factor = float(unit.pint.to(goal.units).magnitude) - zero
    inverse = 1.0 / factor
    # 4.4 mA / 1000 is 0.0044 A to the last bit, 4.4 * 0.001 is not
    if factor < 1.0 and math.isclose(inverse, round(inverse), rel_tol=1e-12):
        return Conversion(1.0, float(round(inverse)), zero, target)
    if math.isclose(factor, round(factor), rel_tol=1e-12):
        factor = float(round(factor))
    return Conversion(factor, 1.0, zero, target)


def _base(unit: Unit) -> str:
    """Return the SI unit of what a unit measures."""
    if unit.is_pressure:
        return 'Pa'
    return f'{unit.pint.to_base_units().units:~C}'


def quantity(text: object, target: str, where: str) -> float:
    """Return a quantity such as '20 mm' in a unit; RecordError where it is none."""
    parts = re.fullmatch(r'\s*([-+.\deE]+)\s*(\S.*?)\s*', str(text))
    unit = parsed_unit(parts[2]) if parts else None
    goal = _registry().Quantity(1.0, target)
    try:
        number = float(parts[1]) if parts else math.nan
    except ValueError:
        number = math.nan
    if unit is None or not math.isfinite(number) or not unit.pint.is_compatible_with(goal):
        raise RecordError(f'{where}: {str(text)[:60]!r} is not a number with a unit like {target}')
    between = _between(unit, goal, target)
    return number * between.factor / between.divisor + between.offset


def gauge_offset(gauge: bool) -> float:
    """Return what is added to a pressure, Pa, to have it as gauge pressure."""
    return 0.0 if gauge else -ATMOSPHERE


def units_for(column: str) -> Sequence[str]:
    """Return units that a column is often recorded in, to name them where one is asked for."""
    usual = {'Pa': ('Pa', 'kPa', 'bar', 'psi'), 'A': ('A', 'mA'), 'm': ('m', 'mm', '%'),
             'kg/s': ('kg/s', 'g/s', 'kg/h'), 's': ('s', 'ms', 'us', 'ns')}
    found = [name for target in si_units(column) for name in usual[target]]
    return found or ('%', 'kPa', 'bar', 'kg/h', '1')
