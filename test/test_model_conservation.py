# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Mass in = mass out + mass stored, counted from the outputs with equations written here."""

import numpy as np
from positioner_runs import current_for, positioner, rows
import pytest

from booster_ros.model.memory import MEMORIES
from booster_ros.model.outputs import observe
from booster_ros.model.simulation import Simulation, settled_state, simulate
from booster_ros.model.state import CHAMBER, OUTLET, STATES
from booster_ros.model.system import derivatives, seat_flows

R = 287.0
ATMOSPHERE = 101_325.0
AREA, DEAD_VOLUME = 0.0796, 0.185e-3
AMBIENT = 293.15
TIME = rows(30.0, 1e-3)
LEAK_AREA = 5e-8
OUTLET_VOLUME = 4e-5
TAKEN_OFF = -1.5e-4


def up_down_up(time: np.ndarray) -> np.ndarray:
    """Fill from rest, vent, fill halfway: intake and exhaust, choked and not, both end stops."""
    levels = np.array([0.5e-3, float(current_for(80e3)), float(current_for(220e3))])
    return levels[np.minimum((time // 10.0).astype(int), 2)]


def stored(run: Simulation, outlet_volume: float, opened: np.ndarray | float = 0.0) -> np.ndarray:
    chamber = DEAD_VOLUME + AREA * run['valve_position'] + opened
    chamber = np.maximum(chamber, 0.05 * DEAD_VOLUME)
    gas = (run['chamber_pressure'] + ATMOSPHERE) * chamber / (R * run['gas_temperature'])
    return gas + (run['outlet_pressure'] + ATMOSPHERE) * outlet_volume / (R * AMBIENT)


def leaked(run: Simulation, area: float) -> np.ndarray:
    """Return the flow of a leak to the atmosphere, kg/s (ellipse law, pressures above it)."""
    absolute = np.maximum(run['chamber_pressure'] + ATMOSPHERE, ATMOSPHERE)
    beyond = np.maximum(ATMOSPHERE / absolute - 0.5283, 0.0) / (1.0 - 0.5283)
    psi = np.sqrt(np.maximum(1.0 - beyond**2, 0.0))
    return 0.0404184 * area * absolute / np.sqrt(run['gas_temperature']) * psi


def integral(flow: np.ndarray) -> np.ndarray:
    parts = 0.5 * (flow[1:] + flow[:-1]) * np.diff(TIME)
    return np.concatenate(([0.0], np.cumsum(parts)))


EFFECTS = {
    'leak': {'actuator.leak_area': LEAK_AREA},
    'tubing': {'tubing.restriction_area': 2e-6, 'tubing.outlet_volume': OUTLET_VOLUME},
    'heat': {'actuator.thermal_resistance': 0.5},
    'friction': {'actuator.coulomb_friction': 400.0, 'actuator.stiction': 150.0},
    'droop': {'supply.droop': 3e7},
    'tight': {'actuator.added_volume': TAKEN_OFF},
    'seat': {'actuator.seat_stiffness': 6e6},
}
COMBINATIONS = [
    (), ('leak',), ('tubing',), ('heat',), ('friction',), ('leak', 'tubing', 'heat'),
    ('leak', 'tubing', 'heat', 'friction', 'droop'),
    # a stem that sinks into its seat would leave less than no volume
    ('tight', 'seat'), ('tight', 'seat', 'heat'),
]


@pytest.mark.parametrize('effects', COMBINATIONS, ids='+'.join)
def test_mass_balance(effects):
    values = {name: value for effect in effects for name, value in EFFECTS[effect].items()}
    run = simulate(positioner(values), TIME, up_down_up(TIME))
    gain = stored(run, OUTLET_VOLUME if 'tubing' in effects else 0.0,
                  TAKEN_OFF if 'tight' in effects else 0.0)
    supplied = integral(run['mass_flow'])
    lost = integral(leaked(run, LEAK_AREA if 'leak' in effects else 0.0))
    gain -= gain[0]
    turnover = np.sum(np.abs(run['mass_flow'])) * 1e-3
    assert gain.max() > 5e-3  # kg: the chamber did fill
    if 'leak' in effects:
        assert lost[-1] > 0.05 * gain.max()
    assert np.abs(supplied - lost - gain).max() < 1e-4 * turnover


ENDS = {'valve_position': (-0.002, 0.02), 'chamber_pressure': (-5e4, 5e5)}


@pytest.mark.parametrize('heat', [{}, EFFECTS['heat']], ids=['isothermal', 'heat'])
@pytest.mark.parametrize('mean', [2e-5, -2e-4], ids=['room left', 'none left'])
@pytest.mark.parametrize('variable', ENDS)
def test_mass_balance_of_a_chamber_whose_volume_has_a_term(variable, mean, heat):
    low, high = ENDS[variable]
    volumes = mean + 5e-5 * np.sin(np.arange(12.0) / 3.0)
    run = simulate(positioner({
        'discrepancy.location': 'chamber_volume', 'discrepancy.variable': variable,
        'discrepancy.knots': list(np.linspace(low, high, 12)),
        'discrepancy.values': volumes.tolist(), **heat}), TIME, up_down_up(TIME))
    opened = np.interp(run[variable], np.linspace(low, high, 12), volumes)
    gain = stored(run, 0.0, opened)
    gain -= gain[0]
    supplied = integral(run['mass_flow'])
    turnover = np.sum(np.abs(run['mass_flow'])) * 1e-3
    assert np.abs(supplied - gain).max() < 2e-4 * turnover
    declared = stored(run, 0.0)
    assert np.abs(supplied - (declared - declared[0])).max() > 50e-4 * turnover


def test_heat_changes_temperature_but_not_the_gas_law_at_rest():
    """The energy balance ends where the isothermal one does."""
    long = rows(120.0, 0.05)
    current = np.full_like(long, current_for(250e3))
    hot = simulate(positioner(EFFECTS['heat']), long, current)
    even = simulate(positioner(), long, current)
    assert np.ptp(hot['gas_temperature']) > 5.0
    assert hot['gas_temperature'][-1] == pytest.approx(AMBIENT, abs=0.01)
    assert hot['chamber_pressure'][-1] == pytest.approx(even['chamber_pressure'][-1], abs=5.0)


def test_air_that_flows_through_takes_its_heat_along():
    """Both seats leak: as much comes in as goes out, but not as warm."""
    resistance, exhaust_leak = 20.0, 4e-8
    run = simulate(positioner({
        'booster.max_area': 0.0, 'booster.supply_leak_area': 1e-8,
        'booster.exhaust_leak_area': exhaust_leak, 'actuator.thermal_resistance': resistance,
    }), TIME, np.zeros_like(TIME), {'chamber_pressure': 30e3, 'gas_temperature': 340.0})
    warm, out = run['gas_temperature'], leaked(run, exhaust_leak)
    into = run['mass_flow'] + out
    energy = (run['chamber_pressure'] + ATMOSPHERE) * DEAD_VOLUME / 0.4
    gained = integral(3.5 * R * (into * AMBIENT - out * warm) - (warm - AMBIENT) / resistance)
    carried_out = integral(3.5 * R * out * (warm - AMBIENT))
    assert run['valve_position'].max() < 1e-6
    assert carried_out[-1] > 1.0  # J
    assert np.abs(energy - energy[0] - gained).max() < 0.02 * carried_out[-1]


@pytest.mark.parametrize(('effect', 'place', 'volume'), [
    ({}, CHAMBER, DEAD_VOLUME), (EFFECTS['tubing'], OUTLET, OUTLET_VOLUME)],
    ids=['chamber', 'outlet'])
@pytest.mark.parametrize('current', [0.5e-3, 0.0], ids=['fills', 'vents'])
def test_the_flows_of_the_seats_that_are_seen_are_those_that_fill(effect, place, volume, current):
    """A stem at rest on its seat, and as much pressure before the tube as behind it."""
    leaks = {'booster.supply_leak_area': 1e-8, 'booster.exhaust_leak_area': 2e-8}
    p = positioner({**leaks, **effect})
    y = settled_state(p, current, 90e3, 0.0)
    seen = observe(p, 0.0, current, current, y, [0.0] * MEMORIES)
    opened_in, opened_out, into, out = seat_flows(p, seen.booster_force, y, AMBIENT)
    assert min(into, out) > 0.0
    assert (opened_in > 0.0, opened_out > 0.0) == (current > 0.0, current == 0.0)
    assert (seen.intake_area, seen.exhaust_area) == (opened_in, opened_out)
    assert seen.mass_flow == into - out
    rates = [0.0] * STATES
    derivatives(p, 0.0, current, 0.0, y, rates)
    assert rates[place] == pytest.approx(R * AMBIENT * (into - out) / volume)


def test_closed_booster_keeps_its_mass():
    """No current in the dead band between the seats: what is in stays in, to the last gram."""
    shut = positioner({'booster.max_area': 0.0, 'actuator.thermal_resistance': 0.5})
    run = simulate(
        shut, TIME, np.zeros_like(TIME),
        {'chamber_pressure': 200e3, 'valve_position': 0.008, 'gas_temperature': 320.0},
    )
    mass = stored(run, 0.0)
    assert np.ptp(run['chamber_pressure']) > 1e3  # it cools meanwhile
    assert np.ptp(mass) < 1e-6 * mass[0]
