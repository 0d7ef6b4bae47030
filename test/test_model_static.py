# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where the declared positioner settles, and how fast: figures that follow from its equations."""

from hypothesis import assume, given, settings, strategies
import numpy as np
from positioner_runs import PAPER_CURRENT, current_for, positioner, rows, settled_at
import pytest

from booster_ros.model.actuator import balance_position, stem_force
from booster_ros.model.parameters import DESCRIPTIONS
from booster_ros.model.simulation import Simulation, simulate
from booster_ros.paper.indices import step_indices
from booster_ros.paper.printed import table_3

S1, S2, S3 = 13.52e-6, 9.28e-6, 3.14e-6
LONG = rows(200.0, 0.05)


def settle(
    current: float, values: dict[str, object] | None = None, near: float = 200e3
) -> Simulation:
    """Hold the current until nothing moves, starting not far from where it settles."""
    return simulate(positioner(values), LONG, np.full_like(LONG, current), settled_at(near))


@pytest.mark.parametrize('pressure', [30e3, 160e3, 225e3, 290e3, 350e3])
def test_settled_back_pressure_over_chamber_pressure(pressure):
    """p_b = 181.7 kPa + 0.2322 p wherever the booster has come to rest."""
    end = settle(float(current_for(pressure)), near=pressure - 20e3)
    chamber, back = end['chamber_pressure'][-1], end['back_pressure'][-1]
    assert chamber == pytest.approx(pressure, abs=5.0)
    assert back == pytest.approx(181.7e3 + 0.2322 * chamber, rel=1e-3)


def test_booster_gain():
    """dp/dp_b = S1/S3 = 4.306."""
    low, high = settle(0.42e-3), settle(0.43e-3)
    gain = (high['chamber_pressure'][-1] - low['chamber_pressure'][-1]) / (
        high['back_pressure'][-1] - low['back_pressure'][-1]
    )
    assert gain == pytest.approx(4.306, abs=2e-3)


def test_more_supply_gives_less_output():
    """dp/dp_s = -(S2 - S3)/S3 = -1.955 at constant back pressure."""
    declared, more = settle(0.43e-3), settle(0.43e-3, {'supply.pressure': 410e3})
    assert more['back_pressure'][-1] == pytest.approx(declared['back_pressure'][-1])
    change = more['chamber_pressure'][-1] - declared['chamber_pressure'][-1]
    assert change / 10e3 == pytest.approx(-1.955, abs=2e-3)


def test_full_travel_takes_a_fifteenth_of_a_milliampere():
    closed, full = float(current_for(150e3)), float(current_for(300e3))
    assert full - closed == pytest.approx(0.07e-3, rel=0.1)
    assert settle(closed, near=145e3)['valve_position'][-1] == pytest.approx(0.0, abs=5e-6)
    assert settle(full, near=295e3)['valve_position'][-1] == pytest.approx(0.016, abs=5e-6)


@pytest.mark.parametrize(('values', 'pressure', 'outside'), [
    ({'actuator.seat_stiffness': 6e6}, 0.0, 0.1),
    ({'actuator.stop_stiffness': 5e6}, 0.0, 0.1),
    ({'actuator.stop_stiffness': 1e5}, 0.0, 0.1),
    ({'actuator.stop_stiffness': 1e5}, 400e3, 0.1),
    ({'actuator.travel': 1e-4}, 0.0, 0.1),
    ({'actuator.effective_area': 10.0, 'actuator.travel': 1e-5}, 400e3, 0.1),
    ({}, 0.0, 0.0)], ids=str)
def test_a_stem_at_rest_is_as_deep_in_seat_or_stop_as_these_yield(values, pressure, outside):
    actuator = positioner(values).actuator
    position = balance_position(actuator, pressure)
    assert max(-position, position - actuator.travel) > outside * actuator.travel
    assert stem_force(actuator, pressure, position, 0.0, 0.0) == pytest.approx(0.0, abs=1e-3)


def anything(name: str, smallest: float | None = None):
    """Return a strategy for an actuator's parameter in its bounds, by magnitude where told."""
    low, high = (getattr(DESCRIPTIONS[f'actuator.{name}'], end) for end in ('low', 'high'))
    if smallest is None:
        return strategies.floats(low, high)
    exponents = strategies.floats(np.log10(smallest), np.log10(high))
    return exponents.map(lambda exponent: float(np.clip(10.0**exponent, low, high)))


SIZES = {name: anything(name, smallest) for name, smallest in {
    'travel': 1e-5, 'stop_stiffness': 1e5, 'effective_area': 1e-6, 'seat_stiffness': 1e3,
    'seat_depth': 1e-6, 'flow_force_decay': 0.01}.items()}
FORCES = {name: anything(name) for name in (
    'area_change', 'bench_set_shift', 'spring_bend', 'spring_s_curve', 'spring_excess',
    'seat_load', 'flow_force')}


@settings(max_examples=300, deadline=None, derandomize=True)
@given(values=strategies.fixed_dictionaries({}, optional=SIZES | FORCES),
       pressure=strategies.floats(-100e3, 2e6))
def test_whatever_is_allowed_the_force_on_a_balanced_stem_turns_where_it_stands(values, pressure):
    act = positioner({f'actuator.{name}': value for name, value in values.items()}).actuator
    softest = act.stop_stiffness
    if act.seat_stiffness > 0.0:
        softest = 1.0 / (1.0 / act.seat_stiffness + 1.0 / softest)
    span = act.bench_set[1] - act.bench_set[0] + act.area_change * pressure
    assume(softest + act.effective_area * span / act.travel > 0.1 * softest)  # else it runs away
    position = balance_position(act, pressure)
    apart = 1e-9 * (act.travel + abs(position))
    below, above = (
        stem_force(act, pressure, position + side * apart, 0.0, 0.0) for side in (-1.0, 1.0))
    assert below > 0.0 > above


def test_a_stem_that_no_stop_can_hold_starts_at_one():
    """Its area grows in the soft stop by more than that pushes back."""
    act = positioner({'actuator.area_change': -0.9, 'actuator.stop_stiffness': 1e5,
                      'actuator.travel': 1e-4}).actuator
    assert balance_position(act, 400e3) == act.travel


def test_position_is_the_spring_balance():
    end = settle(float(current_for(240e3)))
    share = (end['chamber_pressure'][-1] - 150e3) / 150e3
    assert end['valve_position'][-1] == pytest.approx(0.016 * share, abs=1e-7)


@pytest.mark.parametrize(
    ('current', 'position'), [(0.0, 0.0), (1e-3, 0.016)], ids=['vented', 'full supply']
)
def test_end_stops_hold_the_stem(current, position):
    end = settle(current)
    assert end['valve_position'][-1] == pytest.approx(position, abs=30e-6)
    assert abs(end['stem_velocity'][-1]) < 1e-9


def test_chamber_reaches_neither_more_than_the_supply_nor_less_than_the_atmosphere():
    assert settle(1e-3)['chamber_pressure'].max() <= 400e3 + 1.0
    assert settle(0.0)['chamber_pressure'].min() >= -1.0


def test_table_iii_of_the_paper_simulated_column():
    time = rows(40.0, 1e-3)
    run = simulate(
        positioner(), time, np.full_like(time, PAPER_CURRENT), {'back_pressure': 0.0}
    )
    ours = step_indices(time, run['chamber_pressure'])._asdict()
    for name, printed in table_3().items():
        assert ours[name] == pytest.approx(printed.simulated, rel=0.01), name


def test_one_factor_on_area_volume_and_openings_changes_nothing():
    """Only ratios to the volume can be identified; mass and friction are forces and scale too."""
    scaled = ('actuator.effective_area', 'actuator.dead_volume', 'booster.opening_gain',
              'booster.max_area', 'actuator.moving_mass', 'actuator.viscous_friction',
              'actuator.stop_stiffness', 'actuator.stop_damping')
    declared = positioner()
    values = {}
    for name in scaled:
        component, field = name.split('.')
        values[name] = 0.44 * getattr(getattr(declared, component), field)
    time = rows(30.0)
    current = np.where(time < 15.0, PAPER_CURRENT, 0.38e-3)
    one = simulate(declared, time, current)
    other = simulate(positioner(values), time, current)
    assert np.abs(one['chamber_pressure'] - other['chamber_pressure']).max() < 1.0
    assert np.abs(one['valve_position'] - other['valve_position']).max() < 1e-8
    assert np.allclose(0.44 * one['mass_flow'], other['mass_flow'], rtol=1e-3, atol=1e-9)
