# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Terms without a name: which are tried on a record, and over what range a table is laid."""

from dataclasses import replace

from made_diagnosis import DECLARED, record_of, swept_columns, timed_columns
from made_task import P, RAMPS, RAMPS_TIME, STEPS, TIME, seen, steps_seen, task_of, too_quiet
import numpy as np
import pytest

from booster_ros.diagnosis.data.experiment import Experiment
from booster_ros.diagnosis.estimation.fit import fit, fit_at
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.diagnosis.estimation.parametrisation import declared_freedom
from booster_ros.diagnosis.prepare.preparation import prepare
from booster_ros.model.term_course import followed
from booster_ros.diagnosis.hypotheses.discrepancy import terms, with_term
from booster_ros.diagnosis.selection import terms as best
from booster_ros.diagnosis.selection.neighbours import refitted
from booster_ros.model.discrepancy import (
    BACK_PRESSURE_ERROR, BOOSTER, CHANGE_OF, CURRENT_CHANGE, EP_CONVERTER, EP_CONVERTER_LAG,
    FORCE_PLAY, KNOTS, STEM, TIME as OVER_TIME, VARIABLES, Discrepancy, covered, forgets, remembers)
from booster_ros.model.memory import Departure
from booster_ros.model.simulation import simulate
from booster_ros.model.system import PAST_UNIT

CHANGING = 'stem over valve_position_change'
CREEPING = Discrepancy(EP_CONVERTER, CURRENT_CHANGE, tuple(np.linspace(-1e-4, 1e-4, KNOTS)),
                       tuple(np.linspace(-5e3, 5e3, KNOTS)), memory=4.0)


def table_of(experiment: Experiment, label: str, rows=None, memory: float = 12.0) -> Discrepancy:
    """Return the table that a term is to be fitted with, on these rows."""
    seen_rows = np.ones(len(experiment.time), dtype=bool) if rows is None else rows
    problem = Problem(experiment, seen_rows, P, tuple(declared_freedom(P, experiment)))
    one = next(t for t in terms(experiment.channels)
               if t.label == label and (t.past is None or t.past.typical == memory))
    return with_term(problem, fit_at(problem, problem.start()), one).base.discrepancy


def wider(gaps=()) -> Experiment:
    """Return an experiment in which the stem went twice as far as the declared one would."""
    plant = P._replace(actuator=P.actuator._replace(bench_set=(160e3, 235e3)))
    experiment = seen(plant)
    experiment.measured['valve_position'][list(gaps)] = np.nan
    return experiment


def as_given(task):
    """Return the declared model as it is given, not fitted."""
    problem = task.problem()
    return task.scored((), problem, fit_at(problem, problem.start()))


def free_of(experiment, *starts):
    """Return the declared parameters that may change whose names start like one of these."""
    return tuple(free for free in declared_freedom(P, experiment)
                 if free.knob.parameter.startswith(starts))


def test_a_missing_value_costs_no_range_of_a_change():
    whole, broken = (table_of(wider(gaps), CHANGING) for gaps in ((), (700, *range(1400, 1420))))
    assert covered(broken) == pytest.approx(covered(whole), rel=0.02)
    simulated = wider()
    del simulated.measured['valve_position']
    problem = Problem(simulated, np.ones(len(TIME), dtype=bool), P, ())
    one = next(t for t in terms(wider().channels)
               if t.label == CHANGING and t.past.typical == 12.0)
    narrow = with_term(problem, fit_at(problem, problem.start()), one).base.discrepancy
    assert np.ptp(covered(narrow)) < 0.9 * np.ptp(covered(whole))


def test_a_channel_without_values_where_it_is_fitted_is_simulated():
    columns = timed_columns()
    late = columns['time'] > 0.82 * columns['time'][-1]
    columns['valve_position'][~late] = np.nan
    experiment = prepare(record_of(columns), DECLARED)
    for label in ('stem over valve_position', CHANGING):
        low, high = covered(table_of(experiment, label, experiment.time < 40.0))
        assert np.isfinite([low, high]).all()
        assert high - low > 1e-4


def test_the_table_of_what_stands_still_has_knots_that_rise():
    standing = seen(P, current=np.full(len(TIME), 4.1e-4))
    pressures = standing.measured['chamber_pressure']
    pressures[:] = pressures[0]
    for label in ('ep_converter over control_current', 'chamber over chamber_pressure'):
        assert (np.diff(table_of(standing, label).knots) > 0.0).all()


def test_only_what_follows_a_change_has_a_memory_of_its_own():
    assert table_of(seen(P), CHANGING).memory == 12.0
    assert table_of(seen(P), 'stem over valve_position').memory == Discrepancy().memory


def test_what_remembers_comes_last_and_changes_are_what_forgets():
    for number in range(len(VARIABLES)):
        table = Discrepancy(BOOSTER, number)
        assert forgets(table) is (number in CHANGE_OF)
        assert remembers(table) is (forgets(table) or number == FORCE_PLAY)
        assert (PAST_UNIT[number] > 0.0) is remembers(table)


@pytest.mark.parametrize('swept', [False, True])
def test_rows_of_a_sweep_are_no_time_to_forget_in(swept, monkeypatch):
    experiment = prepare(record_of(swept_columns() if swept else timed_columns()), DECLARED)
    tried_labels = []

    def noted(problem, reference, one):
        tried_labels.append(one.label)
        return np.inf, problem, np.empty(0)  # it reaches nowhere, so that none is fitted

    monkeypatch.setattr(best, 'linear_reach', noted)
    task = task_of(experiment)
    assert best.best_terms(task, as_given(task)) == []
    assert 'stem over valve_position' in tried_labels
    assert any(label.endswith('_change') for label in tried_labels) is not swept
    assert ('ep_converter_lag over back_pressure_error' in tried_labels) is not swept


@pytest.mark.parametrize('measured', [False, True])
def test_what_lies_upstream_of_a_measured_drive_is_no_place(measured, monkeypatch):
    experiment = too_quiet(steps_seen(P, STEPS[:4], 1.7e5, seed=5), share=0.5)
    if measured:
        run = simulate(P, experiment.time, experiment.current, {'chamber_pressure': 1.7e5})
        experiment = replace(experiment, pinned={'back_pressure': run['back_pressure']})
    monkeypatch.setattr(best, 'BEGUN', None)
    monkeypatch.setattr(best, 'FIRST_STEPS', 1)
    task = task_of(experiment)
    problem = task.problem()
    likely = [one for one in terms(experiment.channels)
              if one.location in (STEM, EP_CONVERTER, EP_CONVERTER_LAG)]
    begun = best._begun(problem, fit_at(problem, problem.start()), likely)
    places = {label.split(' over ')[0] for label in begun}
    assert 'stem' in places
    assert ('ep_converter' in places) is not measured
    assert ('ep_converter_lag' in places) is not measured


@pytest.mark.parametrize(('every', 'past'), [(1, 0.0), (1, 0.5), (50, 0.5), (250, 0.0)])
def test_the_change_of_a_current_is_that_of_the_model_also_on_few_rows(every, past):
    """The current stands from one row to the next, and what was may be another at the start."""
    time = TIME[::every]
    current = np.where(time < 5.0, 3.9e-4, 4.3e-4)
    plain = simulate(P, time, current)
    crept = simulate(P._replace(discrepancy=CREEPING), time, current,
                     departure=Departure(past=past))
    change = followed(P._replace(discrepancy=CREEPING), time, crept.columns, past)
    later = np.append(False, np.diff(current) == 0.0) & (time > 0.5)
    slope = CREEPING.values[-1] / CREEPING.knots[-1]
    lag = 1.0 / (1.0 - P.ep_converter.time_constant / CREEPING.memory)
    added = crept['back_pressure'] - plain['back_pressure']
    settled = later & (np.abs(time - 5.0) > 0.5)
    assert added[settled] == pytest.approx(lag * slope * change[settled], abs=2.0)
    assert np.abs(added[settled]).max() > 200.0


@pytest.mark.parametrize('current', [
    RAMPS[1500:3000], 4.15e-4 + 0.35e-4 * np.sin(2.0 * np.pi * RAMPS_TIME[:500] / 5.0)],
    ids=['ramps', 'sine'])
def test_on_a_ramp_the_way_to_go_is_that_of_the_slower_converter(current):
    """Of one that vents eleven times as slowly: it is further behind than the declared one."""
    falling = (*np.linspace(-250e3, -1e-3, 6), *np.linspace(1e-3, 250e3, 6))
    plant = P._replace(discrepancy=Discrepancy(
        EP_CONVERTER_LAG, BACK_PRESSURE_ERROR, falling, (float(np.log(11.0)),) * 6 + (0.0,) * 6))
    time = RAMPS_TIME[:len(current)]
    experiment = seen(plant, None, 2.1e5, current, 3, time)
    free = free_of(experiment, 'ep_converter.')
    problem = Problem(experiment, np.ones(len(time), dtype=bool), P, free)
    refit = fit(problem)
    one = next(t for t in terms(experiment.channels) if t.location == EP_CONVERTER_LAG)
    joint = with_term(problem, refit, one)
    run = simulate(plant, time, current, {'chamber_pressure': 2.1e5})
    behind = followed(plant, time, run.columns)
    low, high = covered(joint.base.discrepancy)
    assert low < behind.min() < behind.max() < high
    found = fit(joint, [joint.start()], 20)
    assert refit.cost > 20.0 * joint.observed
    assert found.cost < 1.1 * joint.observed


def test_a_transmitter_that_has_reached_its_end_is_a_sensor_that_lacks_something(monkeypatch):
    """Beyond its end the pressure is not in the record, but its term has to go there."""
    time, current = RAMPS_TIME[:750], RAMPS[2000:2750]
    experiment = seen(P, None, 2.1e5, current, 4, time)
    run = simulate(P, time, current, {'chamber_pressure': 2.1e5})
    experiment.measured['chamber_pressure'] = np.minimum(run['chamber_pressure'], 235e3) + (
        150.0 * np.random.default_rng(3).standard_normal(len(time)))
    task = task_of(experiment, freedoms=free_of(experiment, 'ep_converter.', 'actuator.bench_set'))
    root = refitted(task)
    label = 'pressure_sensor over chamber_pressure'
    monkeypatch.setattr(best, 'terms', lambda *valve: [
        one for one in terms(*valve) if one.label == label])
    (found,) = best.best_terms(task, root)
    assert found.effects == ('unknown: ' + label,)
    assert found.reduced_chi2 < 1.5 < 0.1 * root.reduced_chi2
    assert covered(found.fit.parameters.discrepancy)[1] > 245e3


@pytest.mark.campaign
def test_a_stem_that_shifts_in_the_course_of_time_lacks_something_in_the_stem():
    """A shift of the reading explains the position as well, but not the air that the stem moves."""
    wave = 200.0 * np.sin(np.linspace(0.0, 9.0, KNOTS))
    plant = P._replace(discrepancy=Discrepancy(
        STEM, OVER_TIME, tuple(np.linspace(-5.0, 125.0, KNOTS)), tuple(wave)))
    task = task_of(seen(plant, None, 1.7e5, RAMPS[::2], 4, RAMPS_TIME[::2]))
    root = refitted(task)
    found = best.best_terms(task, root)
    nearest = min(found, key=lambda one: one.reduced_chi2)
    assert nearest.effects == ('unknown: stem over time',)
    assert nearest.reduced_chi2 < 1.5 < 0.1 * root.reduced_chi2


def test_a_table_ends_where_the_rows_end_that_it_was_fitted_to():
    experiment = prepare(record_of(timed_columns()), DECLARED)
    rows = experiment.time < 0.6 * experiment.time[-1]
    free = tuple(declared_freedom(DECLARED, experiment))
    problem = Problem(experiment, rows, DECLARED, free)
    over_time = next(one for one in terms(experiment.channels) if one.variable == OVER_TIME)
    joint = with_term(problem, fit_at(problem, problem.start()), over_time)
    table = joint.base.discrepancy
    spacing = table.knots[-1] - table.knots[-2]
    assert table.knots[-1] <= experiment.time[rows][-1] + spacing
    assert table.knots[0] <= experiment.time[0]


def test_a_table_covers_what_was_measured_and_not_where_a_model_without_it_stays():
    """Beyond its range it is zero, and what follows would suffer."""
    columns = timed_columns()
    columns['valve_position'] *= 1.5
    experiment = prepare(record_of(columns), DECLARED)
    measured = experiment.measured['valve_position']
    rows = np.ones(len(measured), dtype=bool)
    free = tuple(declared_freedom(DECLARED, experiment))
    problem = Problem(experiment, rows, DECLARED, free)
    over_travel = next(one for one in terms(experiment.channels)
                       if one.label == 'chamber over valve_position')
    joint = with_term(problem, fit_at(problem, problem.start()), over_travel)
    table = joint.base.discrepancy
    spacing = np.diff(table.knots)
    assert spacing == pytest.approx(spacing[0])
    assert covered(table) == pytest.approx(
        (measured.min(), measured.max()), abs=0.5 * spacing[0])
