# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A smooth signal and its rate, beside what scipy has of it."""

import numpy as np
import pytest
from scipy.signal import savgol_filter

from booster_ros.signals.savitzky_golay import smoothed


@pytest.mark.parametrize('rows', [5, 11])
def test_values_and_rates_are_those_of_scipy_to_both_ends(rows):
    walk = np.cumsum(np.random.default_rng(1).standard_normal(60))
    value, rate = smoothed(walk, rows, 0.02)
    np.testing.assert_allclose(value, savgol_filter(walk, rows, 2), atol=1e-12)
    np.testing.assert_allclose(rate, savgol_filter(walk, rows, 2, deriv=1, delta=0.02), atol=1e-10)


def test_a_parabola_stays_as_it_is():
    time = np.linspace(0.0, 3.0, 11)
    value, rate = smoothed(1.0 - 2.0 * time + 0.5 * time**2, 11, time[1])
    np.testing.assert_allclose(value, 1.0 - 2.0 * time + 0.5 * time**2, atol=1e-12)
    np.testing.assert_allclose(rate, -2.0 + time, atol=1e-12)
