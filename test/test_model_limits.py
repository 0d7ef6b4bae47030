# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Whatever is allowed as a parameter or a current: no NaN, and pressures stay physical."""

import math

from hypothesis import HealthCheck, given, settings, strategies
import numpy as np
from positioner_runs import positioner, rows
import pytest

from booster_ros.model import solver
from booster_ros.model.outputs import Outputs
from booster_ros.model.parameters import from_values
from booster_ros.model.simulation import Plant, simulate

# Ranges of real devices, much wider than any one of them.
SIZES = {
    'ep_converter.time_constant': (0.01, 0.5),
    'booster.opening_gain': (1e-7, 1e-5),
    'booster.max_area': (1e-7, 1e-5),
    'booster.critical_pressure_ratio': (0.1, 0.8),
    'supply.pressure': (100e3, 700e3),
    'supply.temperature': (250.0, 340.0),
    'actuator.effective_area': (0.01, 0.15),
    'actuator.dead_volume': (5e-5, 2e-3),
    'actuator.polytropic_index': (1.0, 1.4),
    'actuator.moving_mass': (0.5, 50.0),
    'actuator.travel': (0.005, 0.1),
    'actuator.viscous_friction': (100.0, 30_000.0),
}
EFFECTS = {
    'ep_converter.hysteresis': (0.0, 2e-5),
    'ep_converter.dead_time': (0.0, 0.5),
    'booster.intake_preload': (0.0, 0.5),
    'booster.exhaust_preload': (0.0, 0.5),
    'booster.exhaust_gain_ratio': (0.3, 3.0),
    'booster.intake_flow_force': (0.0, 2.0),
    'booster.opening_exponent': (0.6, 2.0),
    'booster.knee_softness': (0.0, 1.0),
    'booster.supply_leak_area': (0.0, 1e-7),
    'booster.exhaust_leak_area': (0.0, 1e-7),
    'supply.droop': (0.0, 1e8),
    'tubing.restriction_area': (5e-7, 1e-5),
    'tubing.outlet_volume': (1e-5, 1e-4),
    'actuator.leak_area': (0.0, 1e-6),
    'actuator.thermal_resistance': (0.01, 100.0),
    'actuator.area_change': (-0.1, 0.2),
    'actuator.upper_travel_lost': (0.0, 0.4),
    'actuator.lower_travel_lost': (0.0, 0.4),
    'actuator.added_damping': (0.0, 1e6),
    'actuator.spring_loss': (-0.5, 0.8),
    'actuator.coulomb_friction': (0.0, 1500.0),
    'actuator.stiction': (0.0, 800.0),
    'actuator.stribeck_velocity': (1e-4, 1e-2),
    'actuator.friction_gradient': (-200.0, 500.0),
    'actuator.friction_peak': (0.0, 800.0),
    'actuator.friction_peak_width': (5e-4, 1e-2),
    'actuator.spring_bend': (-300.0, 300.0),
    'actuator.seat_load': (0.0, 2000.0),
    'actuator.seat_stiffness': (1e8, 1e10),
    'actuator.flow_force': (-500.0, 500.0),
    'sensors.position_lag': (0.0, 1.0),
    'sensors.position_backlash': (0.0, 1e-3),
}
TIME = rows(8.0)


def some(ranges: dict[str, tuple[float, float]]):
    return strategies.fixed_dictionaries(
        {}, optional={name: strategies.floats(*bounds) for name, bounds in ranges.items()})


@settings(max_examples=60, deadline=None, derandomize=True,
          suppress_health_check=[HealthCheck.too_slow])
@given(
    sizes=some(SIZES),
    effects=some(EFFECTS),
    law=strategies.sampled_from(['iso_6358', 'isentropic']),
    booster=strategies.sampled_from(['three_diaphragms', 'three_diaphragms', 'none']),
    actuator=strategies.sampled_from(['stem', 'stem', 'vessel']),
    levels=strategies.lists(strategies.floats(0.0, 1.5e-3), min_size=1, max_size=8),
)
def test_nothing_leaves_physics(sizes, effects, law, booster, actuator, levels):
    p = positioner({**sizes, **effects, 'booster.orifice_law': law, 'booster.kind': booster,
                    'actuator.kind': actuator})
    current = np.array(levels)[(np.arange(len(TIME)) * len(levels)) // len(TIME)]
    run = simulate(p, TIME, current)
    for name, column in run.columns.items():
        assert np.all(np.isfinite(column)), name
    supply = p.supply.pressure
    cold = p.actuator.thermal_resistance > 0.0 or p.actuator.polytropic_index > 1.0
    # a stem that a spring or a flow force moves may pull a slight vacuum, or compress a little
    slack = 0.6 * supply if cold else 0.05 * supply + 2e3
    assert run['chamber_pressure'].min() > -101_325.0
    for name in ('chamber_pressure', 'outlet_pressure'):
        assert run[name].max() < supply + slack, name
    assert run['back_pressure'].min() >= -5.0  # the tolerance of the solver
    assert run['back_pressure'].max() <= supply + 5.0
    assert run['supply_pressure'].min() > 0.0
    travel = p.actuator.travel
    assert run['valve_position'].min() > -0.05 * travel
    assert run['valve_position'].max() < 1.05 * travel
    assert run['gas_temperature'].min() > 100.0
    assert run['gas_temperature'].max() < 700.0
    assert run['intake_area'].min() >= 0.0
    assert run['intake_area'].max() <= p.booster.max_area * (1.0 + 1e-12)
    # never both seats at once
    assert not np.any((run['intake_area'] > 0.0) & (run['exhaust_area'] > 0.0))


@pytest.mark.parametrize('values', [
    {'actuator.presliding_stiffness': 1e9, 'actuator.stiction': 200.0},
    {'actuator.presliding_stiffness': 2e8, 'actuator.stiction': 50.0},
    {'actuator.moving_mass': 0.5, 'actuator.stiction': 1031.0},
    {'actuator.stop_damping': 3.1e7, 'booster.exhaust_leak_area': 1.77e-6},
], ids=lambda values: ' '.join(name.split('.')[1] for name in values))
def test_what_is_over_within_a_microsecond_is_followed(values):
    means = []
    for dt in (0.01, 1e-3):
        time = rows(3.0, dt)
        current = np.array([0.6e-3, 0.3e-3, 0.45e-3, 0.45e-3])[(time + 1e-9).astype(int)]
        run = simulate(positioner(values), time, current, {'chamber_pressure': 200e3})
        means.append(np.mean(run['chamber_pressure'][time > 2.5]))
    # not the ends: by then another slip may have begun, or not
    assert means[0] == pytest.approx(means[1], abs=500.0)


UNDEFINED = (
    # a seat that leaks like a burst pipe: pressures and temperatures below zero within a step
    {'booster.supply_leak_area': 1e-3, 'supply.droop': 4.5e11},
    {'booster.supply_leak_area': 1e-3, 'actuator.thermal_resistance': 0.0027},
    {'actuator.dead_volume': 1e-9, 'actuator.thermal_resistance': 6958.8},
    # a friction of tonnes on a chamber that empties at once: slips without end
    {'actuator.friction_peak': 232487.76, 'tubing.restriction_area': 0.55,
     'booster.exhaust_flow_force': 224.4},
    {'actuator.friction_gradient': 1e6, 'actuator.viscous_friction': 4e8,
     'actuator.stribeck_velocity': 0.06, 'ep_converter.nonlinearity_odd': -1e6},
    # a breath of friction, in a packing that yields and a gas that is as warm as its wall at once
    {'actuator.presliding_stiffness': 1.3e6, 'actuator.stiction': 4e-8,
     'actuator.thermal_resistance': 1.3e-7},
)


@pytest.mark.parametrize('values', UNDEFINED)
def test_where_plain_python_finds_no_solution_there_is_none_from_there_on(values):
    """It raised math domain error, or took minutes for a second."""
    plant = Plant(from_values(values), 1e-2)
    lost = []
    for _ in range(20):
        plant.advance(2e-3, 10)
        readings = plant.readings()
        assert len(plant.outputs()) == len(Outputs._fields)
        lost.append(not all(map(math.isfinite, readings)))
    assert lost == sorted(lost)  # once lost, it stays so
    assert plant.is_lost == lost[-1]
    plant.parameters = from_values({})
    plant.reset()
    plant.advance(2e-3, 10)
    assert all(map(math.isfinite, plant.readings()))


def test_rows_behind_the_last_solution_are_no_numbers():
    time = np.arange(40) * 1e-2
    run = simulate(from_values(UNDEFINED[-1]), time, np.full_like(time, 2e-3), compiled=False)
    known = np.isfinite(run['chamber_pressure'])
    assert known[0]
    assert not known[-1]
    assert (np.diff(known.astype(int)) <= 0).all()


@pytest.mark.parametrize('values', [*UNDEFINED, {'ep_converter.dead_time': 0.137}])
def test_machine_code_and_plain_python_end_at_the_same_row(values, monkeypatch):
    time = np.arange(100) * 1e-2
    current = np.where(time < 0.5, 4e-4, 4.6e-4)
    machine = simulate(from_values(values), time, current)
    # after machine code, into which the limit is compiled: what never ends does not take longer
    monkeypatch.setattr(solver, 'MOST_STEPS', solver.MOST_STEPS // 4)
    plain = simulate(from_values(values), time, current, compiled=False)
    for name, column in machine.columns.items():
        # `max` hides a NaN of machine code within a step; where there is a solution is the same
        np.testing.assert_array_equal(
            np.isfinite(plain[name]), np.isfinite(column), err_msg=name)
        if 'ep_converter.dead_time' in values:
            np.testing.assert_array_equal(plain[name], column, err_msg=name)


def test_a_set_that_has_no_state_to_start_from_is_lost_at_once(monkeypatch):
    def undefined(*_, **__):
        raise OverflowError('math range error')

    monkeypatch.setattr('booster_ros.model.simulation.settled_state', undefined)
    plant = Plant(from_values({}))
    plant.advance(2e-3, 1)
    assert plant.is_lost
    assert not any(map(math.isfinite, plant.readings()))
