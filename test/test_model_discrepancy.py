# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The table of a term without a name."""

import math

from hypothesis import given
from hypothesis import strategies as st
import numpy as np
import pytest

from booster_ros.model.discrepancy import (
    CHAMBER, KNOTS, VALVE_POSITION, Discrepancy, covered, interpolate, slope)

VALUES = tuple(float(v) for v in np.random.default_rng(1).normal(size=KNOTS))
EVEN = np.linspace(-2.0, 20.0, KNOTS)
UNEVEN = np.array([-2.0, 0.0, 0.1, 0.2, 0.4, 3.0, 9.0, 9.5, 9.6, 12.0, 13.0, 20.0])


def table(knots):
    return Discrepancy(CHAMBER, VALVE_POSITION, tuple(knots), VALUES)


@pytest.mark.parametrize('knots', [EVEN, UNEVEN])
@given(st.floats(-5.0, 25.0))
def test_between_its_knots_the_term_is_straight_and_beyond_them_zero(knots, value):
    expected = np.interp(value, knots, VALUES, 0.0, 0.0)
    assert interpolate(table(knots), value) == pytest.approx(expected, abs=1e-9)


def test_at_its_knots_the_term_has_its_values():
    one = table(UNEVEN)
    assert [interpolate(one, float(knot)) for knot in UNEVEN] == pytest.approx(VALUES, abs=1e-12)


def test_what_is_covered_lies_between_the_fades():
    assert covered(table(UNEVEN)) == (0.0, 13.0)


@pytest.mark.parametrize('value', [-2.1, 20.1, math.inf, -math.inf, math.nan])
def test_beyond_the_table_and_where_there_is_no_number_the_term_is_zero(value):
    assert interpolate(table(UNEVEN), value) == 0.0


@given(st.floats(-1.9, 19.9))
def test_its_slope_is_how_it_rises(value):
    one = table(UNEVEN)
    if np.abs(UNEVEN - value).min() > 1e-4:
        rise = interpolate(one, value + 1e-5) - interpolate(one, value - 1e-5)
        assert slope(one, value) == pytest.approx(rise / 2e-5, abs=1e-5)
    assert slope(one, -2.1) == slope(one, 20.1) == slope(one, math.nan) == 0.0
