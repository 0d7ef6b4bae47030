# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Effects of the sensors: they change what is read and nothing else."""

from functools import cache

import numpy as np
from positioner_runs import (
    PAPER_CURRENT,
    follow_pressure,
    loop_width,
    paper_test,
    positioner,
    rows,
    triangle,
)
import pytest

from booster_ros.model.sensors import (
    position_behind, position_reading, pressure_behind, pressure_reading)
from booster_ros.model.simulation import simulate

LEG = 30.0
TIME, CURRENT = paper_test()
SENSOR_VALUES = {
    'sensors.pressure_bias': 2e3, 'sensors.pressure_span_error': 0.03, 'sensors.pressure_lag': 0.2,
    'sensors.position_bias': 3e-4, 'sensors.position_span_error': 0.03, 'sensors.position_lag': 0.1,
    'sensors.position_backlash': 2e-4,
}


@cache
def declared():
    return simulate(positioner(), TIME, CURRENT)


def reading(values, name):
    return simulate(positioner(values), TIME, CURRENT)[f'measured_{name}']


@pytest.mark.parametrize('name', SENSOR_VALUES)
def test_a_sensor_changes_its_own_reading_and_nothing_else(name):
    run = simulate(positioner({name: SENSOR_VALUES[name]}), TIME, CURRENT)
    own = 'measured_chamber_pressure' if 'pressure' in name else 'measured_valve_position'
    for column, values in declared().columns.items():
        assert np.array_equal(run[column], values) == (column != own), column


def test_ideal_sensors_read_the_truth():
    for name in ('chamber_pressure', 'valve_position'):
        assert np.array_equal(declared()[f'measured_{name}'], declared()[name])


def test_biases_are_there_in_every_state():
    pressure = reading({'sensors.pressure_bias': 2e3}, 'chamber_pressure')
    assert pressure - declared()['chamber_pressure'] == pytest.approx(2e3, abs=1e-6)
    position = reading({'sensors.position_bias': -3e-4}, 'valve_position')
    assert position - declared()['valve_position'] == pytest.approx(-3e-4, abs=1e-12)


@pytest.mark.parametrize('name', ['valve_position', 'chamber_pressure'])
def test_a_span_error_grows_with_what_is_read(name):
    sensor = 'sensors.pressure_span_error' if 'pressure' in name else 'sensors.position_span_error'
    assert reading({sensor: 0.03}, name) == pytest.approx(1.03 * declared()[name], rel=1e-12)


def test_what_is_behind_a_reading_is_found_again():
    sensors = positioner({
        'sensors.pressure_bias': 3e3, 'sensors.pressure_span_error': -0.2,
        'sensors.position_bias': -2e-4, 'sensors.position_span_error': 0.1}).sensors
    assert pressure_reading(sensors, 100e3) == pytest.approx(83e3)
    assert position_reading(sensors, 0.01) == pytest.approx(0.0108)
    assert pressure_behind(sensors, pressure_reading(sensors, 123e3)) == pytest.approx(123e3)
    assert position_behind(sensors, position_reading(sensors, 7e-3)) == pytest.approx(7e-3)


@pytest.mark.parametrize(('name', 'lag'), [('chamber_pressure', 0.3), ('valve_position', 0.15)])
def test_a_lag_is_behind_by_its_time_constant_on_a_ramp_and_right_at_rest(name, lag):
    time = rows(30.0)
    pressure = np.where(time < 15.0, 160e3 + 5e3 * time, 235e3)
    sensor = 'sensors.' + name.split('_')[1].replace('position', 'position_lag').replace(
        'pressure', 'pressure_lag')
    run = follow_pressure({sensor: lag}, time, pressure)
    behind = run[name] - run[f'measured_{name}']
    slope = np.gradient(run[name], time)
    ramp = (time > 5.0) & (time < 14.9)
    assert behind[ramp] == pytest.approx(lag * slope[ramp], rel=1e-3)
    assert abs(behind[-1]) < 1e-6 * run[name][-1]


def test_backlash_reads_flat_at_a_reversal_while_the_pressure_slope_stays():
    width = 4e-4
    time = rows(4.0 * LEG)
    pressure = triangle(time, 170e3, 280e3, LEG)
    run = follow_pressure({'sensors.position_backlash': width}, time, pressure)
    true, read = run['valve_position'], run['measured_valve_position']
    levels = np.array([6e-3, 9e-3])
    # a loop of constant width in the reading, none in the stem
    up, down = (loop_width(time, LEG, pressure, x, 150e3 + 150e3 * levels / 0.016)
                for x in (read, true))
    assert up - down == pytest.approx(-width, rel=1e-3)
    turning = (time > LEG) & (true > true.max() - 0.95 * width) & (time < 1.5 * LEG)
    assert np.ptp(read[turning]) < 1e-6
    assert np.ptp(true[turning]) > 0.9 * width
    # unlike friction, which would hold the stem and let the pressure fall faster than spring rate
    slope = np.diff(true[turning]) / np.diff(pressure[turning])
    assert slope[2:] == pytest.approx(0.016 / 150e3, rel=1e-2)


@pytest.mark.parametrize('location', ['pressure_sensor', 'position_sensor'])
def test_a_tabulated_sensor_term_is_added_to_the_reading(location):
    name = {'pressure_sensor': 'chamber_pressure', 'position_sensor': 'valve_position'}[location]
    high = {'pressure_sensor': 220e3, 'position_sensor': 0.011}[location]
    size = {'pressure_sensor': 11e2, 'position_sensor': 11e-5}[location]
    values = {
        'discrepancy.location': location, 'discrepancy.variable': name,
        'discrepancy.knots': list(np.linspace(0.0, high, 12)),
        'discrepancy.values': [size * k / 11.0 for k in range(12)],
    }
    true = declared()[name]
    inside = (true >= 0.0) & (true <= high)
    added = reading(values, name) - true
    assert added == pytest.approx(np.where(inside, size * true / high, 0.0), abs=1e-6 * size)
    assert inside.any()
    assert not inside.all()


def test_the_paper_current_moves_both_readings():
    """What the cases above rest on."""
    assert CURRENT.max() == PAPER_CURRENT
    assert np.ptp(declared()['valve_position']) > 0.012
