# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Effects in converter, booster and supply, each by the signature that tells it from the others."""

import math

import numpy as np
from positioner_runs import (
    GAIN,
    PAPER_CURRENT,
    current_for,
    cut_off,
    loop_width,
    positioner,
    rows,
    settled_at,
    slow_triangle,
)
import pytest

from booster_ros.model.simulation import Simulation, simulate
from booster_ros.model.supply import supply_pressure_rate

CHOKED = 0.0404184 / math.sqrt(293.15)
ATMOSPHERE = 101_325.0


def step(
    values: dict[str, object] | None, start: float, end: float, length: float = 20.0
) -> Simulation:
    """Return a step of the current between two settled pressures, Pa, at 1 s."""
    time = rows(length)
    current = np.where(time < 1.0, current_for(start), current_for(end))
    return simulate(positioner(values), time, current, settled_at(start))


def bench(
    values: dict[str, object] | None, back: np.ndarray, chamber: np.ndarray
) -> Simulation:
    """Return the booster alone: back pressure and chamber pressure given, Pa."""
    time = np.arange(len(back)) * 1e-3
    return simulate(
        positioner(values), time, np.zeros(len(back)),
        pinned={'back_pressure': back, 'chamber_pressure': chamber},
    )


@pytest.mark.parametrize('leg', [30.0, 90.0])
def test_ep_hysteresis_is_a_loop_of_back_pressure_over_current_whatever_the_rate(leg):
    width = 2e-6
    levels = current_for(np.array([180e3, 220e3, 260e3]))

    def loop(values):
        run = slow_triangle(values, 140e3, 300e3, leg)
        return loop_width(
            run['time'], leg, run['control_current'], run['back_pressure'], levels)

    # the E/P lag makes a small loop of its own
    assert loop({'ep_converter.hysteresis': width}) - loop(None) == pytest.approx(
        -width * GAIN, rel=0.02)


def test_ep_drift_moves_the_settled_back_pressure_with_time_and_whatever_the_current():
    values = {'ep_converter.drift': 2e3, 'ep_converter.drift_time_constant': 50.0}
    drifting, declared = step(values, 180e3, 240e3, 300.0), step(None, 180e3, 240e3, 300.0)
    moved = drifting['back_pressure'] - declared['back_pressure']
    expected = 2e3 * (1.0 - np.exp(-declared['time'] / 50.0))
    assert np.abs(moved - expected).max() < 10.0


def test_ep_nonlinearity_bends_the_settled_curve_alike_both_ways():
    even, odd = 1.5e3, -800.0
    shape = {'ep_converter.nonlinearity_centre': 234e3, 'ep_converter.nonlinearity_span': 10e3}
    currents = np.array([214e3, 224e3, 234e3, 244e3, 254e3]) / GAIN
    time = rows(4.0)

    def settled(values):
        return np.array([
            simulate(positioner(values), time, np.full_like(time, i), {'back_pressure': 0.0})[
                'back_pressure'][-1] for i in currents])

    bend = settled({**shape, 'ep_converter.nonlinearity_even': even}) - settled(None)
    assert bend == pytest.approx(even * np.array([4.0, 1.0, 0.0, 1.0, 4.0]), abs=1.0)
    curve = settled({**shape, 'ep_converter.nonlinearity_odd': odd}) - settled(None)
    assert curve == pytest.approx(odd * np.array([-8.0, -1.0, 0.0, 1.0, 8.0]), abs=1.0)
    # no loop: at the same current the same back pressure, up or down, but for the lag
    leg = 60.0
    loops = [
        loop_width(run['time'], leg, run['control_current'], run['back_pressure'], currents[1:4])
        for run in (slow_triangle({**shape, 'ep_converter.nonlinearity_even': even}, 100e3, 340e3),
                    slow_triangle(None, 100e3, 340e3))]
    assert loops[0] == pytest.approx(loops[1], abs=60.0)


@pytest.mark.parametrize('dead_time', [0.25, 0.123])
def test_dead_time_is_a_pure_shift(dead_time):
    late, declared = step({'ep_converter.dead_time': dead_time}, 180e3, 250e3), step(
        None, 180e3, 250e3)
    time = declared['time']
    # where a step falls between two rows, half a row of it is smeared
    close = {'back_pressure': 700.0, 'chamber_pressure': 100.0, 'valve_position': 10e-6}
    for name, limit in close.items():
        shifted = np.interp(time - dead_time, time, declared[name])
        assert np.abs(late[name] - shifted).max() < limit, name
        assert np.abs(late[name] - declared[name]).max() > 20.0 * limit * min(
            1.0, dead_time / 0.25) / 4.0, name


@pytest.mark.parametrize('loss', [0.3, -0.5])
def test_ep_gain_loss_is_another_slope_through_the_same_zero(loss):
    currents, time = np.array([0.0, 0.1e-3, 0.25e-3, 0.4e-3]), rows(2.0)
    settled = [
        simulate(positioner({'ep_converter.gain_loss': loss, 'ep_converter.offset': 7e3}), time,
                 np.full_like(time, i), {'back_pressure': 0.0})['back_pressure'][-1]
        for i in currents]
    assert settled == pytest.approx(7e3 + (1.0 - loss) * GAIN * currents, abs=1.0)


def test_booster_dead_band_holds_the_chamber_while_the_back_pressure_turns():
    preloads = {'booster.intake_preload': 0.03, 'booster.exhaust_preload': 0.02}
    width = 0.05 / 13.52e-6
    leg = 120.0
    time = rows(4.0 * leg)
    levels = np.array([180e3, 210e3, 250e3])
    runs = [slow_triangle(values, 140e3, 300e3, leg) for values in (preloads, None)]
    loops = [
        loop_width(time, leg, run['chamber_pressure'], run['back_pressure'], levels)
        for run in runs]
    # the same width on the whole range: (F0 intake + F0 exhaust) / S1
    assert loops[0] - loops[1] == pytest.approx(width, rel=0.1)
    run = runs[0]
    after = (time > leg) & (time < 2.0 * leg)
    turning = run['back_pressure'][after]
    flat = np.ptp(turning[np.abs(run['chamber_pressure'][after] - run['chamber_pressure'].max())
                          < 100.0])
    assert flat > 0.8 * width
    # and no friction: the stem follows the pressure on one line
    line = np.interp(run['chamber_pressure'], [150e3, 300e3], [0.0, 0.016])
    assert np.abs(run['valve_position'] - line).max() < 30e-6


@pytest.mark.parametrize(
    ('values', 'low', 'high'),
    [
        # the gain shows on small steps, the largest area where the exhaust is wide open
        ({'booster.exhaust_gain_ratio': 0.5}, 150e3, 340e3),
        ({'booster.exhaust_lift_ratio': 0.2}, 0.0, 300e3),
    ],
    ids=['width', 'lift'],
)
def test_exhaust_asymmetry_shows_on_falling_steps_only(values, low, high):
    up, up_declared = (step(v, low, high)['chamber_pressure'] for v in (values, None))
    assert up == pytest.approx(up_declared, rel=1e-4)
    down, down_declared = (step(v, high, low, 60.0)['chamber_pressure'] for v in (values, None))
    half = 0.5 * (low + high)
    assert np.argmax(down < half) - 100 > 1.3 * (np.argmax(down_declared < half) - 100)
    assert down[-1] == pytest.approx(down_declared[-1], abs=0.01 * high)


def test_supply_seat_leak_raises_a_chamber_that_is_shut_off():
    area = 2e-9
    run = cut_off({'booster.supply_leak_area': area}, 120e3, rows(20.0))
    # 120 kPa is less than half of 400 kPa absolute: choked
    expected = CHOKED * area * (400e3 + ATMOSPHERE)
    assert run['mass_flow'] == pytest.approx(expected, rel=1e-3)
    rise = np.gradient(run['chamber_pressure'], run['time'])
    assert rise[100] == pytest.approx(287.0 * 293.15 * expected / 0.185e-3, rel=0.02)


def test_exhaust_seat_leak_empties_a_chamber_through_the_booster():
    area = 2e-9
    booster = cut_off({'booster.exhaust_leak_area': area}, 140e3, rows(20.0))
    chamber = cut_off({'actuator.leak_area': area}, 140e3, rows(20.0))
    assert booster['mass_flow'][0] == pytest.approx(-CHOKED * area * (140e3 + ATMOSPHERE), rel=1e-3)
    # the same decay as a leak of the chamber; only the flow of the booster tells them apart
    assert booster['chamber_pressure'] == pytest.approx(chamber['chamber_pressure'], rel=1e-9)
    assert booster['chamber_pressure'][-1] < 139e3
    assert np.all(chamber['mass_flow'] == 0.0)


FORCES = np.linspace(0.02, 1.2, 400)
BACK = (FORCES + 400e3 * 6.14e-6 + 100e3 * 3.14e-6) / 13.52e-6
CHAMBER = np.full(400, 100e3)


def test_opening_exponent_changes_the_slope_on_a_log_log_plot():
    run = bench({'booster.opening_exponent': 1.3}, BACK, CHAMBER)
    area, force = run['intake_area'], run['booster_force']
    opening = area < 0.95 * 1.45e-6
    slope = np.gradient(np.log(area[opening]), np.log(force[opening]))
    assert slope[2:-2] == pytest.approx(1.3, rel=1e-3)
    assert area[-1] == pytest.approx(1.45e-6)


def test_knee_softness_rounds_the_knee_and_nothing_far_from_it():
    soft = bench({'booster.knee_softness': 0.25}, BACK, CHAMBER)['intake_area']
    sharp = bench(None, BACK, CHAMBER)['intake_area']
    missing = (sharp - soft) / 1.45e-6
    assert np.all(missing >= -1e-12)
    assert FORCES[np.argmax(missing)] == pytest.approx(1.45e-6 / 2.75e-6, rel=0.05)
    assert missing.max() > 0.1
    assert missing[FORCES < 0.15].max() < 2e-3
    assert missing[-1] < 0.02


@pytest.mark.parametrize('values', [
    {'booster.opening_gain': 1e-2}, {'booster.opening_exponent': 10.0},
    {'booster.opening_exponent': 3.0, 'booster.knee_softness': 0.05, 'booster.max_area': 2e-7}])
def test_a_soft_knee_opens_no_further_than_the_seat_is_wide(values):
    values = {'booster.knee_softness': 0.3, 'booster.max_area': 1.45e-6} | values
    areas = bench(values, BACK, CHAMBER)['intake_area']
    assert areas.max() <= values['booster.max_area'] * (1.0 + 1e-12)
    assert areas[-1] > 0.98 * values['booster.max_area']


@pytest.mark.parametrize('supply', [150e3, 300e3])
def test_plug_flow_force_makes_the_opening_stiffer_with_the_pressure_drop(supply):
    """F - F0 = S/k + c dp S, and the plateau stays."""
    c, chamber = 0.77, 50e3
    back = (FORCES + supply * 6.14e-6 + chamber * 3.14e-6) / 13.52e-6
    values = {'supply.pressure': supply, 'booster.intake_flow_force': c}
    run = bench(values, back, np.full(400, chamber))
    slope = run['intake_area'][5] / run['booster_force'][5]
    assert 1.0 / slope == pytest.approx(1.0 / 2.75e-6 + c * (supply - chamber), rel=1e-6)
    assert run['intake_area'][-1] == pytest.approx(1.45e-6)


@pytest.mark.parametrize('outlet', [100e3, 300e3])
def test_plug_flow_force_makes_the_exhaust_stiffer_with_the_pressure_that_it_vents(outlet):
    """As the intake, with the drop to the atmosphere; the intake stays shut meanwhile."""
    c = 0.77
    back = (-FORCES + 400e3 * 6.14e-6 + outlet * 3.14e-6) / 13.52e-6
    run = bench({'booster.exhaust_flow_force': c}, back, np.full(400, outlet))
    slope = run['exhaust_area'][5] / -run['booster_force'][5]
    assert 1.0 / slope == pytest.approx(1.0 / 2.75e-6 + c * outlet, rel=1e-6)
    assert run['exhaust_area'][-1] == pytest.approx(1.45e-6)
    assert np.all(run['intake_area'] == 0.0)


def test_critical_pressure_ratio_moves_the_end_of_choking_only():
    chamber = np.linspace(0.0, 390e3, 400)
    back = np.full(400, 400e3)
    low = bench({'booster.critical_pressure_ratio_shift': -0.25}, back, chamber)['mass_flow']
    declared = bench(None, back, chamber)['mass_flow']
    ratio = (chamber + ATMOSPHERE) / (400e3 + ATMOSPHERE)
    choked = ratio < 0.5283 - 0.25
    assert np.all(low[choked] == declared[choked])
    beyond = ratio > 0.5283 - 0.2
    assert np.all(low[beyond] < declared[beyond])


@pytest.mark.parametrize('shift', [0.0, -0.25, 0.2])
def test_the_exhaust_chokes_at_the_shifted_ratio_too(shift):
    """Wide open, its flow over the ratio of the pressures is the ellipse that begins there."""
    chamber = np.linspace(0.2e3, 390e3, 400)
    flow = bench({'booster.critical_pressure_ratio_shift': shift}, np.zeros(400), chamber)[
        'mass_flow']
    critical = 0.5283 + shift
    beyond = np.maximum(ATMOSPHERE / (chamber + ATMOSPHERE) - critical, 0.0) / (1.0 - critical)
    assert np.any(beyond == 0.0)
    choked = CHOKED * 1.45e-6 * (chamber + ATMOSPHERE)
    assert -flow == pytest.approx(choked * np.sqrt(1.0 - beyond**2), rel=1e-4)


def test_a_regulator_that_a_flow_takes_all_from_does_not_suck():
    """A flow that would take twice the pressure leaves none, and is approached from above."""
    supply = positioner({'supply.droop': 2e8}).supply
    twice = 2.0 * supply.pressure / supply.droop
    assert supply_pressure_rate(supply, 0.0, supply.pressure, twice) == 0.0
    assert supply_pressure_rate(supply, 1e3, supply.pressure, twice) == pytest.approx(
        -1e3 / supply.droop_time_constant)


def test_supply_droop_shows_while_much_flows_and_is_gone_at_rest():
    droop = 2e7
    run, declared = step({'supply.droop': droop}, 140e3, 290e3, 60.0), step(
        None, 140e3, 290e3, 60.0)
    dip = 400e3 - run['supply_pressure']
    assert dip[90] == 0.0
    filling = (run['time'] > 2.5) & (run['time'] < 4.0)
    assert dip[filling].min() > 5e3
    assert dip[filling] == pytest.approx(droop * run['mass_flow'][filling], rel=0.05)
    assert dip[-1] < 100.0
    assert run['chamber_pressure'][-1] == pytest.approx(declared['chamber_pressure'][-1], abs=200.0)


def test_supply_ripple_is_a_line_at_its_frequency_and_reaches_the_chamber():
    values = {'supply.ripple': 3e3, 'supply.ripple_frequency': 0.2, 'supply.ripple_phase': 0.4}
    time = rows(100.0)
    run = simulate(
        positioner(values), time, np.full_like(time, current_for(200e3)), settled_at(200e3))
    wave = 400e3 + 3e3 * np.sin(2.0 * math.pi * 0.2 * time + 0.4)
    assert run['supply_pressure'] == pytest.approx(wave, abs=1e-6)
    half = run['chamber_pressure'][5000:-1]
    spectrum = np.abs(np.fft.rfft(half - half.mean()))
    assert np.fft.rfftfreq(len(half), 0.01)[np.argmax(spectrum)] == pytest.approx(0.2)
    # more supply, less output, though the slow chamber follows a part of it only
    assert np.corrcoef(run['supply_pressure'][5000:-1], np.gradient(half))[0, 1] < -0.8


@pytest.mark.parametrize('skew', [-0.9, -0.3, 0.3, 0.9])
def test_a_skewed_ripple_has_the_height_and_the_period_of_the_sine_and_is_steep_on_one_side(skew):
    """A compressor fills its receiver fast, and consumers empty it slowly, or the other way."""
    values = {'supply.ripple': 3e3, 'supply.ripple_frequency': 0.2, 'supply.ripple_skew': skew}
    time = rows(20.0)
    run = simulate(positioner(values), time, np.full_like(time, current_for(200e3)))
    wave = (run['supply_pressure'][:-1] - 400e3).reshape(4, -1)
    assert wave == pytest.approx(np.tile(wave[0], (4, 1)), abs=1e-6)
    assert (wave[0].min(), wave[0].max()) == pytest.approx((-3e3, 3e3), rel=2e-3)
    harmonics = np.fft.rfft(wave[0])[1:5]
    assert harmonics / harmonics[0] == pytest.approx(skew**np.arange(4) / np.arange(1, 5), abs=1e-3)
    rises = np.mean(np.diff(wave[0], append=wave[0][0]) > 0.0)
    assert rises == pytest.approx(np.arccos(skew) / np.pi, abs=5e-3)


def test_a_tabulated_supply_term_over_time_is_added_where_the_table_is_and_zero_outside():
    values = {
        'discrepancy.location': 'supply', 'discrepancy.variable': 'time',
        'discrepancy.knots': list(np.linspace(2.0, 13.0, 12)),
        'discrepancy.values': [100.0 * k for k in range(12)],
    }
    time = rows(15.0)
    run = simulate(positioner(values), time, np.full_like(time, PAPER_CURRENT))
    added = np.where((time >= 2.0) & (time <= 13.0), 100.0 * (time - 2.0), 0.0)
    at_edge = np.abs(time - 13.0) < 1e-6
    assert (run['supply_pressure'] - 400e3)[~at_edge] == pytest.approx(added[~at_edge], abs=1e-6)


@pytest.mark.parametrize(
    ('location', 'variable', 'column', 'per_unit'),
    [('ep_converter', 'control_current', 'back_pressure', 1.0),
     ('booster', 'back_pressure', 'booster_force', 1.0)],
)
def test_a_tabulated_upstream_term_enters_its_component(location, variable, column, per_unit):
    size = {'ep_converter': 500.0, 'booster': 0.01}[location]
    low, high = {'ep_converter': (0.3e-3, 0.5e-3), 'booster': (200e3, 300e3)}[location]
    values = {
        'discrepancy.location': location, 'discrepancy.variable': variable,
        'discrepancy.knots': list(np.linspace(low, high, 12)),
        'discrepancy.values': [size] * 12,
    }
    time = rows(3.0)
    current = np.full_like(time, current_for(230e3))
    given = {'chamber_pressure': np.full_like(time, 230e3)}
    with_term = simulate(positioner(values), time, current, pinned=given)
    without = simulate(positioner(), time, current, pinned=given)
    assert with_term[column][-1] - without[column][-1] == pytest.approx(per_unit * size, rel=1e-6)
    outside = simulate(positioner(values), time, np.full_like(time, 0.2e-3), pinned=given)
    plain = simulate(positioner(), time, np.full_like(time, 0.2e-3), pinned=given)
    assert np.array_equal(outside[column], plain[column])
