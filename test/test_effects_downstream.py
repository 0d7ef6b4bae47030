# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Effects in tubing, chamber and stem, each by the signature that tells it from the others."""

from functools import cache
import math

import numpy as np
from positioner_runs import (
    PAPER_CURRENT,
    current_for,
    cut_off,
    follow_pressure,
    loop_width,
    positioner,
    rows,
    settled_at,
    slow_triangle,
    triangle,
)
import pytest

from booster_ros.model.chamber import leak_flow
from booster_ros.model.simulation import Plant, Simulation, simulate
from booster_ros.model.tubing import tube_flow

AREA, TRAVEL = 0.0796, 0.016
STOP_STIFFNESS = 5e8
SPRING = AREA * 150e3 / TRAVEL
ATMOSPHERE = 101_325.0
LEG = 30.0
TIME = rows(4.0 * LEG)
LEVELS = np.array([3e-3, 8e-3, 13e-3])


def sweep(values: dict[str, object] | None, leg: float = LEG) -> Simulation:
    """Return the stem under a chamber pressure that goes up and down twice."""
    if values is None:
        return declared_sweep(leg)
    time = rows(4.0 * leg, leg / 3000.0)
    return follow_pressure(values, time, triangle(time, 120e3, 330e3, leg))


@cache
def declared_sweep(leg: float) -> Simulation:
    """Return what the stem as declared does; nothing in it may be changed in place."""
    return sweep({}, leg)


def pressure_at(run: Simulation, positions: np.ndarray) -> np.ndarray:
    """Return the chamber pressure at which the stem passes these positions on its second way up."""
    up = (run['time'] >= 2.0 * LEG) & (run['time'] < 3.0 * LEG)
    moving = up & (run['valve_position'] > 1e-5) & (run['valve_position'] < TRAVEL - 1e-5)
    return np.interp(positions, run['valve_position'][moving], run['chamber_pressure'][moving])


def pressure_loop(run: Simulation, positions: np.ndarray, leg: float = LEG) -> np.ndarray:
    """Return how much more pressure the stem needs upwards than downwards."""
    return np.asarray(
        loop_width(run['time'], leg, run['valve_position'], run['chamber_pressure'], positions))


def expected_pressure(positions: np.ndarray) -> np.ndarray:
    return 150e3 * (1.0 + positions / TRAVEL)


# tubing


def test_tubing_outlet_leads_the_chamber_while_air_flows_and_equals_it_at_rest():
    time = rows(80.0)
    current = np.where(time < 40.0, PAPER_CURRENT, current_for(140e3))
    values = {'tubing.restriction_area': 2e-6}
    run = simulate(positioner(values), time, current, {'back_pressure': 0.0})
    lead = run['outlet_pressure'] - run['chamber_pressure']
    filling, venting = (time > 0.5) & (time < 4.0), (time > 40.5) & (time < 42.0)
    assert lead[filling].min() > 5e3
    assert lead[venting].max() < -5e3
    assert abs(lead[time < 40.0][-1]) < 50.0
    assert abs(lead[-1]) < 50.0
    # more flow, more lead
    assert np.corrcoef(lead[filling], run['mass_flow'][filling])[0, 1] > 0.8


@pytest.mark.parametrize('critical', [0.5283, 0.3])
def test_a_tube_chokes_at_a_critical_ratio_of_its_own(critical):
    """A chamber of fixed volume fills from an outlet that is given: q = V/(R T) dP/dt."""
    area, outlet, time = 2e-7, 400e3, rows(6.0)
    run = simulate(
        positioner({'tubing.restriction_area': area,
                    'tubing.critical_pressure_ratio': critical}), time, np.zeros_like(time),
        pinned={name: np.full_like(time, value) for name, value in {
            'outlet_pressure': outlet, 'valve_position': 0.0, 'stem_velocity': 0.0}.items()})
    flow = 0.185e-3 / (287.0 * 293.15) * np.gradient(run['chamber_pressure'], time)
    ratio = (run['chamber_pressure'] + ATMOSPHERE) / (outlet + ATMOSPHERE)
    beyond = np.maximum(ratio - critical, 0.0) / (1.0 - critical)
    choked = 0.0404184 * area * (outlet + ATMOSPHERE) / math.sqrt(293.15)
    looked_at = slice(1, int(np.argmax(ratio > 0.9)))
    assert np.any(beyond[looked_at] == 0.0)
    assert flow[looked_at] / choked == pytest.approx(
        np.sqrt(1.0 - beyond[looked_at]**2), abs=5e-3)


def filled_through(values):
    """Return flow, pressures (absolute) of a chamber of fixed volume behind a given outlet."""
    time = rows(6.0)
    swing = 250e3 + 150e3 * np.sin(2.0 * time)
    run = simulate(positioner(values), time, np.zeros_like(time), pinned={
        'outlet_pressure': swing, 'valve_position': np.zeros_like(time),
        'stem_velocity': np.zeros_like(time)})
    flow = 0.185e-3 / (287.0 * 293.15) * np.gradient(run['chamber_pressure'], time)
    return flow, run['outlet_pressure'] + ATMOSPHERE, run['chamber_pressure'] + ATMOSPHERE


def test_a_laminar_tube_carries_in_proportion_to_the_difference_of_squares_both_ways():
    """Hagen-Poiseuille of a gas, isothermal: q = G (P1² - P2²), whichever side is higher."""
    flow, outlet, chamber = filled_through(
        {'tubing.restriction_area': 5e-8, 'tubing.laminar_share': 1.0})
    conductance = 0.0404184 * 5e-8 / math.sqrt(293.15) / 1e5
    assert flow[5:-5] == pytest.approx((conductance * (outlet**2 - chamber**2))[5:-5], rel=0.01,
                                       abs=1e-8)
    assert flow.min() < -1e-5 < 1e-5 < flow.max()


def test_drops_of_a_half_laminar_tube_add_up():
    area, share = 5e-8, 0.4
    flow, outlet, chamber = filled_through(
        {'tubing.restriction_area': area, 'tubing.laminar_share': share})
    scale = 0.0404184 * area / math.sqrt(293.15)
    upstream, ratio = np.maximum(outlet, chamber), np.minimum(outlet, chamber) / np.maximum(
        outlet, chamber)
    inside = (ratio < 0.99) & (np.arange(len(flow)) > 4) & (np.arange(len(flow)) < len(flow) - 5)
    orifice = scale * upstream * np.sqrt(1.0 - (np.maximum(ratio - 0.5283, 0.0) / 0.4717)**2)
    laminar = scale * np.abs(outlet**2 - chamber**2) / 1e5
    q = np.abs(flow)
    whole = share * q / laminar + (1.0 - share) * (q / orifice)**2
    assert whole[inside] == pytest.approx(np.ones(inside.sum()), abs=0.02)


def test_a_half_laminar_tube_is_still_where_pressures_differ_by_a_rounding():
    tubing = positioner({'tubing.restriction_area': 2e-6, 'tubing.laminar_share': 0.02}).tubing
    assert tube_flow(tubing, 2e-12, 0.0, 293.0, 293.0) == 0.0


# chamber


def test_a_chamber_that_leaks_cools_as_its_gas_expands():
    """Nothing warms it: T goes as P to the (γ - 1)/γ."""
    time = rows(20.0)
    run = cut_off({'actuator.leak_area': 5e-8, 'actuator.thermal_resistance': 1e4}, 145e3, time)
    absolute = run['chamber_pressure'] + ATMOSPHERE
    expected = 293.15 * (absolute / absolute[0])**(0.4 / 1.4)
    assert run['gas_temperature'][-1] < 293.15 - 30.0
    # the end stop gives way a little less, and what heat there is comes in
    assert run['gas_temperature'] == pytest.approx(expected, abs=1.5)


def test_chamber_leak_decays_on_and_on():
    """A shut-off chamber with a closed stem: ln P falls at one rate while the leak is choked."""
    area = 1e-8
    run = cut_off({'actuator.leak_area': area}, 145e3, rows(120.0))
    absolute = run['chamber_pressure'] + ATMOSPHERE
    choked = absolute > ATMOSPHERE / 0.5
    rate = np.gradient(np.log(absolute), run['time'])[choked][1:-1]
    expected = -287.0 * math.sqrt(293.15) * 0.0404184 * area / 0.185e-3
    assert choked.sum() > 1000
    assert rate == pytest.approx(expected, rel=0.03)
    assert run['chamber_pressure'][-1] < 0.55 * 145e3
    assert np.all(np.diff(run['chamber_pressure']) < 0.0)


@pytest.mark.parametrize('ratio', [0.5, 0.7, 0.9])
def test_a_leak_has_the_critical_ratio_of_an_ideal_nozzle_to_all_digits(ratio):
    area, absolute, critical = 1e-8, ATMOSPHERE / ratio, (2.0 / 2.4)**3.5
    choked = math.sqrt(1.4 / 287.0 * (2.0 / 2.4)**6) * area * absolute / math.sqrt(310.0)
    beyond = max(ratio - critical, 0.0) / (1.0 - critical)
    act = positioner({'actuator.leak_area': area}).actuator
    flow = leak_flow(act, absolute - ATMOSPHERE, 310.0, 293.15, 0.0)
    assert flow == pytest.approx(choked * math.sqrt(1.0 - beyond**2), rel=1e-9)


@pytest.mark.parametrize(
    ('from_pressure', 'current', 'sign'), [(0.0, 1e-3, 1.0), (390e3, 0.0, -1.0)],
    ids=['filling', 'venting'],
)
def test_heat_overshoots_then_relaxes_to_a_plateau(from_pressure, current, sign):
    """Fill (or vent) fast, then shut off: the pressure comes back a little, and stays."""
    values = {'actuator.thermal_resistance': 3.0}
    time = rows(2.0)
    moving = simulate(
        positioner(values), time, np.full_like(time, current), settled_at(from_pressure))
    names = ('chamber_pressure', 'gas_temperature', 'valve_position')
    start = {name: float(moving[name][-1]) for name in names}
    assert sign * (start['gas_temperature'] - 293.15) > 3.0
    rest = rows(200.0)
    shut = simulate(
        positioner({**values, 'booster.max_area': 0.0}), rest, np.zeros_like(rest), start)
    pressure = shut['chamber_pressure']
    fall = sign * (pressure[10] - pressure[-1])
    assert fall > 500.0
    assert pressure[-1] > 50e3
    # an exponential to a plateau, not a decay that goes on
    assert abs(pressure[-1] - pressure[-2000]) < 0.01 * fall
    assert shut['gas_temperature'][-1] == pytest.approx(293.15, abs=0.02)


def test_heat_leaves_with_the_time_constant_of_gas_and_wall():
    """At constant volume T falls exponentially with m c_v R_th, and pressure with it."""
    resistance = 20.0
    time = rows(40.0)
    start = {'chamber_pressure': 100e3, 'gas_temperature': 323.15}
    run = simulate(
        positioner({'actuator.thermal_resistance': resistance, 'booster.max_area': 0.0}),
        time, np.zeros_like(time), start)
    mass = (100e3 + ATMOSPHERE) * 0.185e-3 / (287.0 * 323.15)
    excess = 30.0 * np.exp(-time / (mass * 287.0 / 0.4 * resistance))
    assert run['gas_temperature'] - 293.15 == pytest.approx(excess, abs=0.2)
    gas_law = (100e3 + ATMOSPHERE) * run['gas_temperature'] / 323.15 - ATMOSPHERE
    # the end stop gives way a little, with the pressure
    assert run['chamber_pressure'] == pytest.approx(gas_law, abs=400.0)


def test_a_polytropic_chamber_answers_n_times_as_fast_at_constant_volume():
    time = rows(0.5, 1e-3)
    current = np.full_like(time, 1e-3)
    rates = [
        np.gradient(simulate(
            positioner({'actuator.polytropic_index': n}), time, current, {'back_pressure': 400e3}
        )['chamber_pressure'], time)[5] for n in (1.0, 1.3)]
    assert rates[1] / rates[0] == pytest.approx(1.3, rel=0.02)


def test_dead_volume_change_slows_the_closed_stem_only():
    added = 0.2e-3
    time = rows(30.0)
    current = np.full_like(time, 1e-3)

    def run(values):
        return simulate(positioner(values), time, current, {'back_pressure': 400e3})

    declared, larger = run(None), run({'actuator.added_volume': added})

    def rate(result, level, name):
        at = int(np.argmax(result[name] > level))
        return np.gradient(result[name], time)[at]

    # choked and wide open: dp/dt goes as one over the volume
    assert rate(declared, 60e3, 'chamber_pressure') / rate(
        larger, 60e3, 'chamber_pressure') == pytest.approx(
            (0.185e-3 + added) / 0.185e-3, rel=0.03)
    # while the stem moves, the swept volume rules
    assert rate(declared, 8e-3, 'valve_position') / rate(
        larger, 8e-3, 'valve_position') == pytest.approx(1.0, abs=0.08)
    assert larger['chamber_pressure'][-1] == pytest.approx(
        declared['chamber_pressure'][-1], abs=100.0)


# stem


@pytest.mark.parametrize('leg', [15.0, 60.0])
def test_friction_is_a_loop_of_position_over_pressure_whatever_the_rate(leg):
    """Two parallel lines, 2 Fc / A apart in pressure."""
    force = 400.0
    loop = pressure_loop(sweep({'actuator.coulomb_friction': force}, leg), LEVELS, leg)
    # viscous friction adds to the loop: twice c v / A
    viscous = 2.0 * 3000.0 * TRAVEL / (leg * 150e3 / 210e3) / AREA
    assert loop == pytest.approx(2.0 * force / AREA + viscous, rel=0.01)
    assert np.all(np.abs(pressure_loop(sweep(None, leg), LEVELS, leg) - viscous) < 50.0)


def test_a_stuck_stem_stands_exactly_still_over_the_dead_band():
    force = 400.0
    time = rows(8.0)
    # a reversal of the pressure in mid travel
    pressure = np.where(time < 4.0, 200e3 + 10e3 * time, np.maximum(280e3 - 10e3 * time, 150e3))
    run = follow_pressure({'actuator.coulomb_friction': force}, time, pressure)
    position, velocity = run['valve_position'], run['stem_velocity']
    dead_band = 2.0 * force / AREA
    stuck = (time > 4.05) & (time < 4.0 + 0.98 * dead_band / 10e3)
    assert stuck.sum() > 80
    assert np.all(velocity[stuck] == 0.0)
    assert np.ptp(position[stuck]) == 0.0
    free = (time > 4.0 + 1.1 * dead_band / 10e3) & (time < 7.0)
    assert np.all(velocity[free] < 0.0)


def test_stiction_is_a_staircase():
    """
    Under a slow ramp of pressure the stem stands, jumps, stands.

    It breaks away at the full force and slides against the lower one; jumps are of the order of
    stiction over spring rate.
    """
    fc, stiction = 300.0, 200.0
    time = rows(100.0)
    pressure = 170e3 + 1e3 * time
    values = {'actuator.coulomb_friction': fc, 'actuator.stiction': stiction,
              'actuator.stribeck_velocity': 1e-3}
    run = follow_pressure(values, time, pressure)
    position, velocity = run['valve_position'], run['stem_velocity']
    assert np.mean(velocity == 0.0) > 0.9
    stuck = np.flatnonzero(velocity == 0.0)
    rises = np.diff(position[stuck])
    jumping = rises != 0.0
    jumps = rises[jumping]
    assert len(jumps) > 30
    assert jumps == pytest.approx(stiction / SPRING, rel=0.02)
    # before each jump, the force that friction withstands to the last
    before = stuck[:-1][jumping]
    force = AREA * (pressure[before] - 150e3) - SPRING * position[before]
    assert force == pytest.approx(fc + stiction, abs=2.0)


def test_a_packing_yields_before_the_stem_slides():
    """
    At a reversal the stem moves by what the packing yields while friction changes its sign.

    Along the way friction follows the solution of the bristles' equation for constant sliding
    friction g: after a turn, f = g (2 exp(-σ0 s/g) - 1) at the way s back.
    """
    friction, stiffness = 600.0, 1e7
    time = rows(60.0)
    pressure = 170e3 + 1e3 * np.minimum(time, 60.0 - time)
    run = simulate(
        positioner({'actuator.coulomb_friction': friction,
                    'actuator.presliding_stiffness': stiffness}),
        time, np.zeros_like(time), pinned={'chamber_pressure': pressure}, tolerance=0.01)
    position = run['valve_position']
    turn = int(np.argmax(position))
    held = AREA * (pressure - 150e3) - SPRING * position
    way = position[turn] - position[turn:]
    expected = friction * (2.0 * np.exp(-stiffness * way / friction) - 1.0)
    yielding = way < 1e-4
    assert np.sum(yielding) > 1000
    assert held[turn:][yielding] == pytest.approx(expected[yielding], abs=0.005 * friction)
    # and fast enough either way it slides against the whole of it
    assert np.median(held[(time > 15.0) & (time < 25.0)]) == pytest.approx(friction, rel=0.02)
    assert np.median(held[time > 50.0]) == pytest.approx(-friction, rel=0.02)


@pytest.mark.parametrize('damping', [0.1, 0.3, 0.6])
def test_a_stem_rings_in_its_packing_as_that_is_damped(damping):
    """
    Far from sliding, the packing is a spring and a dashpot: a step of force overshoots as these do.

    By exp(-π ζ/√(1-ζ²)), with ζ the share of critical damping.
    """
    stiffness, mass = 1e7, 4.0
    values = {'actuator.coulomb_friction': 1e5, 'actuator.presliding_stiffness': stiffness,
              'actuator.presliding_damping': damping, 'actuator.viscous_friction': 0.0,
              'actuator.moving_mass': mass}
    time = np.arange(0.0, 0.1, 1e-5)
    pressure = np.where(time < 0.01, 200e3, 201e3)
    held = AREA * 50e3 / SPRING  # where the spring alone holds the stem at the first pressure
    run = simulate(positioner(values), time, np.zeros_like(time), {'valve_position': held},
                   {'chamber_pressure': pressure}, tolerance=0.01)
    way = run['valve_position'] - held
    share = damping * np.sqrt(stiffness / (stiffness + SPRING))
    overshoot = np.exp(-np.pi * share / np.sqrt(1.0 - share**2))
    assert way[-1] == pytest.approx(AREA * 1e3 / (stiffness + SPRING), rel=0.02)
    assert way.max() / way[-1] == pytest.approx(1.0 + overshoot, abs=0.02)


def test_a_yielding_packing_holds_a_stem_that_nothing_moves():
    values = {'actuator.coulomb_friction': 500.0, 'actuator.presliding_stiffness': 1e7}
    time = rows(60.0)
    run = simulate(
        positioner(values), time, np.zeros_like(time), {'valve_position': 0.0055},
        {'chamber_pressure': np.full(len(time), 200e3)})
    assert np.ptp(run['valve_position']) < 1e-7


def test_a_stiff_packing_is_nearly_a_rigid_one():
    time = rows(60.0)
    pressure = 170e3 + 1e3 * np.minimum(time, 60.0 - time)
    runs = [follow_pressure({'actuator.coulomb_friction': 400.0, 'actuator.presliding_stiffness':
                             stiffness}, time, pressure)['valve_position']
            for stiffness in (0.0, 1e9, 1e7)]
    assert np.max(np.abs(runs[1] - runs[0])) < 5e-6
    assert np.max(np.abs(runs[2] - runs[0])) > 5e-5


def test_a_slip_takes_pressure_out_of_the_chamber():
    values = {'actuator.coulomb_friction': 400.0, 'actuator.stiction': 400.0}
    time = rows(60.0)
    current = current_for(160e3 + 1.5e3 * time)
    run = simulate(positioner(values), time, current, settled_at(160e3))
    slips = np.flatnonzero(np.diff(run['valve_position']) > 3e-5)
    assert len(slips) > 10
    fallen = run['chamber_pressure'][slips + 1] < run['chamber_pressure'][slips]
    assert np.mean(fallen) > 0.9
    sticking = run['stem_velocity'][1:] == 0.0
    assert np.mean(np.diff(run['chamber_pressure'])[sticking & (time[1:] < 55.0)] > 0.0) > 0.7


def test_a_stuck_plant_does_not_creep():
    plant = Plant(positioner({'actuator.coulomb_friction': 500.0}))
    plant.reset(200e3, 0.0055, float(current_for(200e3)))
    plant.advance(float(current_for(200e3)), 5000)
    seen = plant.outputs()
    assert (seen.valve_position, seen.stem_velocity) == (0.0055, 0.0)


def test_position_dependent_friction_widens_the_loop_along_the_travel():
    base, gradient = 200.0, 300.0
    values = {'actuator.coulomb_friction': base, 'actuator.friction_gradient': gradient}
    loop = pressure_loop(sweep(values), LEVELS) - pressure_loop(sweep(None), LEVELS)
    assert loop == pytest.approx(2.0 * (base + gradient * LEVELS / TRAVEL) / AREA, rel=0.01)


def test_a_galled_stem_widens_the_loop_where_it_has_galled():
    base, most, place, width = 100.0, 300.0, 6e-3, 2e-3
    values = {'actuator.coulomb_friction': base, 'actuator.friction_peak': most,
              'actuator.friction_peak_position': place, 'actuator.friction_peak_width': width}
    levels = place + width * np.array([-2.5, -1.0, -0.5, 0.0, 0.5, 1.0, 2.5, 4.0])
    loop = pressure_loop(sweep(values), levels) - pressure_loop(sweep(None), levels)
    shares = [0.002, 0.368, 0.779, 1.0, 0.779, 0.368, 0.002, 0.0]
    assert 0.5 * AREA * loop - base == pytest.approx(most * np.array(shares), abs=3.0)


def test_a_stem_that_rubs_only_where_it_has_galled_sticks_there_alone():
    galled = positioner({
        'actuator.friction_peak': 500.0, 'actuator.friction_peak_position': 5.5e-3,
        'actuator.friction_peak_width': 1e-3})
    for place, moves in ((5.5e-3, False), (9e-3, True)):
        plant = Plant(galled)
        balance = expected_pressure(place) + 0.6 * 500.0 / AREA
        plant.reset(balance, place, float(current_for(balance)))
        plant.advance(float(current_for(balance)), 5000)
        assert (plant.outputs().valve_position != place) is moves


def departure(values: dict[str, object], positions: np.ndarray) -> np.ndarray:
    """Return the force in N by which opening takes more than declared; there is no loop."""
    run = sweep(values)
    assert pressure_loop(run, LEVELS) == pytest.approx(pressure_loop(sweep(None), LEVELS), abs=80.0)
    return (pressure_at(run, positions) - pressure_at(sweep(None), positions)) * AREA


SHARES = np.array([0.02, 0.25, 0.5, 0.75, 0.98])


def test_spring_bend_is_largest_in_the_middle_and_nothing_at_the_ends():
    bow = departure({'actuator.spring_bend': 300.0}, SHARES * TRAVEL)
    assert bow == pytest.approx(4.0 * 300.0 * SHARES * (1.0 - SHARES), abs=3.0)


def test_spring_s_curve_is_odd_about_the_middle():
    curve = departure({'actuator.spring_s_curve': 200.0}, SHARES * TRAVEL)
    assert curve[2] == pytest.approx(0.0, abs=3.0)
    assert curve[1] == pytest.approx(200.0, abs=3.0)
    assert curve + curve[::-1] == pytest.approx(0.0, abs=5.0)


def test_spring_excess_grows_with_the_travel():
    assert departure({'actuator.spring_excess': 300.0}, SHARES * TRAVEL) == pytest.approx(
        300.0 * SHARES, abs=3.0)


def test_area_change_grows_with_position():
    change = 0.05
    run = sweep({'actuator.area_change': change})
    positions = SHARES * TRAVEL
    needed = expected_pressure(positions) / (1.0 - change * SHARES)
    assert pressure_at(run, positions) == pytest.approx(needed, abs=60.0)
    assert pressure_loop(run, LEVELS) == pytest.approx(pressure_loop(sweep(None), LEVELS), abs=80.0)


def test_bench_set_shift_moves_the_line_and_keeps_its_slope():
    moved = departure({'actuator.bench_set_shift': 6e3}, SHARES * TRAVEL) / AREA
    assert moved == pytest.approx(6e3, abs=20.0)


def test_seat_load_acts_near_the_seat_only():
    load, depth = 400.0, 2e-3
    positions = np.array([0.1e-3, 1e-3, 1.9e-3, 2.5e-3, 10e-3])
    force = departure({'actuator.seat_load': load, 'actuator.seat_depth': depth}, positions)
    expected = -load * np.maximum(1.0 - positions / depth, 0.0)
    assert force == pytest.approx(expected, abs=5.0)


def test_a_soft_seat_yields_below_the_closed_stem_and_nowhere_else():
    stiffness, pressure = 2e7, 40e3
    time = rows(20.0)
    soft = positioner({'actuator.seat_stiffness': stiffness})
    run = simulate(soft, time, 0.0 * time, pinned={'chamber_pressure': 0.0 * time + pressure})
    seat_and_stop = 1.0 / (1.0 / stiffness + 1.0 / STOP_STIFFNESS)
    shut_with = AREA * (expected_pressure(0.0) - pressure)
    assert run['valve_position'][-1] == pytest.approx(
        -shut_with / (seat_and_stop + SPRING), rel=1e-4)
    force = departure({'actuator.seat_stiffness': stiffness}, SHARES * TRAVEL)
    assert force == pytest.approx(0.0, abs=3.0)


def test_flow_force_fades_with_travel():
    size, decay = 300.0, 0.25
    force = departure(
        {'actuator.flow_force': size, 'actuator.flow_force_decay': decay}, SHARES * TRAVEL)
    assert force == pytest.approx(size * np.exp(-SHARES / decay), abs=3.0)


def test_a_tabulated_stem_term_is_a_force_over_position_and_zero_outside():
    values = {
        'discrepancy.location': 'stem', 'discrepancy.variable': 'valve_position',
        'discrepancy.knots': list(np.linspace(0.25, 0.75, 12) * TRAVEL),
        'discrepancy.values': [-100.0] * 12,
    }
    shares = np.array([0.1, 0.3, 0.7, 0.9])
    assert departure(values, shares * TRAVEL) == pytest.approx([0.0, 100.0, 100.0, 0.0], abs=3.0)


def test_a_tabulated_chamber_term_is_a_flow_out():
    flow = 2e-6
    values = {
        'discrepancy.location': 'chamber', 'discrepancy.variable': 'chamber_pressure',
        'discrepancy.knots': list(np.linspace(100e3, 200e3, 12)),
        'discrepancy.values': [flow] * 12,
    }
    run = cut_off(values, 140e3, rows(3.0))
    fall = np.gradient(run['chamber_pressure'], run['time'])[50]
    assert fall == pytest.approx(-287.0 * 293.15 * flow / 0.185e-3, rel=0.03)


def test_friction_shows_in_the_whole_chain_as_in_the_stem_alone():
    force = 300.0
    leg = 120.0
    runs = [slow_triangle(v, 140e3, 310e3, leg) for v in ({'actuator.coulomb_friction': force}, {})]
    loops = [
        loop_width(run['time'], leg, run['valve_position'], run['chamber_pressure'], LEVELS)
        for run in runs]
    assert loops[0] - loops[1] == pytest.approx(2.0 * force / AREA, rel=0.05)
