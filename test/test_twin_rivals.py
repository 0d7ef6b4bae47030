# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The twin beside CUSUM and Page-Hinkley: what counts as seen, thresholds, and both statistics."""

import numpy as np
import pytest

from booster_ros.benchmark.twin_page import seen
from booster_ros.benchmark.twin_rivals import PROMISED, cusum, page_hinkley, rivals
from booster_ros.benchmark.twin_valves import (
    CHANNELS, LASTS, LEARNING, NAMES, Run, first_seen)
from booster_ros.twin.summaries import Summary

LENGTH = 20.0


def run(seed: int, shift: float = 0.0, changed: float = LASTS) -> Run:
    """Return blocks of white numbers whose mean changes by `shift` deviations."""
    random = np.random.default_rng(seed)
    ends = np.arange(LENGTH, LASTS + LENGTH, LENGTH)
    numbers = random.standard_normal((len(ends), len(NAMES)))
    numbers[ends > changed] += shift
    return Run([Summary(end - LENGTH, end, dict.fromkeys(CHANNELS, (0, 1)), dict(zip(NAMES, row)))
                for end, row in zip(ends, numbers.tolist())], changed)


def test_what_alarms_before_the_change_is_neither_seen_nor_missed():
    assert first_seen(np.array([700.0, 900.0]), 600.0) == 100.0
    assert first_seen(np.array([]), 600.0) is None
    early = first_seen(np.array([500.0, 700.0]), 600.0)
    assert np.isnan(early)
    assert seen([100.0, None, early, 300.0]) == '2 of 3, 200 s'


@pytest.mark.parametrize('statistic', [cusum, page_hinkley])
@pytest.mark.parametrize('sign', [1.0, -1.0])
def test_a_shift_raises_the_statistic_either_way_and_noise_does_not(statistic, sign):
    noise = np.random.default_rng(3).standard_normal((400, 2))
    shifted = noise.copy()
    shifted[200:, 1] += 2.0 * sign
    assert statistic(shifted)[-1] > 5.0 * statistic(noise).max()
    np.testing.assert_array_equal(statistic(shifted)[:200], statistic(noise)[:200])


def test_thresholds_let_as_many_clean_runs_alarm_as_are_promised():
    clean = [run(seed) for seed in range(60)]
    allowed = int(PROMISED * len(clean) * (LASTS - LEARNING) / 3.6e6)
    assert allowed > 3
    for delay in rivals(clean).values():
        alarmed = sum(delay(one) is not None for one in clean)
        assert alarmed == allowed
        told = [delay(run(seed, 3.0, 5400.0)) for seed in range(100, 120)]
        assert all(one is not None for one in told)
