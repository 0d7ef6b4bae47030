# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Ranks and frequencies of a signal, beside what scipy has of them."""

import numpy as np
import pytest
from scipy import signal, stats

from booster_ros.signals.periodogram import periodogram
from booster_ros.signals.rank_correlation import rank_correlation


def test_a_periodogram_is_that_of_scipy_up_to_a_constant():
    time = np.linspace(3.0, 80.0, 777)
    values = np.sin(2.6 * np.pi * time) + 0.1 * time + np.random.default_rng(1).normal(size=777)
    frequency, power = periodogram(values, time[1] - time[0], 8)
    expected = signal.periodogram(values, 1.0 / (time[1] - time[0]), 'hann', 8 * 777, 'linear')
    np.testing.assert_allclose(frequency, expected[0], atol=1e-12)
    assert frequency[np.argmax(power)] == pytest.approx(1.3, abs=0.005)
    ratio = power[50:-50] / expected[1][50:-50]
    np.testing.assert_allclose(ratio, ratio[0], rtol=1e-6)


@pytest.mark.parametrize('steps', [0.0, 0.5])
def test_a_rank_correlation_is_that_of_scipy_also_where_values_are_equal(steps):
    x, noise = np.random.default_rng(2).standard_normal((2, 200))
    y = -x**3 + noise
    if steps:
        x, y = (steps * np.round(each / steps) for each in (x, y))
    assert rank_correlation(x, y) == pytest.approx(stats.spearmanr(x, y).statistic, abs=1e-12)
    assert rank_correlation(x, y) < -0.5
