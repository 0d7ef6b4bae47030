# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A run that begins with readings of another one goes on as that one does."""

import numpy as np
from positioner_runs import PAPER_CURRENT, current_for, positioner, rows
import pytest

from booster_ros.diagnosis.estimation.parametrisation import put
from booster_ros.model.memory import CENTRED, Departure
from booster_ros.model.simulation import Plant, simulate
from booster_ros.model.start import rests_on_a_stop, start_of_readings
from booster_ros.model.stream import Stream
from booster_ros.model.system import PositionerParameters

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


def pushed(variable='valve_position', force=-400.0):
    """Return values of a force without a name that closes the stem, whatever the variable."""
    return {'discrepancy.location': 'stem', 'discrepancy.variable': variable,
            'discrepancy.knots': list(np.linspace(-1e9, 1e9, 12)),
            'discrepancy.values': [force] * 12}


def sensor_term(location, variable, low, high, size):
    """Return values of a sensor's term without a name that bends between two of the variable."""
    return {'discrepancy.location': location, 'discrepancy.variable': variable,
            'discrepancy.knots': list(np.linspace(low, high, 12)),
            'discrepancy.values': [size * (0.5 + (k / 11.0)**2) for k in range(12)]}


HIDING = {
    'backlash': {'sensors.position_backlash': 4e-4, 'booster.intake_preload': 0.016,
                 'booster.exhaust_preload': 0.016},
    'backlash beside a force': {
        'sensors.position_backlash': 4e-4, 'booster.intake_preload': 0.016,
        'booster.exhaust_preload': 0.016, **pushed()},
    'hysteresis': {'ep_converter.hysteresis': 5e-6},
    'hysteresis of a valve that leaks': {
        'ep_converter.hysteresis': 5e-6, 'actuator.leak_area': 5e-8},
    'hysteresis behind a tube': {
        'ep_converter.hysteresis': 5e-6, 'tubing.restriction_area': 2e-6},
    'a term of the pressure sensor': {
        'ep_converter.hysteresis': 5e-6, 'sensors.pressure_bias': 3e3,
        **sensor_term('pressure_sensor', 'chamber_pressure', 0.0, 300e3, 8e3)},
    'a term of the position sensor': {
        'sensors.position_backlash': 4e-4, 'booster.intake_preload': 0.016,
        'booster.exhaust_preload': 0.016, 'sensors.position_span_error': 0.05,
        **sensor_term('position_sensor', 'valve_position', -1e-3, 17e-3, -2e-3)},
    'bias': {'sensors.pressure_bias': 3e3, 'sensors.pressure_span_error': 0.05,
             'sensors.position_bias': 5e-4, 'sensors.position_span_error': 0.05},
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
    assert departure == CENTRED


def test_readings_of_one_channel_or_none_will_do():
    p = positioner({'sensors.position_backlash': 4e-4, 'ep_converter.hysteresis': 5e-6})
    assert start_of_readings(p, 0.0, PAPER_CURRENT, {})[0] == {}
    for name, value in (('chamber_pressure', 187654.0), ('valve_position', 0.0061)):
        assert start_of_readings(p, 0.0, PAPER_CURRENT, {name: value})[0] == {name: value}


@pytest.mark.parametrize(('location', 'name', 'size'), [
    ('pressure_sensor', 'chamber_pressure', 5e3), ('position_sensor', 'valve_position', -1e-3)])
@pytest.mark.parametrize(('variable', 'low', 'high'), [
    ('time', -1.0, 1e3), ('control_current', 0.0, 1e-3), ('back_pressure', 0.0, 300e3),
    ('chamber_pressure', 0.0, 300e3), ('valve_position', 0.0, 0.016),
    ('booster_force', -1.0, 1.0), ('chamber_pressure_change', -1e5, 1e5)])
def test_the_first_row_reads_what_was_given(location, name, size, variable, low, high):
    """Whatever the sensor's term goes by, and whether both readings are given or its own alone."""
    p = positioner(sensor_term(location, variable, low, high, size))
    both = {'chamber_pressure': 200e3, 'valve_position': 5e-3}
    for readings in (both, {name: both[name]}):
        state, departure = start_of_readings(p, 0.0, 0.43e-3, readings)
        first = Stream(p, 0.0, 0.43e-3, state, compiled=False, departure=departure).advance(
            np.zeros(1), np.full(1, 0.43e-3))
        for reading, value in readings.items():
            assert first[f'measured_{reading}'][0] == pytest.approx(value, rel=1e-8)
        assert abs(first[name][0] - readings[name]) > 0.001 * abs(size)


RIGID = {'actuator.coulomb_friction': 500.0, 'actuator.stiction': 200.0}
YIELDING = RIGID | {'actuator.presliding_stiffness': 2e7}


def rested(p, current, state):
    """Return a second from this state on in which the current stands."""
    time = rows(1.0)
    return Stream(p, 0.0, current, state).advance(time, np.full_like(time, current))


@pytest.mark.parametrize('values', [RIGID, YIELDING], ids=['rigid', 'yielding'])
@pytest.mark.parametrize('side', [1.0, -1.0], ids=['upwards', 'downwards'])
def test_noise_in_its_readings_does_not_tear_a_stem_loose(values, side):
    """In the reading the friction is exceeded by what 200 Pa and 8 µm are worth."""
    p = positioner(values)
    act = p.actuator
    stiffness = act.effective_area * (act.bench_set[1] - act.bench_set[0]) / act.travel
    position = 0.008
    balance = act.bench_set[0] + position * stiffness / act.effective_area
    pressure = balance + side * (act.coulomb_friction + act.stiction) / act.effective_area
    readings = {
        'chamber_pressure': pressure + side * 200.0, 'valve_position': position - side * 8e-6}
    current = float(current_for(pressure))
    state = start_of_readings(p, 0.0, current, readings)[0]
    assert np.ptp(rested(p, current, state)['valve_position']) < 10e-6
    assert np.ptp(rested(p, current, readings)['valve_position']) > 40e-6  # it does matter
    assert abs(state['valve_position'] - position) < 30e-6


def test_a_stem_far_from_where_friction_holds_it_moves():
    readings = {'chamber_pressure': 187654.0, 'valve_position': 0.0061}  # 2 mm too far
    assert start_of_readings(positioner(RIGID), 0.0, PAPER_CURRENT, readings)[0] == readings


@pytest.mark.parametrize(('pressure', 'stop'), [(80e3, 0.0), (330e3, 0.016)])
@pytest.mark.parametrize('noise', [25e-6, -25e-6])
def test_a_stem_pressed_against_a_stop_stays_there(pressure, stop, noise):
    """As read it would be pushed out of the stop, or fall into it, and move the air."""
    p, current = positioner(), float(current_for(pressure))
    readings = {'chamber_pressure': pressure, 'valve_position': stop + noise}

    def moved(state):
        return np.abs(rested(p, current, state)['chamber_pressure'] - pressure).max()

    assert moved(start_of_readings(p, 0.0, current, readings)[0]) < 30.0
    assert moved(readings) > 100.0


@pytest.mark.parametrize(('pressure', 'stop', 'after'), [
    (97e3, 0.0, 250e3), (330e3, 0.016, 200e3)])
def test_noise_in_a_reading_does_not_load_the_packing_of_a_stem_on_its_stop(pressure, stop, after):
    """A micrometre in the stop is 500 N, and a packing that yields by 35 µm keeps what it holds."""
    p, time = positioner(YIELDING), rows(1.0)
    current = np.where(time < 0.1, current_for(pressure), current_for(after))

    def moved(state):
        return Stream(p, 0.0, current[0], state).advance(time, current)['valve_position']

    readings = [{'chamber_pressure': pressure, 'valve_position': stop + noise}
                for noise in (-25e-6, 25e-6)]
    low, high = (moved(start_of_readings(p, 0.0, current[0], read)[0]) for read in readings)
    assert np.ptp(low) > 1e-4
    np.testing.assert_array_equal(low, high)
    as_read = [moved(read) for read in readings]
    assert np.abs(as_read[0] - as_read[1])[time > 0.2].max() > 5e-6  # it would matter


def test_a_stem_that_friction_may_hold_beside_its_stop_is_where_it_is_read():
    p = positioner(YIELDING)
    pressure = p.actuator.bench_set[0] - 300.0 / p.actuator.effective_area
    assert not rests_on_a_stop(p, pressure, 60e-6)
    assert rests_on_a_stop(p, pressure - 500.0 / p.actuator.effective_area, 60e-6)
    assert not rests_on_a_stop(p, 97e3, 0.003)
    readings = {'chamber_pressure': pressure, 'valve_position': 60e-6}
    assert start_of_readings(p, 0.0, float(current_for(pressure)), readings)[0] == readings


@pytest.mark.parametrize('variable', [
    'time', 'control_current', 'back_pressure', 'supply_pressure', 'chamber_pressure',
    'valve_position', 'stem_velocity', 'control_current_change', 'chamber_pressure_change',
    'valve_position_change'])
def test_a_stem_starts_where_all_forces_on_it_balance(variable):
    plant = Plant(positioner(pushed(variable, -1000.0)))
    current = float(current_for(225e3))
    plant.reset(225e3, None, current)
    started = plant.outputs().valve_position
    assert started == pytest.approx(0.008 - 1000.0 * 0.016 / (0.0796 * 150e3), abs=1e-7)
    plant.advance(current, 50)
    assert plant.outputs().valve_position == pytest.approx(started, abs=1e-6)


def test_a_stem_starts_where_a_force_that_goes_by_its_position_balances():
    """None in mid travel, closing beyond it: its stiffness and that of the spring add up."""
    values = pushed() | {'discrepancy.knots': list(np.linspace(-1.0, 1.016, 12)),
                         'discrepancy.values': list(np.linspace(6e5, -6e5, 12))}
    stiffness = 0.0796 * 150e3 / 0.016 + 12e5 / 2.016
    current = float(current_for(240e3))
    run = simulate(positioner(values), np.array([0.0, 0.05]), np.full(2, current),
                   {'chamber_pressure': 240e3}, compiled=False)
    assert run['valve_position'] == pytest.approx(0.008 + 0.0796 * 15e3 / stiffness, abs=1e-6)


def test_a_stem_that_a_force_presses_against_its_stop_stays_there():
    p, current = positioner(pushed(force=-3000.0)), float(current_for(180e3))
    readings = {'chamber_pressure': 180e3, 'valve_position': 25e-6}
    state = start_of_readings(p, 0.0, current, readings)[0]
    assert -10e-6 < state['valve_position'] < 0.0


def test_a_supply_that_droops_starts_at_what_it_is_at_no_flow():
    values = {'discrepancy.location': 'supply',
              'discrepancy.knots': list(np.linspace(-1.0, 1e3, 12)),
              'discrepancy.values': [10e3] * 12,
              'supply.droop': 2e7, 'supply.droop_time_constant': 1.0}
    time = np.array([0.0, 0.5, 2.0])
    run = simulate(positioner(values), time, np.zeros(3), compiled=False)
    assert run['supply_pressure'] == pytest.approx(410e3, abs=1.0)


def test_warm_air_in_a_shut_chamber_loses_pressure_until_it_is_as_cold_as_its_wall():
    shut = put(put(PositionerParameters(), 'booster.opening_gain', 0.0),
               'actuator.thermal_resistance', 1.0)
    time = np.arange(0.0, 60.0, 0.1)
    still = np.zeros_like(time)
    given = {'chamber_pressure': 1e5}

    def pressure(parameters, warmth):
        return simulate(parameters, time, still, given,
                        departure=Departure(temperature=warmth))['chamber_pressure']

    warm = pressure(shut, 20.0)
    absolute = 101325.0 + warm
    ambient = shut.supply.temperature
    assert absolute[-1] / absolute[0] == pytest.approx(ambient / (ambient + 20.0), rel=1e-3)
    assert np.ptp(pressure(shut, 0.0)) < 1.0
    assert np.ptp(pressure(put(shut, 'actuator.thermal_resistance', 0.0), 20.0)) < 1.0


def test_a_stem_whose_friction_fades_along_the_travel_keeps_moving_sensibly():
    act = PositionerParameters().actuator._replace(coulomb_friction=18.3, friction_gradient=-25.4,
                              presliding_stiffness=2.76e6, viscous_friction=150.0)
    time = np.arange(0.0, 20.0, 0.08)
    current = np.where(np.sin(time) > 0.0, 4.7e-4, 4.0e-4)
    run = simulate(PositionerParameters()._replace(actuator=act), time, current,
                   {'chamber_pressure': 2.76e5, 'valve_position': 0.01347})
    position = run['valve_position']
    assert np.all(np.isfinite(position))
    assert -1e-4 < position.min() < position.max() < act.travel + 1e-4
    assert np.ptp(position) > 0.002
