# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where chamber, stem and converter are taken to be in the first row."""

from made_diagnosis import DECLARED
from made_record import ROWS, TIME, record_of, step_test
import numpy as np
import pytest

from booster_ros.diagnosis.estimation.fit import fit
from booster_ros.diagnosis.estimation.parametrisation import put
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.diagnosis.hypotheses.compose import with_effects
from booster_ros.diagnosis.prepare.preparation import prepare
from booster_ros.model.ep_converter import settled_back_pressure
from booster_ros.model.memory import Departure
from booster_ros.model.simulation import simulate


def test_a_resting_start_is_averaged_and_a_moving_one_is_taken_as_it_is():
    columns = step_test()
    still = prepare(record_of(**columns), DECLARED).initial
    assert still.chamber_pressure == pytest.approx(np.mean(columns['chamber_pressure'][:5]))
    assert still.valve_position == pytest.approx(np.mean(columns['valve_position'][:5]))
    columns['chamber_pressure'] = columns['chamber_pressure'] - 400.0 * np.arange(ROWS)[::-1]
    moving = prepare(record_of(**columns), DECLARED).initial
    assert moving.chamber_pressure == columns['chamber_pressure'][0]


def test_without_a_pressure_the_spring_tells_where_the_chamber_starts():
    columns = step_test()
    measured = columns.pop('chamber_pressure')
    start = prepare(record_of(**columns), DECLARED).initial
    assert start.chamber_pressure == pytest.approx(np.mean(measured[:5]), abs=500.0)


@pytest.mark.parametrize(('position', 'current', 'low', 'high'), [
    (0.0, 0.30e-3, 0.0, 150e3),  # vented against the lower stop
    (0.016, 0.48e-3, 300e3, 400e3),  # filled against the upper stop
])
def test_at_a_stop_the_booster_tells_where_the_chamber_starts(position, current, low, high):
    record = record_of(
        time=TIME['time'], control_current=np.full(ROWS, current),
        valve_position=np.full(ROWS, position) + 1e-6 * np.sin(np.arange(ROWS)))
    assert low <= prepare(record, DECLARED).initial.chamber_pressure <= high


def test_a_back_pressure_that_begins_later_does_not_tell_where_the_chamber_starts():
    columns = step_test()
    del columns['chamber_pressure']
    columns['valve_position'][:] = 0.0
    columns['back_pressure'] = np.full(ROWS, 200e3)
    columns['back_pressure'][::2] = np.nan
    experiment = prepare(record_of(**columns), DECLARED)
    assert np.isfinite(experiment.initial.chamber_pressure)
    assert np.isfinite(experiment.predict(DECLARED)['back_pressure']).all()


def test_a_record_that_begins_with_its_first_command_starts_with_the_converter_where_it_was():
    time = 0.01 * np.arange(2000)
    current = np.where(time < 10.0, 0.43e-3, 0.45e-3)
    before = np.concatenate(([0.35e-3], current[:-1]))
    run = simulate(DECLARED, time, before, {'chamber_pressure': 50e3})
    experiment = prepare(record_of(
        time=time[1:], control_current=current[1:], chamber_pressure=run['chamber_pressure'][1:],
        valve_position=run['valve_position'][1:]), DECLARED)
    at_first = run['back_pressure'][1] - run['back_pressure'][900]
    assert experiment.initial.departure.back_pressure == pytest.approx(at_first, abs=2e3)
    assert any('had not settled at the first command' in note for note in experiment.notes)
    assert prepare(record_of(**step_test()), DECLARED).initial.departure.back_pressure == 0.0


def test_so_it_does_where_the_model_lacks_too_much_to_meet_its_first_seconds():
    time = 0.01 * np.arange(2000)
    current = np.where(time < 10.0, 0.43e-3, 0.45e-3)
    settled = settled_back_pressure(
        DECLARED.ep_converter, 0.43e-3, DECLARED.supply.pressure, 0.0, 0.0)
    throttled = put(DECLARED, 'tubing.restriction_area', 5e-7)
    run = simulate(throttled, time, current, {'chamber_pressure': 0.0},
                   departure=Departure(-settled))
    experiment = prepare(record_of(
        time=time, control_current=current, chamber_pressure=run['chamber_pressure'],
        valve_position=run['valve_position']), DECLARED)
    assert experiment.initial.unsettled
    assert experiment.initial.departure.back_pressure == pytest.approx(-settled, abs=10e3)
    rows = np.ones(len(experiment.time), dtype=bool)
    problem = with_effects(Problem(experiment, rows, DECLARED, ()), ('tubing_restriction',))
    assert fit(problem).parameters.tubing.restriction_area == pytest.approx(5e-7, rel=0.01)
    assert not prepare(record_of(**step_test()), DECLARED).initial.unsettled


def test_a_vented_valve_says_nothing_of_where_its_converter_starts():
    time = 0.01 * np.arange(1000)
    current = np.where(time < 5.0, 0.0, 0.43e-3)
    run = simulate(DECLARED, time, current)
    experiment = prepare(record_of(
        time=time, control_current=current, chamber_pressure=run['chamber_pressure']), DECLARED)
    assert experiment.initial.departure.back_pressure == 0.0
    assert not any('had not settled' in note for note in experiment.notes)
