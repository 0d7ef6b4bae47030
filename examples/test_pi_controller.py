# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The controller of `pi_controller.py` against the valve: whole, with friction, stuck, cut off."""

from pi_controller import HIGHEST, LOWEST, PiController
import pytest

pytest_plugins = ['booster_ros.testing.fixtures']


@pytest.fixture
def controller(valve):
    """Return a controller that has brought the stem to the middle of its travel."""
    controller = PiController(valve.context)
    valve.add(controller)
    controller.set_point = 0.008
    valve.settle()
    return controller


def test_it_settles_where_it_is_told(valve, controller):
    assert valve.now.valve_position == pytest.approx(0.008, abs=1e-4)


def test_friction_slows_it_down(valve, controller):
    valve.inject('stem_friction', strength='medium')
    controller.set_point = 0.010
    valve.run(60.0).assert_reaches('valve_position', 0.010, within=5e-4)


def test_a_stuck_sensor_drives_the_current_no_further_than_its_limits(valve, controller):
    valve.inject('position_sensor_stuck')
    controller.set_point = 0.012
    valve.run(20.0).assert_between('control_current', LOWEST, HIGHEST)


def test_it_comes_back_after_the_supply_was_lost(valve, controller):
    valve.inject('supply_loss', duration=20.0)
    valve.run(20.0)
    valve.run(60.0).assert_reaches('valve_position', 0.008, within=2e-4)
