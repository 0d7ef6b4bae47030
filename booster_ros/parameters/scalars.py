# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Scalars of parameter files as rcl reads them: with C's strtoll and strtod, not by YAML's rules.

So `5e8` is a number, `0x10` and `010` are whole ones (16 and 8), `400_000` and `1:30` are texts.
"""

import math
import re
import sys

_TRUE = frozenset(('Y', 'y', 'yes', 'Yes', 'YES', 'true', 'True', 'TRUE', 'on', 'On', 'ON'))
_FALSE = frozenset(('N', 'n', 'no', 'No', 'NO', 'false', 'False', 'FALSE', 'off', 'Off', 'OFF'))

_WHOLE = re.compile(r'[-+]?(?:(?P<base16>0[xX][0-9a-fA-F]+)|(?P<base8>0[0-7]*)|[1-9][0-9]*)')
_DECIMAL = re.compile(r'[-+]?(?P<digits>[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?')
_HEXADECIMAL = re.compile(
    r'[-+]?0[xX](?P<digits>[0-9a-fA-F]+\.?[0-9a-fA-F]*|\.[0-9a-fA-F]+)(?:[pP][-+]?[0-9]+)?')
_NOT_FINITE = re.compile(
    r'(?P<sign>[-+]?)(?:(?P<infinite>\.(?:inf|Inf|INF)|(?i:inf(?:inity)?))'
    r'|(?i:nan(?:\([0-9a-z_]*\))?))|\.(?:nan|NaN|NAN)')

LEAST = sys.float_info.min
"""Least size of a number but 0: a smaller one is out of range for strtod, and no number to rcl."""

_LOWEST_WHOLE, _HIGHEST_WHOLE = -2**63, 2**63 - 1


def scalar(text: str) -> bool | int | float | str:
    """
    Return what rcl makes of a scalar without quotes.

    >>> scalar('yes'), scalar('0x10'), scalar('5e8'), scalar('400_000')
    (True, 16, 500000000.0, '400_000')
    """
    if text in _TRUE or text in _FALSE:
        return text in _TRUE
    whole = _whole(text)
    if whole is not None:
        return whole
    number = _float(text)
    return text if number is None else number


def _whole(text: str) -> int | None:
    match = _WHOLE.fullmatch(text)
    if match is None:
        return None
    base = 16 if match['base16'] else 8 if match['base8'] else 10
    try:
        number = int(text, base)
    except ValueError:  # thousands of digits
        return None
    return number if _LOWEST_WHOLE <= number <= _HIGHEST_WHOLE else None


def _float(text: str) -> float | None:
    match = _NOT_FINITE.fullmatch(text)
    if match is not None:
        size = math.inf if match['infinite'] else math.nan
        return -size if match['sign'] == '-' else size
    decimal = _DECIMAL.fullmatch(text)
    match = decimal or _HEXADECIMAL.fullmatch(text)
    if match is None:
        return None
    try:
        number = float(text) if decimal else float.fromhex(text)
    except OverflowError:
        return None
    is_zero = not match['digits'].strip('0.')
    return number if is_zero or LEAST <= abs(number) < math.inf else None
