# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Profiles, the position loop, and the settings that choose between them; without ROS."""

import math
import re

import numpy as np
import pytest

from booster_ros.control import profiles
from booster_ros.control.command import make_command
from booster_ros.control.pi import PiController
from booster_ros.control.selection import select_profile
from booster_ros.control.settings import DESCRIPTIONS, check
from booster_ros.model.parameters import ParameterError, from_values
from booster_ros.model.simulation import Plant


def sampled(profile: profiles.Profile, count: int = 2000) -> np.ndarray:
    return np.array([profile.value(t) for t in np.linspace(0.0, profile.duration, count)])


def test_the_default_profile_is_the_papers_test():
    profile = select_profile(check({}))
    levels = [profile.value(t) for t in (0.0, 19.99, 20.0, 39.99, 40.0, 60.0, 79.99)]
    assert levels == [0.0, 0.0, 0.4524e-3, 0.4524e-3, 0.0, 0.4524e-3, 0.4524e-3]
    assert profile.duration == 80.0


def test_a_staircase_climbs_and_descends_in_equal_stairs():
    profile = profiles.staircase(1.0, 2.0, 4, 10.0)
    levels = [profile.value(10.0 * stair + 5.0) for stair in range(9)]
    assert levels == [1.0, 1.25, 1.5, 1.75, 2.0, 1.75, 1.5, 1.25, 1.0]
    assert profile.duration == 90.0


def test_a_triangle_is_straight_and_turns_at_its_limits():
    profile = profiles.triangle(-1.0, 3.0, 8.0, 3)
    assert [profile.value(t) for t in (0.0, 2.0, 4.0, 6.0, 8.0, 12.0)] == [-1, 1, 3, 1, -1, 3]
    assert profile.duration == 24.0
    assert np.abs(np.diff(sampled(profile))).max() <= 24.0 / 1999 + 1e-12


def test_sines_stay_within_their_limits_and_hold_what_they_promise():
    profile = profiles.sines(1.0, 3.0, [0.1, 0.3, 0.7], 2)
    values = sampled(profile, 4001)[:-1]
    assert profile.duration == 20.0
    assert values.min() >= 1.0
    assert values.max() <= 3.0
    spectrum = np.abs(np.fft.rfft(values - 2.0)) / (values.size / 2)
    np.testing.assert_allclose(spectrum[[2, 6, 14]], 1.0 / 3.0, rtol=1e-6)
    assert np.delete(spectrum, [2, 6, 14]).max() < 1e-9


def test_a_repeated_profile_starts_again():
    profile = profiles.steps([1.0, 2.0], 1.0).repeated()
    assert [profile.value(t) for t in (0.5, 1.5, 2.5, 1001.5)] == [1.0, 2.0, 1.0, 2.0]
    assert profile.duration == math.inf


@pytest.mark.parametrize('name', ['steps', 'staircase', 'triangle', 'sines'])
def test_settings_choose_the_profile(name):
    settings = check({'profile': name, 'low': 1e-4, 'high': 3e-4, 'levels': [1e-4, 3e-4]})
    values = sampled(select_profile(settings))
    assert 1e-4 <= values.min() < values.max() <= 3e-4
    assert select_profile(settings._replace(loop=True)).duration == math.inf


def test_a_csv_is_held_from_row_to_row_from_its_first_time(tmp_path):
    path = tmp_path / 'profile.csv'
    path.write_text('time,control_current\n5.0,1e-4\n6.0,\n7.0,3e-4\n')
    profile = select_profile(check({'profile': 'csv', 'csv_file': str(path)}))
    assert [profile.value(t) for t in (0.0, 1.99, 2.0, 3.9)] == [1e-4, 1e-4, 3e-4, 3e-4]
    assert profile.duration == 3.0


@pytest.mark.parametrize(('values', 'says'), [
    ({'rat': 1.0}, 'there is no parameter rat; did you mean rate?'),
    ({'rate': 0.0}, 'rate'),
    ({'rate': 'fast'}, 'rate'),
    ({'stairs': 1.5}, 'stairs'),
    ({'stairs': 1_000_001}, 'stairs must be a whole number from 1 to 1e+06, got 1000001'),
    ({'cycles': 10**309}, 'cycles must be a whole number from 1 to 1e+09, got 1000'),
    ({'dwell': 10**309}, 'dwell must be a number that a float can hold, got 1000'),
    ({'loop': 1}, 'loop must be true or false'),
    ({'profile': 'step'}, 'profile must be one of steps, staircase'),
    ({'levels': []}, 'levels must be a list of numbers'),
    ({'levels': 'up'}, 'levels must be a list of numbers'),
    ({'levels': [0.0, math.nan]}, 'levels'),
    ({'levels': [0.0, 0.4524]}, 'levels: 0.4524 is not plausible in A; is it in mA?'),
    ({'mode': 'position', 'levels': [0.8]}, 'levels: 0.8 is not plausible in m; is it in mm or %?'),
    ({'profile': 'triangle', 'low': 2e-4, 'high': 1e-4}, 'low (0.0002) must be below high (0.0'),
    ({'profile': 'csv'}, 'profile: csv needs csv_file'),
    ({'csv_file': 'x.csv'}, 'csv_file goes with profile: csv, and profile is steps'),
    ({'profile': 'csv', 'csv_file': 'nothing.csv'}, 'csv_file: nothing.csv: No such file'),
    ({'record_csv': 5}, 'record_csv must be a text'),
    ({'loop_current_limits': [1e-3, 0.0]}, 'loop_current_limits must be two rising values'),
    ({'loop_current_limits': [0.0]}, 'loop_current_limits must be two rising values'),
    ({'loop': True, 'lockstep': True}, 'loop does not go with lockstep'),
    ({'keep_alive': True, 'lockstep': True}, 'keep_alive does not go with lockstep'),
    ({'profile': 'sines', 'frequencies': [0.1, 0.0]}, 'frequencies'),
])
def test_bad_settings_are_refused_by_name(values, says):
    with pytest.raises(ParameterError, match=re.escape(says)):
        select_profile(check(values))


def test_a_csv_without_the_column_is_refused(tmp_path):
    path = tmp_path / 'profile.csv'
    path.write_text('time,valve_position\n0,0.001\n1,0.002\n')
    values = {'profile': 'csv', 'csv_file': str(path)}
    with pytest.raises(ParameterError, match='has no column control_current'):
        select_profile(check(values))
    assert select_profile(check({**values, 'mode': 'position'})).value(1.5) == 0.002


def test_whole_numbers_are_taken_for_floats():
    settings = check({'rate': 50, 'levels': [0, 0]})
    assert settings.rate == 50.0
    assert settings.levels == (0.0, 0.0)


def test_every_default_is_within_its_limits():
    for description in DESCRIPTIONS.values():
        assert check({description.name: description.default}) == check({})


def test_pi_integrates_and_stops_at_its_limits():
    controller = PiController(gain=2.0, integral_time=4.0, low=-1.0, high=1.0)
    assert controller.update(0.1, 1.0) == pytest.approx(0.2 + 0.05)
    assert controller.update(0.1, 1.0) == pytest.approx(0.2 + 0.10)
    for _ in range(1000):
        assert controller.update(10.0, 1.0) == 1.0
    # Not wound up: it leaves the limit as soon as the error is gone.
    assert controller.update(0.0, 1.0) < 1.0
    for _ in range(1000):
        controller.update(-10.0, 1.0)
    assert controller.update(0.0, 1.0) > -1.0


def test_the_position_loop_holds_the_model_at_the_set_point():
    settings = check({'mode': 'position', 'levels': [0.004, 0.012, 0.0118], 'dwell': 20})
    command = make_command(settings, select_profile(settings))
    plant = Plant(from_values({}), 0.01)
    position = []
    for tick in range(6000):
        current = command.current(tick / 100, plant.outputs().valve_position)
        plant.advance(current, 1)
        position.append(plant.outputs().valve_position)
    reached = np.array(position)
    np.testing.assert_allclose(reached[[1999, 3999, 5999]], [0.004, 0.012, 0.0118], atol=1e-5)
    assert reached[2000:4000].max() < 0.012 + 2e-4
