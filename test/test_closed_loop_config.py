# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The valve in config/closed_loop.yaml does what is said of it, in `simulate` and in its URDF."""

from xml.etree import ElementTree

import numpy as np
import pytest
from ros_process import ROOT

from booster_ros.metrics.figures import figures_of
from booster_ros.model.parameters import from_values
from booster_ros.model.simulation import Plant, simulate
from booster_ros.parameters.file import read_parameter_file
from booster_ros.records import Record

CONFIG = ROOT / 'config' / 'closed_loop.yaml'
PARAMETERS = from_values(read_parameter_file(CONFIG).physical)
TRAVEL, MIDDLE, ROW = 0.016, 0.008, 0.01


def figures_after(levels, dwell):
    """Return the figures of the valve over levels of the set point (shares of travel, from it)."""
    time = np.arange(round(len(levels) * dwell / ROW)) * ROW
    place = np.minimum((time / dwell + 1e-9).astype(int), len(levels) - 1)
    set_point = MIDDLE + TRAVEL * np.array(levels)[place]
    run = simulate(PARAMETERS, time, set_point, {'chamber_pressure': 225e3, 'valve_position': 8e-3})
    return figures_of(Record({
        'time': time, 'set_point': set_point, 'valve_position': run['measured_valve_position'],
    }, 'closed loop', (), np.arange(len(time)) + 2))


def test_the_response_times_and_overshoots_are_those_of_the_file():
    steps = figures_after([0.0, 0.01, 0.0, 0.1, 0.0, 0.25, -0.25, 0.0], 20.0).steps
    said = {0: (0.12, 0.0), 1: (0.21, 0.0), 2: (0.26, 0.024), 3: (0.38, 0.042), 5: (1.86, 0.011)}
    for k, (t63, overshoot) in said.items():
        assert steps[k].t63 == pytest.approx(t63, abs=0.006), k
        assert steps[k].overshoot == pytest.approx(overshoot, abs=0.005), k


def test_the_dead_band_is_that_of_the_file():
    levels = 0.00025 * np.array([0, 5, 10, *range(9, -6, -1)])
    bound = figures_after(levels, 25.0).dead_band
    assert bound.without_motion / TRAVEL < 0.00226
    assert bound.with_motion / TRAVEL > 0.00199
    assert bound.with_motion - bound.without_motion == pytest.approx(0.00025 * TRAVEL)


def test_the_file_is_the_papers_positioner_with_a_controller():
    paper = from_values(read_parameter_file(ROOT / 'config' / 'positioner.yaml').physical)
    assert PARAMETERS._replace(position_controller=paper.position_controller) == paper
    assert PARAMETERS.position_controller.enabled


def test_no_stop_of_the_valve_yields_beyond_the_limits_of_its_urdf():
    robot = ElementTree.parse(ROOT / 'urdf' / 'control_valve.urdf').getroot()
    limit = robot.find('joint/limit')
    plant = Plant(PARAMETERS)
    for pressure, current in ((0.0, 0.0), (400e3, 0.74e-3)):
        plant.reset(pressure, None, current)
        position = plant.outputs().valve_position
        assert not 0.0 <= position <= TRAVEL  # a stop yields
        assert float(limit.get('lower')) < position < float(limit.get('upper'))
    names = {robot.find('joint').get('name'), robot.find('ros2_control/joint').get('name')}
    assert names == {'valve_stem'}
