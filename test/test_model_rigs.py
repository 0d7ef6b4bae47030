# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Rigs that lack the booster or the stem: the converter feeds the chamber, or nothing moves."""

import math

import numpy as np
from positioner_runs import GAIN, positioner, rows
import pytest

from booster_ros.model.simulation import Plant, simulate
from booster_ros.model.start import start_of_readings
from booster_ros.model.stream import Stream

ATMOSPHERE, WARMTH, VOLUME = 101_325.0, 287.0 * 293.15, 0.185e-3
NO_BOOSTER, VESSEL = {'booster.kind': 'none'}, {'actuator.kind': 'vessel'}
TUBE = {'tubing.restriction_area': 4e-7}
TIME = rows(12.0)
CURRENT = np.select([TIME < 5.0, TIME < 9.0], [250e3 / GAIN, 90e3 / GAIN], 200e3 / GAIN)


def orifice(upstream, downstream, area):
    """Return the flow, kg/s, between absolute pressures by ISO 6358, written out."""
    beyond = max(downstream / upstream - 0.5283, 0.0) / 0.4717
    return 0.0404184 * area * upstream / math.sqrt(293.15) * math.sqrt(max(1.0 - beyond**2, 0.0))


def filled(source, area, time, parts=200):
    """Return the pressure of a vented vessel behind an orifice, by short steps of Euler."""
    pressure, seen = 0.0, []
    for k, moment in enumerate(time):
        seen.append(pressure)
        step = (time[min(k + 1, len(time) - 1)] - moment) / parts
        for _ in range(parts):
            high, low = max(source[k], pressure), min(source[k], pressure)
            flow = orifice(high + ATMOSPHERE, low + ATMOSPHERE, area)
            pressure += step * WARMTH / VOLUME * (flow if source[k] > pressure else -flow)
    return np.array(seen)


def test_without_a_booster_the_converter_feeds_the_tube():
    """A vessel behind a tube whose beginning has the back pressure, which is given."""
    time = rows(4.0)
    source = np.where(time < 2.0, 250e3, 60e3)
    held = simulate(positioner({**NO_BOOSTER, **VESSEL, **TUBE}), time, np.zeros_like(time),
                    {'chamber_pressure': 0.0}, {'back_pressure': source})
    # what is given runs straight from row to row, and stands in an interval's middle
    standing = 0.5 * (source + np.append(source[1:], source[-1]))
    assert held['chamber_pressure'] == pytest.approx(filled(standing, 4e-7, time), abs=300.0)
    assert np.ptp(held['chamber_pressure']) > 150e3
    assert np.array_equal(held['outlet_pressure'], source)
    for name in ('booster_force', 'intake_area', 'exhaust_area'):
        assert np.all(held[name] == 0.0), name


@pytest.mark.parametrize('tube', [TUBE, {}], ids=['with a tube', 'with nothing between'])
@pytest.mark.parametrize('rest', [{}, {'actuator.leak_area': 3e-8}], ids=['tight', 'leaking'])
def test_no_air_is_made_or_lost(tube, rest):
    time = rows(6.0, 1e-3)
    current = 200e3 / GAIN * (1.0 + 0.3 * np.sin(time))
    run = simulate(positioner({**NO_BOOSTER, **tube, **rest}), time, current,
                   {'back_pressure': 200e3, 'chamber_pressure': 200e3})
    mass = (run['chamber_pressure'] + ATMOSPHERE) / WARMTH * (
        VOLUME + 0.0796 * run['valve_position'])
    leak = np.array([orifice(p + ATMOSPHERE, ATMOSPHERE, 3e-8) if rest else 0.0
                     for p in run['chamber_pressure']])
    inflow = run['mass_flow'] - leak
    gained = np.concatenate(([0.0], np.cumsum(0.5 * (inflow[1:] + inflow[:-1]) * np.diff(time))))
    start = 500
    assert (mass - mass[start])[start:] == pytest.approx(
        (gained - gained[start])[start:], abs=2e-3 * np.ptp(mass))
    assert np.ptp(mass) > 1e-4


def test_where_nothing_restricts_the_chamber_has_the_pressure_of_the_converter():
    run = simulate(positioner(NO_BOOSTER), TIME, CURRENT)
    lag = 90e3 + 160e3 * np.exp(-(TIME - 5.0) / 0.034)
    venting = (TIME >= 5.0) & (TIME < 9.0)
    assert run['chamber_pressure'][venting] == pytest.approx(lag[venting], abs=20.0)
    for name in ('back_pressure', 'outlet_pressure'):
        assert np.array_equal(run[name], run['chamber_pressure']), name
    given = 200e3 + 20e3 * np.sin(TIME)
    held = simulate(positioner(NO_BOOSTER), TIME, CURRENT, pinned={'back_pressure': given})
    assert np.array_equal(held['chamber_pressure'], given)
    free = simulate(positioner(), TIME, CURRENT, pinned={'chamber_pressure': given})
    assert held['valve_position'] == pytest.approx(free['valve_position'], abs=2e-6)


def test_a_wider_and_wider_tube_is_none():
    direct = simulate(positioner(NO_BOOSTER), TIME, CURRENT)
    wide = simulate(positioner({**NO_BOOSTER, 'tubing.restriction_area': 0.05}), TIME, CURRENT,
                    {'chamber_pressure': float(direct['chamber_pressure'][0])})
    assert wide['chamber_pressure'] == pytest.approx(direct['chamber_pressure'], abs=500.0)


@pytest.mark.parametrize('rest', [
    {}, NO_BOOSTER, {'actuator.coulomb_friction': 300.0, 'actuator.stiction': 100.0},
    {'actuator.coulomb_friction': 300.0, 'actuator.presliding_stiffness': 1e7},
    {'actuator.seat_load': 500.0, 'actuator.bench_set': [20e3, 80e3]}],
    ids=lambda values: ' '.join(values) or 'declared')
def test_in_a_vessel_nothing_moves(rest):
    run = simulate(positioner({**VESSEL, **TUBE, **rest}), TIME, CURRENT)
    for name in ('valve_position', 'stem_velocity', 'measured_valve_position'):
        assert np.all(run[name] == 0.0), name
    alike = simulate(positioner({**VESSEL, **TUBE, **(NO_BOOSTER if rest == NO_BOOSTER else {})}),
                     TIME, CURRENT)
    assert np.array_equal(run['chamber_pressure'], alike['chamber_pressure'])
    assert np.ptp(run['chamber_pressure']) > 100e3


@pytest.mark.parametrize('values', [
    NO_BOOSTER, {**NO_BOOSTER, **TUBE}, {**VESSEL, 'actuator.thermal_resistance': 2.0},
    {**NO_BOOSTER, **VESSEL, **TUBE, 'actuator.thermal_resistance': 2.0, 'supply.droop': 2e7},
    {**NO_BOOSTER, 'actuator.thermal_resistance': 2.0, 'supply.droop': 2e7,
     'actuator.coulomb_friction': 200.0}], ids=lambda values: ' '.join(values))
def test_machine_code_plain_python_and_the_stepping_plant_agree(values):
    p, time = positioner(values), rows(0.6)
    current = np.where(time < 0.3, 250e3, 160e3) / GAIN
    machine, plain = (simulate(p, time, current, compiled=compiled) for compiled in (True, False))
    for name, column in plain.columns.items():
        assert np.array_equal(machine[name], column), name
    plant = Plant(p, 0.01)
    plant.reset(control_current=current[0])
    for k in range(60):
        plant.advance(current[k], 1)
    assert plant.outputs().chamber_pressure == pytest.approx(
        machine['chamber_pressure'][-1], abs=5.0)


def test_a_vessel_with_a_wall_warms_and_relaxes():
    """Filled fast it is warmer, and its pressure falls with its temperature when shut off."""
    time = rows(1.0)
    filling = {**VESSEL, 'actuator.thermal_resistance': 5.0}
    run = simulate(positioner(filling), time, np.full_like(time, 1e-3))
    start = {name: run[name][-1] for name in ('chamber_pressure', 'gas_temperature')}
    rest = rows(60.0)
    shut = simulate(positioner({**filling, 'booster.max_area': 0.0}), rest, np.zeros_like(rest),
                    start)
    ratio = (shut['chamber_pressure'] + ATMOSPHERE) / shut['gas_temperature']
    assert start['gas_temperature'] > 296.0
    assert shut['gas_temperature'][-1] == pytest.approx(293.15, abs=0.1)
    assert ratio == pytest.approx(ratio[0], rel=1e-6)


def test_parts_that_are_switched_take_the_state_with_them():
    plant = Plant(positioner())
    plant.reset(200e3, None, 4.3e-4)
    plant.parameters = positioner({**NO_BOOSTER, **TUBE})
    assert plant.outputs().chamber_pressure == 200e3
    plant.parameters = positioner({**NO_BOOSTER, **TUBE, **VESSEL})
    assert plant.outputs().valve_position == 0.0
    plant.parameters = positioner()
    plant.advance(4.3e-4, 3000)
    assert plant.outputs().valve_position > 3e-3


def test_a_hysteresis_begins_where_the_chamber_behind_the_tube_is_at_rest():
    p = positioner({**NO_BOOSTER, **TUBE, 'ep_converter.hysteresis': 5e-6})
    current = 200e3 / GAIN
    pressure = 200e3 - 0.4 * 5e-6 * GAIN
    state, departure = start_of_readings(p, 0.0, current, {'chamber_pressure': pressure})
    assert departure.ep_play == pytest.approx(-0.8, abs=1e-6)
    again = Stream(p, 0.0, current, state, departure=departure).advance(
        TIME, np.full_like(TIME, current))
    assert np.ptp(again['chamber_pressure']) < 5.0
