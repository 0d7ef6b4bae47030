# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The colour of the noise, at rests and where the valve moves smoothly."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.signal import lfilter

from booster_ros.signals.stationary_segments import (
    FEWEST_PIECES, MOST_ROWS, calm_pieces, rests_of, smooth_pieces)
from booster_ros.signals.noise_autocorrelation import Noise, noise_of
from booster_ros.model.simulation import simulate
from booster_ros.model.system import PositionerParameters

TIME = 0.01 * np.arange(12000)
STEPS = 0.4e-3 + 0.01e-3 * (np.floor(TIME / 8.0) % 3.0)
SINES = 0.41e-3 + 0.02e-3 * np.sin(2.0 * TIME) + 0.01e-3 * np.sin(0.3 * TIME)
TRIANGLE = 0.41e-3 + 0.05e-3 * np.abs((TIME / 30.0) % 2.0 - 1.0)
SHORT_STEPS = 0.4e-3 + 0.01e-3 * (np.floor(TIME / 2.0) % 3.0)


def settling(time=TIME, drive=STEPS):
    """Return a signal (of size 1) that follows the drive with a lag and creeps a little."""
    share = 1.0 - np.exp(-(time[1] - time[0]) / 0.3)
    followed = lfilter([share], [1.0, share - 1.0], (drive - drive[0]) / np.ptp(drive))
    return followed + 0.1 * np.sin(time / 20.0)


@pytest.mark.parametrize('correlation', [-0.5, 0.5, 0.9])
def test_colour_and_level_of_noise_are_found_at_rests_of_a_moving_signal(correlation):
    noise = Noise(2e-3, correlation)
    shown = noise.added_to(settling(), np.random.default_rng(3))
    found = noise_of(shown, rests_of(TIME, [STEPS]))
    assert found.correlation == pytest.approx(correlation, abs=0.06)
    assert found.level == pytest.approx(2e-3, rel=0.15)


def test_slow_noise_that_is_rounded_is_nearly_as_loud_as_it_is():
    """Of slow noise some pieces hold far more than others: that is no valve which has moved."""
    rests = [slice(100 * k, 100 * k + 100) for k in range(0, 140, 2)]
    found = []
    for seed in range(10):
        shown = Noise(150.0, 0.95).added_to(np.zeros(15000), np.random.default_rng(seed))
        found.append(noise_of(25.0 * np.round(shown / 25.0), rests).level)
    assert np.mean(found) == pytest.approx(150.0, rel=0.1)


@pytest.mark.parametrize('step', [0.0, 0.5])
@pytest.mark.parametrize(('correlation', 'pieces'), [(0.8, 12), (0.9, 21), (0.95, 21)])
def test_short_pieces_of_slow_noise_tell_its_level_to_within_a_half(correlation, pieces, step):
    """Most likely is at times a noise that hardly fades at all, four times as loud as it is."""
    rests = [slice(50 * k, 50 * k + 50) for k in range(0, 2 * pieces, 2)]
    found = []
    for seed in range(20):
        shown = Noise(1.0, correlation).added_to(
            np.zeros(100 * pieces), np.random.default_rng(seed))
        found.append(noise_of(shown if not step else step * np.round(shown / step), rests).level)
    assert 0.75 < np.median(found) < 1.15
    assert np.quantile(found, 0.05) > 0.5
    assert np.quantile(found, 0.95) < 1.6


def test_noise_of_a_quantised_white_record_is_found_again_in_what_is_simulated_with_it():
    rng = np.random.default_rng(4)
    step = 1e-3
    shown = step * np.round((settling() + 2e-3 * rng.standard_normal(len(TIME))) / step)
    found = noise_of(shown, rests_of(TIME, [STEPS]))
    assert found.correlation == 0.0
    assert not found.clouded
    assert found.resolution == pytest.approx(step)
    again = found.added_to(settling(), rng)
    assert np.allclose(again / step, np.round(again / step))
    assert np.std(again - settling()) == pytest.approx(np.hypot(2e-3, step / np.sqrt(12)), rel=0.03)


def test_a_ripple_at_rests_is_not_taken_for_noise():
    rng = np.random.default_rng(9)
    shown = settling() + 4e-3 * np.sin(2.0 * np.pi * 5.0 * TIME)
    shown += 2e-3 * rng.standard_normal(len(TIME))
    found = noise_of(shown, rests_of(TIME, [STEPS]))
    assert found.correlation == 0.0
    assert found.clouded
    assert found.level == pytest.approx(2e-3, rel=0.05)


def test_a_valve_that_slips_at_rests_is_not_taken_for_noise():
    rng = np.random.default_rng(11)
    slips = 20e-3 * rng.standard_normal(len(TIME)) * (rng.random(len(TIME)) < 0.05)
    hunting = lfilter([1.0], [1.0, -0.9], slips)
    shown = settling() + hunting + 1e-3 * rng.standard_normal(len(TIME))
    found = noise_of(shown, rests_of(TIME, [STEPS]))
    assert found.correlation == 0.0
    assert found.clouded


@pytest.fixture(scope='module')
def moved():
    """Return what drives, the same for several tests, make a valve do."""
    runs = {}

    def run_of(drive):
        key = drive.tobytes()
        if key not in runs:
            runs[key] = simulate(PositionerParameters(), TIME, drive, {'chamber_pressure': 200e3})
        return runs[key]
    return run_of


@pytest.mark.parametrize('every', [1, 2])
@pytest.mark.parametrize('drive', [SINES, TRIANGLE, SHORT_STEPS], ids=['sine', 'ramp', 'steps'])
@pytest.mark.parametrize('correlation', [0.0, 0.9])
def test_where_nothing_rests_smooth_motion_of_a_valve_tells_colour_and_level(
        drive, correlation, every, moved):
    """Differences alone would show a quarter to four fifths of the noise that carries over."""
    time = TIME[::every]
    assert len(rests_of(time, [drive[::every]])) < FEWEST_PIECES
    run = moved(drive)
    for name, level in {'chamber_pressure': 150.0, 'valve_position': 8e-6}.items():
        shown = Noise(level, correlation).added_to(run[name], np.random.default_rng(1))[::every]
        found = noise_of(shown, calm_pieces(time, [drive[::every]]))
        assert found.correlation == pytest.approx(correlation**every, abs=0.12)
        assert 0.75 < found.level / level < 1.4
        assert not found.clouded
        assert noise_of(shown, []).level < (0.85 if correlation else 1.1) * level


def test_noise_is_white_and_of_the_level_of_differences_where_no_piece_is_calm():
    hopping = 0.4e-3 + 0.01e-3 * (np.floor(TIME / 0.6) % 3.0)
    assert calm_pieces(TIME, [hopping]) == []
    shown = Noise(2e-3, 0.5).added_to(settling(), np.random.default_rng(5))
    found = noise_of(shown, [])
    assert found.correlation == 0.0
    assert found.level == pytest.approx(0.62 * 2e-3, rel=0.05)


@pytest.mark.parametrize('every', [0.4, 0.5])
@pytest.mark.parametrize('noise', [2e-7, 6e-7])
def test_no_piece_holds_a_jump_of_a_noisy_drive_that_is_more_than_its_noise(every, noise):
    """Averaged over a whole piece, a jump would be a ramp that a cubic follows."""
    generator = np.random.default_rng(2)
    levels = generator.uniform(0.39e-3, 0.44e-3, 400)[(TIME / every).astype(int) % 400]
    pieces = smooth_pieces(TIME, [levels + noise * generator.standard_normal(len(TIME))])
    assert len(pieces) < 60
    assert all(np.ptp(levels[piece]) < 25.0 * noise for piece in pieces)


def test_a_noisy_drive_that_moves_smoothly_has_smooth_pieces():
    noisy = SINES + 3e-7 * np.random.default_rng(3).standard_normal(len(TIME))
    assert len(smooth_pieces(TIME, [noisy])) > 200


def test_a_valve_is_not_held_to_move_along_a_cubic_for_long():
    """Of rows 50 ms apart, a piece that has enough of them takes a second."""
    assert smooth_pieces(0.05 * np.arange(2400), [SINES[::5]]) == []


def test_rests_are_taken_where_there_are_enough_of_them():
    assert calm_pieces(TIME, [STEPS]) == rests_of(TIME, [STEPS])


def test_a_smooth_piece_begins_a_while_after_a_jump_of_any_drive_and_holds_no_gap():
    time = TIME + np.where(TIME > 50.0, 7.0, 0.0)
    supply = 400e3 + np.where(TIME > 100.0, 5e3, 0.0)
    jumps = time[np.flatnonzero(np.diff(SHORT_STEPS) + np.diff(supply)) + 1]
    pieces = smooth_pieces(time, [SHORT_STEPS, supply])
    assert len(pieces) > 120
    assert all(one.stop <= two.start for one, two in pairwise(pieces))
    for piece in pieces:
        inside = time[piece]
        assert inside[-1] - inside[0] < 0.5
        assert not any(inside[0] - 0.24 < jump < inside[-1] for jump in jumps)


def test_a_rest_begins_when_all_drives_have_settled_and_holds_no_gap():
    supply = 400e3 + np.where(TIME > 100.0, 5e3, 0.0)
    time = TIME + np.where(TIME > 50.0, 7.0, 0.0)
    moves = np.flatnonzero(np.diff(STEPS) + np.diff(supply))
    changes = time[moves + 1]
    rests = rests_of(time, [STEPS, supply])
    assert len(rests) > 40
    for rest in rests:
        inside = time[rest]
        assert inside[-1] - inside[0] < 2.0
        assert not any(inside[0] - 2.9 < change < inside[-1] for change in changes)


def test_a_rest_of_a_fast_record_is_cut_into_pieces_that_can_be_reckoned_with():
    time = 2e-4 * np.arange(40_000)
    rests = rests_of(time, [np.zeros(len(time))])
    assert len(rests) >= FEWEST_PIECES
    assert all(rest.stop - rest.start == MOST_ROWS for rest in rests)
