# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Numbers as a plant engineer reads them: kPa, mm, mA and three significant digits."""

from collections.abc import Iterable
import math
from typing import NamedTuple


class Scale(NamedTuple):
    """A unit for people and what a value in SI is multiplied by to be in it."""

    unit: str
    factor: float

    def text(self, value: float, digits: int = 3) -> str:
        """Return an SI value with this unit behind it; small lengths are in µm."""
        if self.unit == 'mm' and 0.0 < abs(value) < _SMALL_LENGTH:
            return f'{number(value * 1e6, digits)} µm'
        return f'{number(value * self.factor, digits)} {self.unit}'.rstrip()


_SCALES = {
    'Pa': Scale('kPa', 1e-3),
    'm': Scale('mm', 1e3),
    'A': Scale('mA', 1e3),
    'kg/s': Scale('g/s', 1e3),
    'm/s': Scale('mm/s', 1e3),
    'm^2': Scale('mm²', 1e6),
    'm^3': Scale('L', 1e3),
    'm^2/N': Scale('mm²/N', 1e6),
    'Pa/A': Scale('kPa/mA', 1e-6),
    'Pa s/kg': Scale('kPa/(g/s)', 1e-6),
    'N/m': Scale('N/mm', 1e-3),
    'N s/m': Scale('N·s/m', 1.0),
    '-': Scale('', 1.0),
}

_SMALL_LENGTH = 1e-4
_READ_IN_MICROMETRES = 1e-2
_MOST_DIGITS = 6
_THIN_SPACE = '\u202f'  # which does not break over two lines


def scale_of(unit: str) -> Scale:
    """Return how people read a quantity that is in this SI unit."""
    return _SCALES.get(unit, Scale(unit, 1.0))


def common_scale(unit: str, values: Iterable[float]) -> Scale:
    """Return the one unit in which people compare all of these values, which are in SI."""
    sizes = [abs(value) for value in values if math.isfinite(value) and value != 0.0]
    if sizes and unit == 'm' and min(sizes) < _SMALL_LENGTH and max(sizes) < _READ_IN_MICROMETRES:
        return Scale('µm', 1e6)
    return scale_of(unit)


def digits_apart(low: float, high: float) -> int:
    """Return how many digits, three or more, the ends of an interval need to look different."""
    digits = 3
    while digits < _MOST_DIGITS and number(low, digits) == number(high, digits) and low != high:
        digits += 1
    return digits


def interval_text(scale: Scale, low: float, high: float, digits: int, open_above: bool = False
                  ) -> str:
    """Return an interval as people read it; its ends are in SI, open above it has one alone."""
    if open_above:
        return f'from {scale.text(low, digits)} up'
    return f'{number(low * scale.factor, digits)} to {scale.text(high, digits)}'


def si_text(value: float, unit: str, digits: int = 3) -> str:
    """Return a value with its SI unit, typeset."""
    return f'{number(value, digits)} {si_scale(unit).unit}'.rstrip()


def si_scale(unit: str) -> Scale:
    """Return the scale of an SI unit as it is, typeset."""
    return Scale('' if unit == '-' else unit.replace('^2', '²').replace('^3', '³').replace(
        ' s', '·s'), 1.0)


def number(value: float, digits: int = 3) -> str:
    """Return a number with significant digits, thin spaces by thousands, a true minus sign."""
    if not math.isfinite(value):
        return '–'
    if value == 0.0:
        return '0'
    exponent = math.floor(math.log10(abs(float(f'{value:.{digits - 1}e}'))))
    if not -4 <= exponent < 7:
        mantissa, power = f'{value:.{digits - 1}e}'.split('e')
        return f'{mantissa} × 10{_superscript(int(power))}'.replace('-', '−')
    rounded = round(value, digits - 1 - exponent)
    decimals = max(digits - 1 - exponent, 0)
    return f'{rounded:,.{decimals}f}'.replace(',', _THIN_SPACE).replace('-', '−')


def _superscript(power: int) -> str:
    return str(power).translate(str.maketrans('-0123456789', '⁻⁰¹²³⁴⁵⁶⁷⁸⁹'))
