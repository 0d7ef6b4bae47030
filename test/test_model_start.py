# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A run that begins with readings of another one goes on as that one does."""

import numpy as np
from positioner_runs import PAPER_CURRENT, positioner, rows
import pytest

from booster_ros.model.simulation import simulate
from booster_ros.model.start import start_of_readings
from booster_ros.model.stream import Stream

TIME = rows(24.0)
RISE = np.select([TIME < 8.0, TIME < 16.0], [0.9 * PAPER_CURRENT, 0.97 * PAPER_CURRENT],
                 PAPER_CURRENT)
FALL = np.select([TIME < 8.0, TIME < 16.0], [PAPER_CURRENT, 0.93 * PAPER_CURRENT],
                 0.9 * PAPER_CURRENT)
WHEN = 1400  # the second current has stood for six seconds


def gone_on(values, current, place=WHEN):
    """Return a run from its middle on, another from its readings there, and where that started."""
    p = positioner(values)
    run = simulate(p, TIME, current)
    state, departure = start_of_readings(p, TIME[place], current[place], {
        name: run[f'measured_{name}'][place] for name in ('chamber_pressure', 'valve_position')})
    again = Stream(p, TIME[place], current[place], state, departure=departure).advance(
        TIME[place:], current[place:])
    return {name: run[name][place:] for name in again}, again, departure


HIDING = {
    'backlash': {'sensors.position_backlash': 4e-4, 'booster.intake_preload': 0.016,
                 'booster.exhaust_preload': 0.016},
    'hysteresis': {'ep_converter.hysteresis': 5e-6},
    'hysteresis of a valve that leaks': {
        'ep_converter.hysteresis': 5e-6, 'actuator.leak_area': 5e-8},
    'hysteresis behind a tube': {
        'ep_converter.hysteresis': 5e-6, 'tubing.restriction_area': 2e-6},
    'bias': {'sensors.pressure_bias': 3e3, 'sensors.position_bias': 5e-4,
             'sensors.position_span_error': 0.05},
}


@pytest.mark.parametrize('current', [RISE, FALL], ids=['after a rise', 'after a fall'])
@pytest.mark.parametrize('hidden', HIDING)
def test_what_readings_do_not_show_is_where_nothing_moves(hidden, current):
    run, again, _ = gone_on(HIDING[hidden], current)
    assert np.abs(again['chamber_pressure'] - run['chamber_pressure']).max() < 60.0
    assert np.abs(again['measured_chamber_pressure'] - run['measured_chamber_pressure']
                  ).max() < 60.0
    assert np.abs(again['measured_valve_position'] - run['measured_valve_position']).max() < 5e-6


@pytest.mark.parametrize(('current', 'end'), [(RISE, -1.0), (FALL, 1.0)])
def test_a_converter_in_motion_is_at_the_end_of_its_play(current, end):
    _, _, departure = gone_on(HIDING['hysteresis'], current, place=805)  # 50 ms after a step
    assert departure.ep_play == end


def test_where_nothing_is_hidden_readings_are_the_state():
    readings = {'chamber_pressure': 187654.0, 'valve_position': 0.0061}
    state, departure = start_of_readings(positioner(), 0.0, PAPER_CURRENT, readings)
    assert state == readings
    assert departure == (0.0, 0.0, 0.0, 0.0)


def test_readings_of_one_channel_or_none_will_do():
    p = positioner({'sensors.position_backlash': 4e-4, 'ep_converter.hysteresis': 5e-6})
    assert start_of_readings(p, 0.0, PAPER_CURRENT, {})[0] == {}
    for name, value in (('chamber_pressure', 187654.0), ('valve_position', 0.0061)):
        assert start_of_readings(p, 0.0, PAPER_CURRENT, {name: value})[0] == {name: value}
