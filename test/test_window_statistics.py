# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What of a stem that slips is compared whatever the moment of each slip."""

import numpy as np
import pytest

from booster_ros.signals.window_statistics import Windows

TIME = 0.01 * np.arange(6000)
RAMP = 4.0 * TIME


def saw(size, phase=0.0, period=0.12):
    """Return slips of this size, one a period, on a ramp; in standard deviations of the noise."""
    return RAMP + size * (((TIME + phase) / period) % 1.0 - 0.5)


def compared(read, model):
    """Return means and strengths of the windows of a noisy record of one beside the other."""
    readings = read + np.random.default_rng(2).standard_normal(len(TIME))
    windows = Windows.of(TIME, readings)
    return windows.means(readings - model), windows.strengths(readings - model)


def test_slips_that_come_at_other_moments_are_the_same():
    means, strengths = compared(saw(8.0), saw(8.0, phase=0.05))
    rows = saw(8.0) - saw(8.0, phase=0.05)
    assert np.mean(rows**2) > 8.0
    assert np.sqrt(np.mean(strengths**2)) < 1.0
    assert np.sqrt(np.mean(means**2)) < 3.0


@pytest.mark.parametrize(('size', 'sign'), [(4.0, -1.0), (16.0, 1.0)])
def test_slips_of_another_size_show_though_they_miss_less_or_more(size, sign):
    _, strengths = compared(saw(8.0), saw(size, phase=0.05))
    assert np.min(sign * strengths) > 2.0


def test_a_valve_that_does_not_slip_is_as_strong_as_its_noise():
    means, strengths = compared(RAMP, RAMP)
    assert np.sqrt(np.mean(strengths**2)) < 1.0
    assert np.sqrt(np.mean(means**2)) == pytest.approx(1.0, abs=0.2)


def test_windows_with_few_rows_have_a_mean_alone():
    few = np.concatenate([TIME[:100], 1.0 + TIME[:7], 2.0 + TIME[:100]])
    windows = Windows.of(few, np.random.default_rng(2).standard_normal(len(few)))
    assert len(windows.means(0.0 * few)) == 3
    assert len(windows.strengths(0.0 * few)) == 2
