# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Turn numbers into lines of a CSV, many rows at once, with the very bytes of Python's `%.3f`.

Digits are taken four at a time from a table, for all rows of a block together; Python formats the
few numbers that lie so near to the middle between two last digits that the product with a power of
ten cannot tell which is nearer.
"""

from collections.abc import Sequence

import numpy as np

from booster_ros.records.record import Array

_BLOCK_ROWS = 4096
_LARGEST = 2.0**50
"""Size, in units of the last digit, below which the nearest whole number can be told."""

_FOUR_DIGITS = np.frombuffer(b''.join(b'%04d' % k for k in range(10_000)), dtype=np.uint32)


def fixed_lines(values: Array, decimals: Sequence[int]) -> bytes | None:
    r"""
    Return rows x columns of values as lines, each column with its `decimals`, 1 to 15.

    Return None where a number is not finite or has more digits than this can do.

    >>> fixed_lines(np.array([[1.5, -0.25], [10.0, 3.0]]), (1, 3))
    b'1.5,-0.250\n10.0,3.000\n'
    """
    scaled = values * np.power(10.0, decimals)
    if not np.abs(scaled).max(initial=0.0) < _LARGEST:  # also where one is no number
        return None
    blocks = range(0, len(values), _BLOCK_ROWS)
    return b''.join(
        _lines(values[k:k + _BLOCK_ROWS], scaled[k:k + _BLOCK_ROWS], decimals) for k in blocks)


def _lines(values: Array, scaled: Array, decimals: Sequence[int]) -> bytes:
    cells = [_cell(values[:, j], scaled[:, j], places) for j, places in enumerate(decimals)]
    for text, _ in cells[:-1]:
        text[:, -1] = ord(',')
    text = np.concatenate([text for text, _ in cells], axis=1)
    shown = np.concatenate([shown for _, shown in cells], axis=1)
    return text[shown].tobytes()


def _cell(values: Array, scaled: Array, places: int) -> tuple[Array, Array]:
    """Return the characters of a column, rows x width with a line feed, and which are shown."""
    numbers = np.abs(_rounded(values, scaled, places))
    width = max(len(str(numbers.max())), places + 1)
    digits = _digits(numbers, width)
    whole = width - places
    text = np.empty((len(values), width + 3), dtype=np.uint8)
    text[:, 0] = ord('-')
    text[:, 1:1 + whole] = digits[:, :whole]
    text[:, 1 + whole] = ord('.')
    text[:, 2 + whole:-1] = digits[:, whole:]
    text[:, -1] = ord('\n')
    shown = np.ones(text.shape, dtype=bool)
    shown[:, 0] = np.signbit(values)
    for k in range(whole - 1):  # no zeros in front
        shown[:, 1 + k] = numbers >= 10 ** (width - 1 - k)
    return text, shown


def _rounded(values: Array, scaled: Array, places: int) -> Array:
    """Return the values as whole multiples of their last digit, rounded as Python does it."""
    numbers = np.rint(scaled)
    from_middle = 0.5 - np.abs(scaled - numbers)
    numbers = numbers.astype(np.int64)
    # the product may be off by half its last bit, and exact halves go to the even digit
    for k in np.flatnonzero(from_middle <= np.abs(scaled) * 2.0**-52).tolist():
        numbers[k] = int(f'{values[k]:.{places}f}'.replace('.', ''))
    return numbers


def _digits(numbers: Array, width: int) -> Array:
    """Return the last `width` decimal digits of whole numbers as characters, rows x width."""
    groups = -(-width // 4)
    text = np.empty((len(numbers), groups), dtype=np.uint32)
    for k in range(groups - 1, -1, -1):
        rest = numbers // 10_000
        text[:, k] = _FOUR_DIGITS[numbers - rest * 10_000]
        numbers = rest
    return text.view(np.uint8)[:, 4 * groups - width:]
