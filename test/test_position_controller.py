# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The position controller beside the same equations written anew, and the loop that it closes."""

from itertools import pairwise
import math

import numpy as np
from positioner_runs import positioner, rows
import pytest

from booster_ros.model.control_law import at_rest
from booster_ros.model.controlled_plant import ControlledPlant, make_plant
from booster_ros.model.ensemble import simulate_ensemble
from booster_ros.model.parameters import DESCRIPTIONS, ParameterError
from booster_ros.model.position_controller import PositionController, set_point_of
from booster_ros.model.simulation import Plant, simulate
from booster_ros.model.stream import Stream

TRAVEL, AREA, DEAD_VOLUME = 0.016, 0.0796, 0.185e-3
PERIOD = 0.01
TIME = rows(16.0, PERIOD)
STEPS = np.select([TIME < 1.0, TIME < 5.0, TIME < 9.0, TIME < 12.0], [4e-3, 9e-3, 7e-3, 0.1e-3],
                  15.9e-3)
MIDDLE = {'chamber_pressure': 150e3 + 37.5e3, 'valve_position': 4e-3}

PI = {'dead_zone': 30e-6}
VELOCITY = {'integral_time': 0.0, 'gain': 0.1, 'derivative_time': 0.05, 'derivative_filter': 0.03,
            'feedback_resolution': 4e-6, 'output_resolution': 1e-6}
PULSES = {'output': 'pulses', 'gain': 0.005, 'derivative_time': 0.2, 'dead_zone': 20e-6,
          'pulse_slew': 5e-3, 'least_pulse': 1e-3}
SEEN = {'feedback_backlash': 0.2e-3, 'feedback_lag': 0.05, 'feedback_span_error': 0.03,
        'feedback_bias': -0.1e-3}
SET_POINT = {'set_point_lag': 0.3, 'set_point_second_lag': 0.2, 'rate_limit_up': 2e-3,
             'rate_limit_down': 5e-3}
SHUT = {'tight_shut_off': 0.02, 'full_open': 0.98}
TABLE = (0.0, 0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 0.85, 0.95, 1.0)
FIRMWARES = {
    'PI': PI, 'velocity feedback': VELOCITY, 'pulses': PULSES,
    'PI through a linkage': PI | SEEN, 'pulses through a linkage': PULSES | SEEN,
    'filter and rate limit': PI | SET_POINT, 'cut-offs': PI | SHUT,
    'cut-offs by pulses': PULSES | SHUT,
    'cut-offs, air closes': PI | SHUT | {'action': 'air_to_close'},
    'equal percentage': {'characteristic': 'equal_percentage', 'rangeability': 30.0},
    'equal percentage, air closes': {'characteristic': 'equal_percentage', 'rangeability': 30.0,
                                     'action': 'air_to_close'},
    'table': VELOCITY | {'characteristic': 'table', 'characteristic_table': TABLE},
}


def loop(values=None, others=None):
    """Return a positioner with its controller on; `values` are the controller's."""
    return positioner({'position_controller.enabled': True, **(others or {})} | {
        f'position_controller.{name}': value for name, value in (values or {}).items()})


def followed(values, set_points):
    """Return what the filters, the characteristic and the rate limit make of the set points."""
    signals, last = [], set_points[0]
    first = second = set_points[0]
    targets = []
    for set_point in set_points:
        for name in ('set_point_lag', 'set_point_second_lag'):
            if values.get(name):
                share = 1.0 - math.exp(-PERIOD / values[name])
                if name == 'set_point_lag':
                    first += share * (set_point - first)
                else:
                    second += share * (first - second)
        filtered = second if 'set_point_second_lag' in values else set_point
        shuts = values.get('action') == 'air_to_close'
        signal = 1.0 - filtered / TRAVEL if shuts else filtered / TRAVEL
        signals.append(signal)
        kind = values.get('characteristic', 'linear')
        if kind == 'equal_percentage':
            signal = (30.0**signal - 1.0) / 29.0
        elif kind == 'table':
            signal = float(np.interp(signal, np.linspace(0.0, 1.0, 11), TABLE))
        target = TRAVEL * (1.0 - signal if shuts else signal)
        if len(targets) == 0 and kind != 'linear':
            last = target
        if 'rate_limit_up' in values:
            last = np.clip(target, last - 5e-3 * PERIOD, last + 2e-3 * PERIOD)
        else:
            last = target
        targets.append(last)
    return np.array(targets), signals


def seen_by_controller(values, positions):
    """Return the positions that the controller sees at its samples."""
    half = 0.5 * values.get('feedback_backlash', 0.0)
    lag = values.get('feedback_lag', 0.0)
    linkage = shown = positions[0]
    seen = []
    for k, position in enumerate(positions):
        before = linkage
        if position > linkage + half:
            linkage = position - half
        elif position < linkage - half:
            linkage = position + half
        if lag and k:
            # x' = (u - x)/lag with u on a straight line: many little Euler steps are independent
            share = PERIOD / 2000 / lag
            fades = (1.0 - share)**np.arange(1999, -1, -1)
            u = before + (linkage - before) * (np.arange(2000) + 0.5) / 2000
            shown = (1.0 - share)**2000 * shown + share * (fades @ u)
        else:
            shown = linkage
        step = values.get('feedback_resolution', 0.0)
        reading = shown * (1.0 + values.get('feedback_span_error', 0.0)) + values.get(
            'feedback_bias', 0.0)
        seen.append(step * math.floor(reading / step + 0.5) if step else reading)
    return np.array(seen)


def currents(values, set_points, positions, start):
    """Return the current at each sample, by the equations of the control law written anew."""
    given = {name: DESCRIPTIONS[f'position_controller.{name}'].default for name in (
        'gain', 'integral_time', 'derivative_time', 'derivative_filter', 'bias', 'dead_zone',
        'pulse_slew', 'least_pulse', 'output_resolution')} | values
    low, high = 0.0, 0.74e-3
    targets, signals = followed(values, set_points)
    seen = seen_by_controller(values, positions)
    integral = start - given['bias'] if given['integral_time'] else 0.0
    current, moved, velocity, cut = start, 0.0, 0.0, ''
    sent = []
    for k, (target, signal, y) in enumerate(zip(targets, signals, seen, strict=True)):
        speed = (y - seen[k - 1]) / PERIOD if k else 0.0
        if given['derivative_filter']:
            velocity += (1.0 - math.exp(-PERIOD / given['derivative_filter'])) * (speed - velocity)
        else:
            velocity = speed
        error = target - y
        zone = given['dead_zone']
        error = error - zone if error > zone else error + zone if error < -zone else 0.0
        if 'tight_shut_off' in values:
            if signal < 0.02 + (0.005 if cut == 'shut' else 0.0):
                cut = 'shut'
            elif signal > 0.98 - (0.005 if cut == 'open' else 0.0):
                cut = 'open'
            else:
                cut = ''
        shuts = values.get('action') == 'air_to_close'
        extreme = high if (cut == 'open') != shuts else low
        damping = given['gain'] * given['derivative_time'] * velocity
        current += moved
        moved = 0.0
        if values.get('output') == 'pulses':
            wish = given['gain'] * error - damping if error else 0.0
            if cut:
                wish = extreme - current
            width = min(abs(wish) / given['pulse_slew'], PERIOD)
            if width >= given['least_pulse']:
                room = high - current if wish > 0.0 else current - low
                moved = math.copysign(min(given['pulse_slew'] * width, room), wish)
        elif cut:
            current = extreme
        else:
            if given['integral_time']:
                more = given['gain'] * error * PERIOD / given['integral_time']
                whole = given['bias'] + given['gain'] * error + integral + more - damping
                if not ((whole > high and more > 0.0) or (whole < low and more < 0.0)):
                    integral += more
            current = given['bias'] + given['gain'] * error + integral - damping
            step = given['output_resolution']
            current = step * math.floor(current / step + 0.5) if step else current
            current = min(max(current, low), high)
        sent.append(current)
    return np.array(sent)


@pytest.mark.parametrize('name', FIRMWARES)
def test_the_current_is_that_of_the_equations(name):
    values = FIRMWARES[name]
    run = simulate(loop(values), TIME, STEPS, MIDDLE)
    alone = currents(values, STEPS, run['valve_position'], run['control_current'][0]
                     if values.get('output') == 'pulses' else held_current())
    assert np.ptp(run['valve_position']) > 2e-3
    assert np.ptp(alone) > 1e-4
    assert run['control_current'] == pytest.approx(alone, abs=5e-9)


def held_current():
    """Return the current that holds 187.5 kPa in the declared booster: F = 0."""
    s1, s2, s3 = 13.52e-6, 9.28e-6, 3.14e-6
    return (187.5e3 * s3 + 400e3 * (s2 - s3)) / s1 / (244.45e3 / 0.4524e-3)


@pytest.mark.parametrize('others', [
    {}, {'ep_converter.dead_time': 0.137}, {'ep_converter.hysteresis': 2e-6},
    {'actuator.coulomb_friction': 200.0, 'actuator.stiction': 50.0}],
    ids=['declared', 'dead time', 'hysteresis', 'friction'])
def test_the_current_of_the_loop_drives_the_open_loop_alike(others):
    """Each row's current stands to the next row, as a record of the loop would have it."""
    run = simulate(loop(PI, others), TIME, STEPS, MIDDLE)
    again = simulate(positioner(others), TIME, run['control_current'], MIDDLE)
    assert again['valve_position'] == pytest.approx(run['valve_position'], abs=2e-8)


@pytest.mark.parametrize('name', ['PI through a linkage', 'velocity feedback', 'pulses'])
@pytest.mark.parametrize('others', [{}, {'ep_converter.dead_time': 0.037}],
                         ids=['at once', 'dead time'])
def test_plain_python_and_machine_code_give_the_same_bits(name, others):
    p = loop(FIRMWARES[name], others)
    time = rows(2.0, 0.008)
    set_point = np.where(time < 0.3, 4e-3, 5e-3)
    machine, plain = (simulate(p, time, set_point, MIDDLE, compiled=c) for c in (True, False))
    for column, values in plain.columns.items():
        assert np.array_equal(machine[column], values), column
    together = simulate_ensemble([p, p], time, set_point, initial=MIDDLE)
    assert np.array_equal(together['valve_position'][1], plain['valve_position'])


@pytest.mark.parametrize('others', [{}, {'ep_converter.dead_time': 0.037}])
def test_where_portions_end_changes_no_bit(others):
    p = loop(FIRMWARES['pulses through a linkage'], others)
    time = rows(3.0, 0.013)
    set_point = np.where(time < 1.0, 4e-3, 5e-3)
    whole = simulate(p, time, set_point, MIDDLE)
    stream = Stream(p, 0.0, 4e-3, MIDDLE)
    edges = [0, 1, 2, 14, 77, 78, 150, len(time)]
    parts = [stream.advance(time[a:b], set_point[a:b]) for a, b in pairwise(edges)]
    for name, column in whole.columns.items():
        assert np.array_equal(np.concatenate([part[name] for part in parts]), column), name


def test_of_rows_with_one_stamp_the_last_set_point_counts():
    time = np.array([0.0, 0.1, 0.1, 0.5])
    twice = simulate(loop(), time, [4e-3, 9e-3, 5e-3, 5e-3], MIDDLE)
    once = simulate(loop(), time, [4e-3, 5e-3, 5e-3, 5e-3], MIDDLE)
    assert twice['valve_position'][-1] == once['valve_position'][-1] > 4.3e-3


@pytest.mark.parametrize('name', ['PI', 'pulses'])
def test_the_plant_in_time_does_as_the_simulation(name):
    p = loop(FIRMWARES[name])
    plant = make_plant(p, 1e-3)
    assert isinstance(plant, ControlledPlant)
    plant.reset(187.5e3, 4e-3)
    for set_point, steps in ((4e-3, 1000), (9e-3, 2000)):
        plant.advance(set_point, steps)
    time = rows(3.0, 1e-3)
    run = simulate(p, time, np.where(time < 1.0 - 1e-9, 4e-3, 9e-3), MIDDLE)
    assert plant.outputs().valve_position == pytest.approx(run['valve_position'][-1], abs=1e-8)
    assert plant.outputs().valve_position > 6e-3
    assert type(make_plant(positioner(), 1e-3)) is Plant


def test_while_it_is_off_its_parameters_change_no_bit():
    time = rows(4.0)
    current = np.where(time < 2.0, 0.44e-3, 0.42e-3)
    declared = simulate(positioner(), time, current)
    for values in FIRMWARES.values():
        off = positioner({f'position_controller.{name}': value for name, value in values.items()})
        for column, numbers in simulate(off, time, current).columns.items():
            assert np.array_equal(numbers, declared[column]), column


def test_the_integral_does_not_wind_up():
    """A stem kept at its stop for a minute leaves it as soon as one kept there for a moment."""
    def leaves_after(wait: float) -> float:
        time = rows(wait + 20.0)
        set_point = np.where(time < wait, 17e-3, 8e-3)
        run = simulate(loop({'integral_time': 1.0}), time, set_point, MIDDLE)
        return float(time[np.flatnonzero(run['valve_position'] > 15.9e-3)[-1]] - wait)

    assert leaves_after(80.0) == pytest.approx(leaves_after(40.0), abs=0.02)
    assert leaves_after(80.0) < 4.0


def test_what_flows_in_the_loop_is_what_the_chamber_stores():
    time = rows(8.0, 1e-3)
    set_point = np.select([time < 1.0, time < 4.0], [4e-3, 12e-3], 2e-3)
    run = simulate(loop(), time, set_point, MIDDLE)
    volume = DEAD_VOLUME + AREA * run['valve_position']
    mass = (run['chamber_pressure'] + 101_325.0) * volume / (287.0 * 293.15)
    flow = run['mass_flow']
    flown = np.concatenate(([0.0], np.cumsum(0.5 * (flow[1:] + flow[:-1]) * np.diff(time))))
    assert np.ptp(mass) > 2e-3
    assert mass - mass[0] == pytest.approx(flown, abs=2e-3 * np.ptp(mass))


def amplitude(values, others):
    """Return how much the stem moves to and fro in the last half minute at a standing set point."""
    time = rows(90.0)
    run = simulate(loop(values, others), time, np.where(time < 1.0, 4e-3, 5e-3), MIDDLE)
    return np.ptp(run['valve_position'][time > 60.0])


def test_a_stem_that_sticks_hunts_under_integral_action_and_a_dead_zone_ends_it():
    sticks = {'actuator.coulomb_friction': 300.0, 'actuator.stiction': 300.0}
    hunting = amplitude({'integral_time': 2.0}, sticks)
    assert hunting > 50e-6
    assert amplitude({'integral_time': 2.0, 'dead_zone': 0.4e-3}, sticks) < 1e-6


@pytest.mark.parametrize('plug', [1e-3, -1e-3])
def test_a_pressure_drop_pushes_a_stem_that_its_controller_holds(plug):
    """The controller brings it back; the chamber takes the force: Δp of the chamber A = Δp plug."""
    drop = 2e5
    time = rows(40.0)
    pinned = {'pressure_drop': np.where(time < 1.0, 0.0, drop)}
    run = simulate(loop({}, {'actuator.plug_area': plug}), time, np.full_like(time, 4e-3), MIDDLE,
                   pinned)
    assert run['valve_position'][-1] == pytest.approx(4e-3, abs=2e-6)
    away = np.sign(plug) * (4e-3 - run['valve_position'])
    assert away.max() > 20e-6
    assert away.max() > 3.0 * -away.min()
    assert run['chamber_pressure'][-1] - 187.5e3 == pytest.approx(plug * drop / AREA, rel=2e-3)


def test_a_pressure_drop_moves_a_stem_that_nothing_holds():
    p = positioner({'actuator.plug_area': 1e-3})
    time = rows(3.0)
    pinned = {'pressure_drop': np.full_like(time, 2e5), 'chamber_pressure': np.full_like(
        time, 225e3)}
    run = simulate(p, time, np.zeros_like(time), pinned=pinned)
    moved = 1e-3 * 2e5 / (AREA * 150e3 / TRAVEL)
    assert run['valve_position'] == pytest.approx(8e-3 - moved, abs=1e-7)
    plant = Plant(p)
    plant.reset(225e3, None, 0.4325e-3)
    plant.pressure_drop = 2e5
    plant.advance(0.4325e-3, 6000)
    assert plant.outputs().valve_position < 8e-3 - 0.8 * moved


def test_a_stem_that_is_held_is_at_rest_from_the_start():
    for others in ({}, {'actuator.leak_area': 3e-8}, {'ep_converter.dead_time': 0.1}):
        run = simulate(loop({}, others), TIME, np.full_like(TIME, 4e-3), MIDDLE)
        assert run['valve_position'] == pytest.approx(4e-3, abs=1e-6), others


def test_a_plant_without_a_set_point_vents_and_takes_up_the_next():
    plant = make_plant(loop(), 5e-3)
    plant.reset(187.5e3, 4e-3)
    plant.advance(4e-3, 100)
    plant.vent(800)
    assert plant.outputs().control_current == 0.0
    assert plant.outputs().chamber_pressure < 60e3
    plant.advance(8e-3, 4000)
    assert plant.outputs().valve_position == pytest.approx(8e-3, abs=50e-6)


def test_parameters_that_change_keep_the_stem_where_it_is():
    plant = make_plant(loop(), 1e-3)
    plant.reset(187.5e3, 4e-3)
    plant.advance(4e-3, 1000)
    for values, others in ((PI, {'ep_converter.dead_time': 0.05}), ({'period': 0.003}, {})):
        plant.parameters = loop(values, others)
        plant.advance(4e-3, 1000)
        assert plant.outputs().valve_position == pytest.approx(4e-3, abs=20e-6)
    with pytest.raises(ValueError, match=r'position_controller\.enabled must stay true'):
        plant.parameters = positioner()


def test_a_loop_current_means_a_position():
    opens, shuts = (loop({'action': action}).position_controller
                    for action in ('air_to_open', 'air_to_close'))
    for signal, share in ((4e-3, 0.0), (12e-3, 0.5), (20e-3, 1.0)):
        assert set_point_of(opens, signal, TRAVEL) == pytest.approx(share * TRAVEL)
        assert set_point_of(shuts, signal, TRAVEL) == pytest.approx((1.0 - share) * TRAVEL)


@pytest.mark.parametrize(('values', 'complaint'), [
    ({'enabled': 1.0}, r'position_controller\.enabled must be true or false, got 1\.0'),
    ({'current_limits': (1e-3, 1e-3)}, r'position_controller\.current_limits must rise'),
    ({'signal_range': (4e-3, 4e-3)}, r'signal_range must be two currents that differ'),
    ({'characteristic_table': (0.0, 0.5, 0.4, *[0.6] * 8)}, r'characteristic_table must not fall'),
    ({'output': 'pneumatic'}, r'position_controller\.output must be one of continuous, pulses'),
])
def test_what_contradicts_itself_is_refused(values, complaint):
    with pytest.raises(ParameterError, match=complaint):
        loop(values)


@pytest.mark.parametrize(('set_point', 'linkage'), [
    (8e-3, 8e-3), (8.1e-3, 8.05e-3), (7e-3, 7.95e-3), (8.02e-3, 8.02e-3)])
def test_a_linkage_with_play_begins_where_the_controller_has_least_to_correct(set_point, linkage):
    c = PositionController(feedback_backlash=1e-4)
    state = at_rest(c, 16e-3, set_point, 8e-3, 4e-4)
    assert state.linkage == state.lagged_linkage == state.seen == pytest.approx(linkage)
