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


def table(below, above, values=VALUES):
    return Discrepancy(CHAMBER, VALVE_POSITION, -2.0, 20.0, values, below, above)


@given(st.floats(-5.0, 25.0))
def test_without_fades_the_values_are_at_equal_distances(value):
    expected = np.interp(value, np.linspace(-2.0, 20.0, KNOTS), VALUES, 0.0, 0.0)
    assert interpolate(table(0.0, 0.0), value) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize(('below', 'above', 'ends'), [
    (0.0, 0.0, (0.0, 18.0)),
    (4.0, 7.0, (2.0, 13.0)),
    (12.0, 0.0, (10.0, 19.0)),
    (0.0, 11.0, (-0.9, 9.0)),
])
@given(st.floats(-5.0, 25.0))
def test_a_fade_has_the_length_it_is_given_and_the_rest_equal_distances(below, above, ends, value):
    assert covered(table(below, above)) == pytest.approx(ends)
    knots = np.r_[-2.0, np.linspace(*ends, KNOTS - 2), 20.0]
    expected = np.interp(value, knots, VALUES, 0.0, 0.0)
    assert interpolate(table(below, above), value) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize('value', [-2.1, 20.1, math.inf, -math.inf, math.nan])
def test_beyond_the_table_and_where_there_is_no_number_the_term_is_zero(value):
    assert interpolate(table(4.0, 7.0), value) == 0.0


@given(st.floats(-1.9, 19.9))
def test_its_slope_is_how_it_rises(value):
    one = table(4.0, 7.0)
    knots = np.r_[-2.0, np.linspace(2.0, 13.0, KNOTS - 2), 20.0]
    if np.abs(knots - value).min() > 1e-4:
        rise = interpolate(one, value + 1e-5) - interpolate(one, value - 1e-5)
        assert slope(one, value) == pytest.approx(rise / 2e-5, abs=1e-6)
    assert slope(one, -2.1) == slope(one, 20.1) == slope(one, math.nan) == 0.0
