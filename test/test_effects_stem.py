# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Effects of stops, damper and spring, each by the equation that it is made of."""

import numpy as np
from positioner_runs import current_for, follow_pressure, positioner, rows, triangle
import pytest

from booster_ros.model.simulation import Plant, simulate
from booster_ros.model.start import rests_on_a_stop

AREA, TRAVEL = 0.0796, 0.016
SPRING = AREA * 150e3 / TRAVEL
STOP = 5e8
TIME = rows(40.0)
STROKE = triangle(TIME, 100e3, 350e3, 20.0)


@pytest.mark.parametrize(('lower', 'upper'), [(0.0, 0.25), (0.2, 0.0), (0.2, 0.25)])
def test_a_stem_stops_at_its_limits_and_goes_between_them_as_ever(lower, upper):
    limited = follow_pressure({
        'actuator.lower_travel_lost': lower, 'actuator.upper_travel_lost': upper}, TIME, STROKE)
    declared = follow_pressure(None, TIME, STROKE)
    low, high = lower * TRAVEL, (1.0 - upper) * TRAVEL
    position = limited['valve_position']
    for end, force in (
            (low, AREA * (100e3 - 150e3) - SPRING * low),
            (high, AREA * (350e3 - 150e3) - SPRING * high)):
        at = np.argmin(np.abs(STROKE - (100e3 if force < 0.0 else 350e3)))
        assert position[at] == pytest.approx(end + force / (STOP + SPRING), abs=1e-6)
    inside = (declared['valve_position'] > low + 1e-4) & (declared['valve_position'] < high - 1e-4)
    assert inside.sum() > 500
    assert position[inside] == pytest.approx(declared['valve_position'][inside], abs=2e-6)
    # the pressure goes on though the stem does not
    assert position.max() < high + 60e-6
    assert position.min() > low - 60e-6


@pytest.mark.parametrize(('pressure', 'stop'), [(150e3, 0.2 * TRAVEL), (290e3, 0.75 * TRAVEL)])
def test_a_stem_rests_on_a_limit_as_on_any_stop(pressure, stop):
    p = positioner({'actuator.lower_travel_lost': 0.2, 'actuator.upper_travel_lost': 0.25})
    plant = Plant(p)
    plant.reset(pressure, None, float(current_for(pressure)))
    assert plant.outputs().valve_position == pytest.approx(stop, abs=10e-6)
    assert rests_on_a_stop(p, pressure, stop)
    assert not rests_on_a_stop(positioner(), pressure, stop)


def test_a_stem_that_the_process_pushes_into_its_stop_rests_there():
    p = positioner({'actuator.plug_area': 2e-3})
    assert rests_on_a_stop(p, 160e3, 0.0, 1e6)
    assert not rests_on_a_stop(p, 160e3, 0.0)


def test_a_stem_without_a_booster_starts_where_the_process_pushes_it():
    p = positioner({'actuator.plug_area': 2e-3, 'booster.kind': 'none'})
    time = np.array([0.0, 0.01])
    for given in ({}, {'chamber_pressure': 225e3}):
        run = simulate(p, time, np.full(2, 225e3 / p.ep_converter.gain),
                       given | {'pressure_drop': 2e5})
        assert run['valve_position'] == pytest.approx(8e-3 - 2e-3 * 2e5 / SPRING, abs=5e-6)


def test_a_limited_stroke_sweeps_less_air():
    """While the stem stands q = V/(R T) dp/dt, with the volume that the chamber has at the stop."""
    time = rows(20.0)
    values = {'actuator.upper_travel_lost': 0.5}
    run = simulate(positioner(values), time, np.full_like(time, 0.5e-3), {
        'back_pressure': 260e3, 'chamber_pressure': 240e3})
    standing = (run['chamber_pressure'] > 250e3) & (run['chamber_pressure'] < 330e3)
    volume = 0.185e-3 + AREA * 0.5 * TRAVEL
    rate = np.gradient(run['chamber_pressure'], time)[standing][1:-1]
    assert len(rate) > 20
    assert run['mass_flow'][standing][1:-1] == pytest.approx(
        volume * rate / (287.0 * 293.15), rel=0.05)


@pytest.mark.parametrize('damping', [3e4, 4e5])
def test_a_damper_holds_the_stem_back_in_proportion_to_its_speed(damping):
    lag = (3000.0 + damping) / SPRING
    pressure = np.where(TIME < 10.0, 160e3 + 6e3 * TIME, 220e3)
    run = follow_pressure({'actuator.added_damping': damping}, TIME, pressure)
    speed = 6e3 * AREA / SPRING
    ramp = (9.0 * lag < TIME) & (TIME < 10.0)
    settled = AREA * (pressure - 150e3) / SPRING
    assert (settled - run['valve_position'])[ramp] == pytest.approx(lag * speed, rel=5e-3)
    rest = TIME > 10.0
    after = lag * speed * np.exp(-(TIME[rest] - 10.0) / lag)
    assert (settled - run['valve_position'])[rest] == pytest.approx(after, abs=5e-3 * lag * speed)


@pytest.mark.parametrize('loss', [0.3, -0.2])
def test_a_lost_share_of_the_spring_takes_preload_and_rate_and_bend(loss):
    bend = {'actuator.spring_bend': 300.0}
    whole, changed = (follow_pressure(values, TIME, STROKE) for values in (
        bend, {**bend, 'actuator.spring_loss': loss}))
    up = TIME < 20.0
    levels = np.linspace(2e-3, 14e-3, 7)
    needs = [np.interp(levels, run['valve_position'][up], STROKE[up] - (
        3000.0 * run['stem_velocity'][up] / AREA)) for run in (whole, changed)]
    reached = levels < changed['valve_position'].max() - 1e-4
    assert reached.sum() >= 4
    assert (needs[1] / needs[0])[reached] == pytest.approx(1.0 - loss, abs=5e-4)


def test_seat_and_process_are_no_part_of_the_spring():
    values = {'actuator.flow_force': 800.0, 'actuator.flow_force_decay': 10.0}
    pressure = np.full_like(TIME, 180e3)
    with_it, without = (
        follow_pressure({**more, 'actuator.spring_loss': 0.2}, TIME, pressure)['valve_position'][-1]
        for more in (values, {}))
    force = 800.0 * np.exp(-with_it / TRAVEL / 10.0)
    assert without - with_it == pytest.approx(force / (0.8 * SPRING), abs=1e-6)
