# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Least squares with few Jacobians: the least all the same, and no end that is none."""

import numpy as np
import pytest
from scipy.optimize import least_squares

from booster_ros.numerics.least_squares import descend

TIME = np.linspace(0.0, 4.0, 60)
TRUE = np.array([1.4, 0.7, 0.3])
MEASURED = TRUE[0] * np.exp(-TRUE[1] * TIME) + TRUE[2] + 0.01 * np.sin(40.0 * TIME)
WIDE = np.full(3, 10.0)


def decay(z):
    return 100.0 * (z[0] * np.exp(-z[1] * TIME) + z[2] - MEASURED)


class Counted:
    """Forward differences of a function, and how often and where both were asked for."""

    def __init__(self, function):
        self.function = function
        self.places, self.formed = [], []

    def residuals(self, z):
        self.places.append(z.copy())
        return self.function(z)

    def differences(self, z, r, before):
        self.formed.append((z.copy(), before))
        columns = [(self.function(z + 1e-6 * unit) - r) / 1e-6 for unit in np.eye(len(z))]
        return np.column_stack(columns)


def least(function, begin):
    return least_squares(function, begin, ftol=1e-12, xtol=1e-12, gtol=1e-12)


def test_it_ends_at_the_least_with_fewer_jacobians_than_steps():
    counted = Counted(decay)
    begin = np.array([1.0, 1.0, 0.0])
    found = descend(counted.residuals, counted.differences, begin, -WIDE, WIDE, 30)
    best = least(decay, begin)
    assert found.z == pytest.approx(best.x, abs=1e-3)
    assert found.cost == pytest.approx(2.0 * best.cost, rel=1e-3)
    assert found.jacobian == pytest.approx(best.jac, rel=0.05, abs=0.05 * np.abs(best.jac).max())
    assert 2 <= len(counted.formed) <= 3 < len(counted.places)
    assert len(np.unique(np.round(counted.places, 12), axis=0)) == len(counted.places)


def test_what_bends_is_formed_anew_and_not_corrected():
    def banana(z):
        return np.array([10.0 * (z[1] - z[0]**2), 1.0 - z[0]])

    counted = Counted(banana)
    found = descend(counted.residuals, counted.differences, np.array([-1.2, 1.0]), -WIDE[:2],
                    WIDE[:2], 60)
    assert found.z == pytest.approx([1.0, 1.0], abs=1e-3)
    assert found.cost < 1e-6
    assert len(counted.formed) > 5
    assert counted.formed[0][1] is None
    assert all(before is not None for _, before in counted.formed[1:])


def test_bounds_and_the_number_of_evaluations_are_kept():
    counted = Counted(decay)
    high = np.array([10.0, 0.5, 10.0])
    z = descend(counted.residuals, counted.differences, np.array([1.0, 0.4, 0.0]), -WIDE, high,
                30).z
    assert z[1] == pytest.approx(0.5, abs=1e-2)
    assert (z <= high).all()
    for most in (1, 3, 6):
        counted = Counted(decay)
        descend(counted.residuals, counted.differences, np.array([0.1, 5.0, -2.0]), -WIDE, WIDE,
                most)
        assert len(counted.places) <= most


def test_where_a_descent_is_broken_off_no_jacobian_is_formed():
    def banana(z):
        return np.array([10.0 * (z[1] - z[0]**2), 1.0 - z[0]])

    begin = np.array([-1.2, 1.0])
    for most in (2, 4):
        counted = Counted(banana)
        found = descend(counted.residuals, counted.differences, begin, -WIDE[:2], WIDE[:2], most)
        assert len(counted.places) == most
        assert found.cost < np.sum(banana(begin)**2)
        assert not any(np.array_equal(place, counted.places[-1]) for place, _ in counted.formed)
