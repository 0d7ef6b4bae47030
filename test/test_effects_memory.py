# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Terms without a name that follow a recent change: what creeps, and what warms up."""

import numpy as np
from positioner_runs import current_for, follow_pressure, positioner, rows, settled_at
import pytest

from booster_ros.diagnosis.data.experiment import Experiment, Initial
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.model.term_course import followed
from booster_ros.model.memory import Departure
from booster_ros.model.simulation import Plant, simulate

MEMORY = 4.0
LOW, HIGH = float(current_for(200e3)), float(current_for(260e3))
AREA, SPRING_RATE = 0.0796, 0.0796 * 150e3 / 0.016


def creeping(location, variable, high, most):
    """Return values of a term that rises from -`most` to `most` over a change of ±`high`."""
    return {
        'discrepancy.location': location, 'discrepancy.variable': variable,
        'discrepancy.knots': list(np.linspace(-high, high, 12)), 'discrepancy.memory': MEMORY,
        'discrepancy.values': list(np.linspace(-most, most, 12)),
    }


CONVERTER = creeping('ep_converter', 'control_current_change', 1e-4, 5e3)
SPRING = creeping('stem', 'valve_position_change', 16e-3, 400.0)
SENSOR = creeping('pressure_sensor', 'chamber_pressure_change', 1e5, 2e3)


def stepped(values, compiled=True, **more):
    """Return a run over a step of the current at 1 s, from rest."""
    time = rows(21.0)
    current = np.where(time < 1.0, LOW, HIGH)
    return simulate(
        positioner(values), time, current, settled_at(200e3), compiled=compiled, **more)


def test_a_converter_that_creeps_overshoots_and_comes_back_as_what_was_is_forgotten():
    run, declared = stepped(CONVERTER), stepped({})
    extra = run['back_pressure'] - declared['back_pressure']
    since = run['time'] - 1.0
    expected = 5e3 * (HIGH - LOW) / 1e-4 * np.exp(-since / MEMORY)
    later = since > 0.5  # the converter's own lag of 34 ms is over
    assert extra[later] == pytest.approx(expected[later] / (1.0 - 0.034 / MEMORY), abs=2.0)
    assert np.all(np.abs(extra[since < 0.0]) < 1e-6)


def test_a_spring_that_creeps_holds_the_stem_back_and_lets_it_come():
    time = rows(40.0)
    pressure = np.where(time < 5.0, 180e3, 220e3)
    run = follow_pressure({**SPRING, 'discrepancy.values': SPRING['discrepancy.values'][::-1]},
                          time, pressure)
    declared = follow_pressure({}, time, pressure)
    behind = declared['valve_position'] - run['valve_position']
    step = 40e3 * AREA / SPRING_RATE
    assert np.abs(behind[time < 4.9]).max() < 1e-7
    at_once = int(np.argmax(time > 5.1))
    added = 400.0 / 16e-3  # N/m, while the spring has not yet given way
    assert behind[at_once] == pytest.approx(step * added / (SPRING_RATE + added), rel=0.05)
    assert 0.0 <= behind[-1] < 0.01 * behind[at_once]


@pytest.mark.parametrize('values', [CONVERTER, SPRING, SENSOR])
def test_plain_and_compiled_give_the_same_bits(values):
    plain, compiled = stepped(values, compiled=False), stepped(values)
    for name, column in plain.columns.items():
        assert np.array_equal(column, compiled[name]), name


@pytest.mark.parametrize(('values', 'column', 'read'), [
    (SENSOR, 'chamber_pressure', 'measured_chamber_pressure'),
    (creeping('pressure_sensor', 'valve_position_change', 16e-3, 2e3), 'chamber_pressure',
     'measured_chamber_pressure'),
    (creeping('position_sensor', 'control_current_change', 1e-4, 1e-4), 'valve_position',
     'measured_valve_position'),
])
def test_the_change_over_a_record_is_that_of_the_model(values, column, read):
    run = stepped(values)
    change = followed(positioner(values), run['time'], run.columns)
    slope = values['discrepancy.values'][-1] / values['discrepancy.knots'][-1]
    added = run[read] - run[column]
    assert np.abs(added).max() > 0.1 * values['discrepancy.values'][-1]
    stands = np.append(True, np.diff(run['control_current']) == 0.0)  # else seen from the next row
    assert added[stands] == pytest.approx(
        slope * change[stands], abs=2e-3 * np.abs(added).max())


def test_a_term_put_into_a_running_plant_knows_no_past():
    plant = Plant(positioner({}), 0.01)
    plant.reset(200e3, None, LOW)
    plant.advance(LOW, 500)
    before = plant.outputs()
    plant.parameters = positioner(CONVERTER)
    plant.advance(LOW, 100)
    assert plant.outputs().back_pressure == pytest.approx(before.back_pressure, abs=1e-6)
    plant.advance(HIGH, 50)
    assert plant.outputs().back_pressure > HIGH * 5.4e8 + 1e3


def test_a_run_may_begin_with_what_was_of_late_another():
    """Half its unit, 0.05 mA, above: the converter starts that much too low, and forgets it."""
    begun = stepped(CONVERTER, departure=Departure(past=0.5))
    extra = begun['back_pressure'] - stepped(CONVERTER)['back_pressure']
    since = begun['time']
    expected = -5e3 * 0.5 * np.exp(-since / MEMORY)
    assert extra[50:] == pytest.approx(expected[50:] / (1.0 - 0.034 / MEMORY), abs=2.0)


@pytest.mark.parametrize(('values', 'told'), [(CONVERTER, True), ({}, False)])
def test_a_fit_asks_what_was_of_late_only_where_a_term_remembers(values, told):
    run = stepped(values)
    experiment = Experiment(
        run['time'], run['control_current'], {'chamber_pressure': run['chamber_pressure']},
        {'chamber_pressure': 100.0}, {}, Initial(200e3))
    problem = Problem(experiment, np.ones(len(run['time']), dtype=bool), positioner(values), ())
    z = problem.start()
    slopes = problem.jacobian(z, problem.residuals(z))[:problem.observed, -1]
    assert bool(np.any(slopes)) is told
