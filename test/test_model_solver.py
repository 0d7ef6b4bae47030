# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The solver: order, accuracy, repeatability, and one source of equations for every way to run."""

from itertools import pairwise
import math

import numpy as np
from positioner_runs import PAPER_CURRENT, current_for, paper_test, positioner, rows, settled_at
import pytest
from scipy.integrate import solve_ivp

from booster_ros.benchmark import cases
from booster_ros.benchmark.reference import reference, scipy_integrator
from booster_ros.model import solver
from booster_ros.model.compiled import compiled_run
from booster_ros.model.memory import MEMORIES, start_memory
from booster_ros.model.simulation import Plant, active_states, settled_state, simulate
from booster_ros.model.solver import advance, new_workspace
from booster_ros.model.state import (
    BACK, CHAMBER, OUTLET, POSITION, PRESSURE_DROP, STATES, VELOCITY)
from booster_ros.model.stream import Stream
from booster_ros.model.system import PositionerParameters, derivatives

EVERYTHING = {
    'ep_converter.hysteresis': 1e-6,
    'ep_converter.drift': 300.0,
    'ep_converter.nonlinearity_odd': 200.0,
    'ep_converter.dead_time': 0.123,
    'booster.orifice_law': 'isentropic',
    'booster.intake_preload': 0.02,
    'booster.exhaust_preload': 0.03,
    'booster.exhaust_gain_ratio': 0.8,
    'booster.intake_flow_force': 0.3,
    'booster.opening_exponent': 1.1,
    'booster.knee_softness': 0.3,
    'booster.supply_leak_area': 2e-9,
    'booster.exhaust_leak_area': 3e-9,
    'supply.droop': 1e7,
    'supply.ripple': 500.0,
    'tubing.restriction_area': 3e-6,
    'actuator.leak_area': 1e-8,
    'actuator.thermal_resistance': 0.5,
    'actuator.area_change': 0.05,
    'actuator.coulomb_friction': 200.0,
    'actuator.stiction': 60.0,
    'actuator.friction_gradient': 50.0,
    'actuator.friction_peak': 80.0,
    'actuator.spring_bend': 100.0,
    'actuator.seat_load': 300.0,
    'actuator.seat_stiffness': 5e7,
    'actuator.flow_force': 150.0,
    'sensors.pressure_lag': 0.05,
    'sensors.position_lag': 0.1,
    'sensors.position_backlash': 1e-4,
    'discrepancy.location': 'chamber',
    'discrepancy.variable': 'valve_position',
    'discrepancy.knots': list(np.linspace(0.0, 0.016, 12)),
    'discrepancy.values': [1e-7 * k for k in range(12)],
}


def fixed_steps(step: float, horizon: float = 0.05) -> np.ndarray:
    """Return the state after `horizon` s of filling, mid travel, flow below choking."""
    p = positioner()
    y = settled_state(p, float(current_for(200e3)), 200e3, None)
    memory = [0.0] * MEMORIES
    start_memory(p, 0.0, y, 1.0, memory)
    active = active_states(p)
    work = new_workspace()
    for k in range(round(horizon / step)):
        advance(p, k * step, float(current_for(260e3)), step, y, memory, active, len(active),
                math.inf, work)
    return np.array(y)


def test_order_3_on_a_smooth_piece():
    """Without error control, halving the step divides the error by 8."""
    exact = fixed_steps(2e-3 / 64)
    errors = np.array([np.abs(fixed_steps(2e-3 / 2**k) - exact) for k in range(4)])
    for state in (BACK, CHAMBER, POSITION, VELOCITY):
        orders = np.log2(errors[:-1, state] / errors[1:, state])
        assert np.all(np.abs(orders - 3.0) < 0.15), state


YIELDS = cases.stick_slip(1.0)._replace(name='yields', parameters=positioner(
    {'actuator.coulomb_friction': 400.0, 'actuator.presliding_stiffness': 2e7}))
"""Without stiction: with it, runs of any two solvers go apart."""


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def exact_run(case: cases.Case, rtol: float = 1e-8) -> dict[str, np.ndarray]:
    """Return the states by an integrator that is not ours: one with fewer calls than Radau."""
    return reference(case, rtol, scipy_integrator('LSODA'))


@pytest.mark.parametrize('case', [cases.paper_test(2.0), cases.stick_slip(1.0), YIELDS],
                         ids=lambda case: case.name)
def test_accuracy_against_another_integrator(case):
    """A short and coarse version of what `accuracy` measures over the whole records."""
    exact = exact_run(case)
    run = simulate(case.parameters, case.time, case.control_current, case.initial)
    assert np.ptp(exact['valve_position']) > 0.5e-3
    assert rms(run['valve_position'] - exact['valve_position']) < 5e-6
    assert rms(run['chamber_pressure'] - exact['chamber_pressure']) < 50.0


def test_tighter_tolerance_is_more_exact():
    case = cases.paper_test(2.0)
    exact = exact_run(case, rtol=1e-9)['chamber_pressure']

    def error(tolerance: float) -> float:
        run = simulate(
            case.parameters, case.time, case.control_current, case.initial, tolerance=tolerance)
        return rms(run['chamber_pressure'] - exact)

    assert error(0.01) < 0.3 * error(1.0) < 0.3 * 0.3 * error(100.0)


def test_error_does_not_grow_with_the_distance_of_the_rows():
    ends = []
    for dt in (1e-3, 0.01, 0.05, 0.25):
        time, current = paper_test(dt)
        run = simulate(positioner(), time, current, {'back_pressure': 0.0})
        ends.append(run['chamber_pressure'][:: round(0.25 / dt)])
    for other in ends[1:]:
        assert np.abs(other - ends[0]).max() < 50.0


@pytest.mark.parametrize('values', [{}, EVERYTHING], ids=['declared', 'all effects'])
def test_two_runs_are_bit_identical(values):
    time, current = paper_test()
    one = simulate(positioner(values), time, current)
    other = simulate(positioner(values), time, current)
    for name, column in one.columns.items():
        assert np.array_equal(column, other[name]), name


@pytest.mark.parametrize('values', [{}, EVERYTHING], ids=['declared', 'all effects'])
def test_machine_code_does_what_python_does(values):
    """The same functions, so the same numbers to the last bit."""
    if compiled_run() is None:
        pytest.skip('numba is not installed')
    time = rows(1.5)
    current = np.where(time < 1.0, PAPER_CURRENT, current_for(180e3))
    machine = simulate(positioner(values), time, current, settled_at(170e3))
    plain = simulate(positioner(values), time, current, settled_at(170e3), compiled=False)
    assert np.ptp(plain['valve_position']) > 1e-3
    for name, column in plain.columns.items():
        assert np.array_equal(machine[name], column), name


def stepwise(parameters: PositionerParameters, time: np.ndarray, current: np.ndarray,
             step: float) -> np.ndarray:
    plant = Plant(parameters, step)
    plant.reset(chamber_pressure=170e3, control_current=float(current[0]))
    seen = [plant.outputs()]
    for k in range(len(time) - 1):
        plant.advance(float(current[k]), round((time[k + 1] - time[k]) / step))
        seen.append(plant.outputs())
    return np.array(seen)


@pytest.mark.parametrize('values', [{}, EVERYTHING], ids=['declared', 'all effects'])
def test_plant_and_simulate_agree(values):
    """The node's way to run, and a record with the same steps."""
    time = rows(0.6, 1e-3)
    current = np.where(time < 0.4, PAPER_CURRENT, 0.3e-3)
    p = positioner(values)
    stepped = stepwise(p, time, current, 1e-3)
    whole = simulate(p, time, current, {'chamber_pressure': 170e3})
    assert np.ptp(whole['valve_position']) > 1e-3
    for index, name in enumerate(whole.columns):
        if name == 'control_current':
            continue  # at a change, one names the current that stood, the other the new one
        scale = max(np.abs(whole[name]).max(), 1e-12)
        assert np.abs(stepped[:, index] - whole[name]).max() < 1e-6 * scale, name


def test_plant_is_deterministic_whatever_the_portions():
    p = positioner(EVERYTHING)
    one, other = Plant(p), Plant(p)
    one.advance(PAPER_CURRENT, 300)
    for portion in (1, 7, 92, 200):
        other.advance(PAPER_CURRENT, portion)
    assert one.outputs() == other.outputs()
    assert one.time == pytest.approx(0.3)


def test_plant_keeps_its_state_when_parameters_change():
    plant = Plant(positioner())
    plant.advance(PAPER_CURRENT, 1000)
    before = plant.outputs()
    plant.parameters = positioner({'actuator.leak_area': 1e-7, 'actuator.coulomb_friction': 50.0})
    after = plant.outputs()
    assert (after.chamber_pressure, after.valve_position, after.stem_velocity, after.time) == (
        before.chamber_pressure, before.valve_position, before.stem_velocity, before.time)


def test_parameters_of_a_plant_at_rest_count_from_the_next_step():
    plant = Plant(positioner())
    plant.reset(chamber_pressure=225e3, control_current=float(current_for(225e3)))
    plant.advance(float(current_for(225e3)), 1003)
    plant.parameters = positioner({'actuator.leak_area': 1e-6})
    plant.advance(float(current_for(225e3)), 2)
    assert plant.outputs().chamber_pressure < 225e3 - 100.0


def test_plant_resets_to_a_given_state():
    plant = Plant(positioner())
    plant.advance(PAPER_CURRENT, 500)
    plant.reset(chamber_pressure=225e3, control_current=float(current_for(225e3)))
    start = plant.outputs()
    assert start.time == 0.0
    assert start.valve_position == pytest.approx(0.008, abs=1e-9)
    plant.advance(float(current_for(225e3)), 1000)
    assert plant.outputs().chamber_pressure == pytest.approx(225e3, abs=1.0)


@pytest.mark.parametrize('step', [0.0, -1e-3, math.nan, math.inf])
def test_plant_refuses_a_step_that_is_none(step):
    with pytest.raises(ValueError, match='step must be positive'):
        Plant(positioner(), step)


@pytest.mark.parametrize(('current', 'steps', 'complaint'), [
    (PAPER_CURRENT, -3, 'steps must not be negative, got -3'),
    (math.nan, 1, 'control_current must be finite, got nan'),
    (-math.inf, 1, 'control_current must be finite, got -inf'),
])
def test_plant_refuses_what_it_cannot_advance_by_and_goes_on(current, steps, complaint):
    plant, other = Plant(positioner()), Plant(positioner())
    with pytest.raises(ValueError, match=complaint):
        plant.advance(current, steps)
    assert plant.outputs() == other.outputs()
    for one in (plant, other):
        one.advance(PAPER_CURRENT, 20)
    assert plant.outputs() == other.outputs()


@pytest.mark.parametrize(
    ('time', 'current', 'complaint'),
    [
        ([0.0, 1.0], [0.0], 'equally long'),
        ([], [], 'empty'),
        ([0.0, 1.0, 0.9], [0.0] * 3, 'time must not fall'),
        ([0.0, math.nan, 2.0], [0.0] * 3, r'time\[1\] must be finite, got nan'),
        ([0.0, 1.0, math.inf], [0.0] * 3, r'time\[2\] must be finite, got inf'),
        ([0.0, 1.0], [0.0, math.nan], r'control_current\[1\] must be finite, got nan'),
        ([0.0, 1.0], [-math.inf, 0.0], r'control_current\[0\] must be finite, got -inf'),
    ],
)
def test_simulate_refuses_rows_that_do_not_fit(time, current, complaint):
    with pytest.raises(ValueError, match=complaint):
        simulate(positioner(), np.array(time), np.array(current))


@pytest.mark.parametrize(('given', 'complaint'), [
    ({'initial': {'foo': 1.0}}, 'initial: there is no state foo; there are back_pressure, '),
    ({'initial': {'past': math.nan}}, 'past must be finite, got nan'),
    ({'pinned': {'mass_flow': [0.0, 0.0]}}, 'pinned: there is no state mass_flow; there are '),
    ({'pinned': {'supply_pressure': [4e5]}},
     r'pinned supply_pressure must have a value for each of the 2 rows, got the shape \(1,\)'),
    ({'pinned': {'supply_pressure': 4e5}}, r'each of the 2 rows, got the shape \(\)'),
    ({'pinned': {'supply_pressure': [4e5, math.inf]}},
     r'supply_pressure\[1\] must be finite, got inf'),
    ({'tolerance': 0.0}, r'tolerance must be positive, got 0\.0'),
    ({'tolerance': math.nan}, 'tolerance must be positive, got nan'),
    ({'longest_interval': 0}, 'longest_interval must be positive, got 0'),
])
def test_simulate_refuses_what_would_be_nothing_or_not_a_number(given, complaint):
    with pytest.raises(ValueError, match=complaint):
        simulate(positioner(), [0.0, 1.0], [0.0, 0.0], **given)


def test_a_stream_refuses_portions_that_do_not_follow():
    stream = Stream(positioner(), 0.0, 0.0, pinned=('supply_pressure',))
    supply = {'supply_pressure': [4e5]}
    stream.advance([1.0], [0.0], supply)
    with pytest.raises(ValueError, match=r'time must not fall from 1\.0 to 0\.5 s'):
        stream.advance([0.5], [0.0], supply)
    with pytest.raises(ValueError, match='pinned: none given, but pinned from the start: supply_'):
        stream.advance([1.5], [0.0])
    with pytest.raises(ValueError, match='control_current must be finite, got inf'):
        Stream(positioner(), 0.0, math.inf)


def test_states_hold_all_that_is_integrated():
    assert len(settled_state(positioner(), 0.0, 0.0, None)) == STATES
    assert active_states(positioner()) == [BACK, CHAMBER, POSITION, VELOCITY]
    all_of_them = {**EVERYTHING, 'actuator.presliding_stiffness': 1e7,
                   'discrepancy.variable': 'valve_position_change'}
    assert active_states(positioner(all_of_them)) == [
        state for state in range(STATES) if state != PRESSURE_DROP]


@pytest.mark.parametrize('values', [{}, EVERYTHING], ids=['declared', 'all effects'])
def test_a_stream_in_portions_is_the_whole_run(values):
    p = positioner(values)
    time = rows(6.0)
    current = np.where(time < 4.0, PAPER_CURRENT, 0.3e-3)
    whole = simulate(p, time, current)
    stream = Stream(p, 0.0, float(current[0]))
    edges = [0, 1, 2, 14, 300, 301, len(time)]
    parts = [stream.advance(time[a:b], current[a:b]) for a, b in pairwise(edges)]
    for name, column in whole.columns.items():
        joined = np.concatenate([part[name] for part in parts])
        # the sum behind the dead time starts elsewhere, so its last digits may differ
        assert np.abs(joined - column).max() <= 1e-6 * np.abs(column).max(), name
    assert np.allclose(stream.state, whole.final_state, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize('stiffness', [5e7, 1e8])
def test_slips_of_a_packing_that_yields_are_those_of_another_solver(stiffness):
    """Ten slips and more in a second, of which each begins where the one before has ended."""
    p = positioner({'actuator.coulomb_friction': 300.0, 'actuator.stiction': 200.0,
                    'actuator.presliding_stiffness': stiffness})
    time, current, initial = rows(1.0), 0.44e-3, {'chamber_pressure': 170e3}
    start = [float(value) for value in Stream(p, 0.0, current, initial).state]
    active = active_states(p)

    def slopes(moment, values):
        y, rates = start.copy(), [0.0] * STATES
        for state, value in zip(active, values.tolist()):
            y[state] = value
        y[OUTLET] = y[CHAMBER]
        derivatives(p, moment, current, 0.0, y, rates)
        return [rates[state] for state in active]

    exact = solve_ivp(slopes, (0.0, time[-1]), [start[state] for state in active], 'LSODA', time,
                      rtol=1e-8, atol=1e-9)
    run = simulate(p, time, np.full(len(time), current), initial)
    assert np.sum(np.diff(np.sign(run['stem_velocity'] - 1e-3)) > 0.0) >= 10
    assert np.ptp(run['valve_position']) > 1.5e-3
    assert run['valve_position'] == pytest.approx(exact.y[active.index(POSITION)], abs=3e-6)


def test_where_portions_end_changes_no_bit():
    """A step that reaches beyond the last row of a portion is gone on with in the next."""
    p = positioner({'actuator.coulomb_friction': 200.0, 'sensors.position_lag': 0.1})
    time = rows(4.0)
    current = np.where(time < 2.51, PAPER_CURRENT, 0.3e-3)
    whole = simulate(p, time, current)
    stream = Stream(p, 0.0, float(current[0]))
    edges = [0, 1, 2, 14, 150, 251, 252, 300, len(time)]
    parts = [stream.advance(time[a:b], current[a:b]) for a, b in pairwise(edges)]
    for name, column in whole.columns.items():
        assert np.array_equal(np.concatenate([part[name] for part in parts]), column), name


def test_what_comes_later_changes_no_bit():
    """That a step reaches ahead is no look at the rows to come."""
    time = rows(3.0)
    stays = simulate(positioner(), time, np.full_like(time, PAPER_CURRENT))
    turns = simulate(positioner(), time, np.where(time < 1.505, PAPER_CURRENT, 0.3e-3))
    until = time < 1.515  # the new current shows in the row after the one that commands it
    for name, column in stays.columns.items():
        if name == 'control_current':
            continue
        assert np.array_equal(turns[name][until], column[until]), name
    assert turns['back_pressure'][152] < stays['back_pressure'][152] - 1e3


@pytest.mark.parametrize(('stands', 'length'), [(0.03, 2.0), (0.11, 2.0), (0.7, 4.0)])
def test_steps_ahead_are_left_in_time(stands, length):
    """A current that jumps about, at moments that cut steps short: still exact at all rows."""
    time = rows(length)
    level = np.array([0.40e-3, 0.47e-3, 0.36e-3, 0.43e-3, 0.45e-3])
    current = level[(time / stands + 1e-9).astype(int) % len(level)]
    case = cases.Case('jumps', positioner(), time, current, {'chamber_pressure': 180e3})
    exact = exact_run(case)
    run = simulate(case.parameters, time, current, case.initial)
    assert np.ptp(exact['valve_position']) > 0.3e-3
    assert rms(run['valve_position'] - exact['valve_position']) < 0.5e-6
    assert rms(run['chamber_pressure'] - exact['chamber_pressure']) < 10.0


def test_what_depends_on_time_is_followed_while_the_current_stands():
    p = positioner({'supply.ripple': 2e3, 'ep_converter.drift': 500.0})
    time = rows(5.0)
    run = simulate(p, time, np.full_like(time, PAPER_CURRENT), settled_at(200e3))
    fine = simulate(p, rows(5.0, 1e-3), np.full(5001, PAPER_CURRENT), settled_at(200e3))
    assert np.abs(run['chamber_pressure'] - fine['chamber_pressure'][::10]).max() < 50.0


@pytest.mark.parametrize(
    ('name', 'series'),
    [
        ('supply_pressure', lambda t: 380e3 + 20e3 * np.sin(t)),
        ('back_pressure', lambda t: 240e3 + 10e3 * np.sin(t)),
        ('chamber_pressure', lambda t: 225e3 + 50e3 * np.sin(t)),
    ],
)
def test_a_given_channel_is_followed(name, series):
    time = rows(6.0)
    run = simulate(
        positioner(), time, np.full_like(time, PAPER_CURRENT), pinned={name: series(time)})
    assert np.allclose(run[name], series(time), rtol=1e-9)
    free = simulate(positioner(), time, np.full_like(time, PAPER_CURRENT))
    assert np.abs(run['valve_position'] - free['valve_position']).max() > 1e-4


@pytest.mark.parametrize('values', [{}, EVERYTHING], ids=['declared', 'all effects'])
def test_of_two_rows_with_one_stamp_the_last_counts(values):
    """A step may be written as two rows at one time."""
    p = positioner(values)
    time = rows(4.0)
    current = np.where(time < 1.0, 0.3e-3, PAPER_CURRENT)
    single = simulate(p, time, current)
    at = int(np.argmax(current == PAPER_CURRENT))
    double = simulate(p, np.insert(time, at, time[at]), np.insert(current, at, 0.3e-3))
    for name, column in single.columns.items():
        assert np.array_equal(np.delete(double[name], at), column), name


@pytest.mark.parametrize('ends', [(0.6, 0.9), (0.9, 0.6)], ids=['released', 'pressed'])
def test_a_stem_that_creeps_in_its_stop_takes_few_steps(monkeypatch, ends):
    """It stopped and went at every third step, as its velocity was that of the solver's error."""
    tried = []
    once = solver._try_step
    monkeypatch.setattr(solver, '_try_step', lambda *given: tried.append(1) or once(*given))
    p = positioner({'actuator.coulomb_friction': 300.0})
    time = rows(1.0)
    pressure = p.actuator.bench_set[0] * np.interp(time, (0.0, 1.0), ends)
    run = simulate(p, time, np.zeros_like(time), pinned={'chamber_pressure': pressure},
                   compiled=False)
    assert len(tried) < 40 * len(time)
    force = p.actuator.effective_area * (p.actuator.bench_set[0] - pressure)
    pressed = -p.actuator.stop_stiffness * run['valve_position']
    # friction holds the rest; the pressure of a row is reached half a row later
    assert np.all(np.abs(pressed - force)[1:] < 300.0 + np.abs(np.diff(force)).max())
    assert np.ptp(pressed) > 0.8 * np.ptp(force) - 300.0
