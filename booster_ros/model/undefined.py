# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Where the equations have no value: the root of a temperature below zero, a number beyond all size.

Machine code goes on there with NaN or infinity. Plain Python raises an exception, which must come
to the same: a step that is too long, or a model that has no solution from there on.
"""

from collections.abc import Callable
import functools
import math

UNDEFINED = (ValueError, OverflowError, ZeroDivisionError)
"""What Python raises there."""


def infinite_where_undefined(step: Callable[..., float]) -> Callable[..., float]:
    """Return a step whose error is infinite where the equations have no value on its way."""

    @functools.wraps(step)
    def guarded(*given):
        try:
            return step(*given)
        except UNDEFINED:
            return math.inf

    return guarded
