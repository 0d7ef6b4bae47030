# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The noise of a channel, also where a coarse sensor rounds it away."""

import numpy as np
import pytest

from booster_ros.signals.noise_level import noise_level, white_noise
from booster_ros.signals.noise_autocorrelation import noise_of

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


@pytest.mark.parametrize('step', [0.0, 2e-6])
@pytest.mark.parametrize('end', [0.0, 1e-2])
def test_what_a_sensor_cuts_off_at_its_end_is_noise_all_the_same(step, end):
    """A position that reads nothing below closed shows half of its noise there, or less."""
    time = 0.01 * np.arange(ROWS)
    slow = np.clip(5e-3 + 8e-3 * np.sin(0.3 * time), 0.0, 1e-2)
    noisy = slow + 8e-6 * np.random.default_rng(4).standard_normal(ROWS)
    cut = np.maximum(noisy, 0.0) if end == 0.0 else np.minimum(noisy, 1e-2)
    rounded, whole = (step * np.round(some / step) if step else some for some in (cut, noisy))
    assert np.mean(rounded == end) > 0.1
    truth = np.sqrt(np.mean((whole - slow)[slow != end]**2))
    assert noise_level(rounded) == pytest.approx(truth, rel=0.06)


@pytest.mark.parametrize('rows', [1200, ROWS])
@pytest.mark.parametrize('share', [0.15, 0.3, 0.45, 0.6])
@pytest.mark.parametrize('reading', [0.0, 2e5])
def test_where_a_sensor_reads_the_same_for_long_the_rest_tells(rows, share, reading):
    """At an end of a short record, and wherever it froze."""
    _, noisy = moving()
    noisy = noisy[:rows]
    for begin in (0.1, 0.6) if share < 0.5 else (0.1,):
        part = share / 2.0 if share < 0.5 else share
        noisy[int(begin * rows):int((begin + part) * rows)] = reading
    assert noise_level(noisy) == pytest.approx(NOISE, rel=0.1)


def test_what_is_not_rounded_is_white_noise():
    _, noisy = moving()
    assert noise_level(noisy) == white_noise(noisy) == pytest.approx(NOISE, rel=0.03)


@pytest.mark.parametrize('step', [0.0, 375.0])
def test_a_channel_slower_than_the_rows_has_the_noise_of_the_rows_it_has(step):
    _, noisy = moving()
    rounded = step * np.round(noisy / step) if step else noisy
    rounded[np.arange(ROWS) % 3 > 0] = np.nan
    assert noise_level(rounded) == pytest.approx(np.hypot(NOISE, step / np.sqrt(12.0)), rel=0.06)


def slipping(noise=NOISE, period=0.08, size=1800.0, share=0.6):
    """Return a noisy signal that goes in slips for that share of each 20 s."""
    time = 0.01 * np.arange(ROWS)
    saw = size * ((time / period) % 1.0 - 0.5) * (time % 20.0 < share * 20.0)
    return moving(noise=noise)[1] + saw


def of_all_differences(signal):
    """Return the noise that the median of all third differences says."""
    return np.median(np.abs(np.diff(signal, 3))) / 0.6745 / np.sqrt(20.0)


def test_slips_are_no_noise_where_a_part_of_the_record_has_none():
    signal = slipping()
    assert of_all_differences(signal) > 1.35 * NOISE
    assert noise_level(signal) == pytest.approx(NOISE, rel=0.15)


def test_noise_that_is_cut_off_at_an_end_of_the_sensor_is_not_the_noise():
    _, noisy = moving()
    cut = np.arange(ROWS) % 4000 < 1600
    noisy[cut] = 1e5 + np.maximum(noisy[cut] - moving()[0][cut], 0.0)
    assert noise_level(noisy) == pytest.approx(NOISE, rel=0.03)


def test_a_valve_that_hunts_while_its_drive_rests_says_nothing_of_the_colour_of_noise():
    """Its slips carry over from row to row as coloured noise does; a few pieces without tell."""
    time = 0.01 * np.arange(ROWS)
    noise = 8.0 * np.random.default_rng(4).standard_normal(ROWS)
    swings = 16.0 * np.sin(2.0 * np.pi * time * (1.0 + 0.1 * np.sin(time))) * (time % 20.0 < 15.0)
    rests = [slice(first, first + 100) for first in range(0, ROWS, 100)]
    hunting = noise_of(swings + 20.0 * np.round(noise / 20.0 + 0.3 * swings / 20.0), rests)
    assert hunting.correlation == 0.0


def test_nothing_is_said_of_a_channel_that_stands_still_or_has_too_few_rows():
    assert noise_level(np.full(100, 3.0)) == 0.0
    assert noise_level(np.array([1.0, 5.0, 2.0])) == 0.0
