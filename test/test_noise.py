# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The noise of a channel, also where a coarse sensor rounds it away."""

import numpy as np
import pytest

from booster_ros.diagnosis.noise import noise_level, white_noise

ROWS = 12000
NOISE = 150.0


def moving(seed=1, noise=NOISE):
    """Return a slow signal alone and with noise."""
    time = 0.01 * np.arange(ROWS)
    slow = 2e5 + 4e4 * np.sin(0.2 * time) + 1e4 * np.tanh(3.0 * np.sin(0.5 * time))
    return slow, slow + noise * np.random.default_rng(seed).standard_normal(ROWS)


@pytest.mark.parametrize('step', [
    1.0, 50.0, 100.0, 200.0, 244.0, 300.0, 375.0, 500.0, 530.0, 560.0, 750.0, 1000.0, 2000.0, 5e3])
def test_rounding_is_part_of_the_noise_however_coarse_it_is(step):
    slow, noisy = moving()
    rounded = step * np.round(noisy / step)
    truth = np.sqrt(np.mean((rounded - slow)**2))
    assert noise_level(rounded) == pytest.approx(truth, rel=0.06)


def test_what_is_not_rounded_is_white_noise():
    _, noisy = moving()
    assert noise_level(noisy) == white_noise(noisy) == pytest.approx(NOISE, rel=0.03)


@pytest.mark.parametrize('step', [0.0, 375.0])
def test_a_channel_slower_than_the_rows_has_the_noise_of_the_rows_it_has(step):
    _, noisy = moving()
    rounded = step * np.round(noisy / step) if step else noisy
    rounded[np.arange(ROWS) % 3 > 0] = np.nan
    assert noise_level(rounded) == pytest.approx(np.hypot(NOISE, step / np.sqrt(12.0)), rel=0.06)


def test_nothing_is_said_of_a_channel_that_stands_still_or_has_too_few_rows():
    assert noise_level(np.full(100, 3.0)) == 0.0
    assert noise_level(np.array([1.0, 5.0, 2.0])) == 0.0
