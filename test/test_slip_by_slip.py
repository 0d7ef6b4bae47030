# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a record shows of friction by itself, and fits that keep step with a stem that slips."""

from dataclasses import replace

from made_search import P, RAMPS, RAMPS_TIME, searching, seen, standing_at
import numpy as np
import pytest

from booster_ros.diagnosis.data.blocks import USED
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.diagnosis.fitting.in_step import OUT_OF_STEP, Steps, cost_in_step, steps
from booster_ros.diagnosis.fitting.one_by_one import more_in_step
from booster_ros.diagnosis.fitting.sawtooth import read_saw, rows_going
from booster_ros.diagnosis.fitting.slip_by_slip import fit_slip_by_slip
from booster_ros.diagnosis.last_fit import last_fit

ROWS = slice(2000)


def rubbing(sliding, stiction, rows=ROWS, **others):
    """Return the search for friction in a record of a valve with this friction."""
    plant = P._replace(actuator=P.actuator._replace(
        coulomb_friction=sliding, stiction=stiction, **others))
    return searching(seen(plant, current=RAMPS[rows], time=RAMPS_TIME[rows]), ('stem_friction',))


def problem_of(search):
    """Return the fit of friction to all rows but the locked ones."""
    return search.on(search.joint(search.problem(), ('stem_friction',)), USED, 1)


def standing_with(search, sliding, stiction, others=None):
    """Return the candidate that has this friction on a packing that does not yield."""
    return standing_at(search, ('stem_friction',), {
        'actuator.coulomb_friction': sliding, 'actuator.stiction': stiction,
        'actuator.presliding_stiffness': 0.0, **(others or {})})


@pytest.mark.parametrize(('sliding', 'stiction'), [(300.0, 100.0), (200.0, 60.0), (500.0, 200.0)])
def test_a_stem_that_slips_shows_where_it_breaks_away(sliding, stiction):
    problem = problem_of(rubbing(sliding, stiction, slice(None)))
    saw = read_saw(problem, problem.start())
    assert saw.high == pytest.approx(sliding + stiction, rel=0.03)
    assert 0.8 * sliding < saw.low < 1.03 * sliding


def test_a_stem_that_slides_shows_its_friction():
    problem = problem_of(rubbing(150.0, 0.0, slice(None)))
    saw = read_saw(problem, problem.start())
    assert saw.low == pytest.approx(150.0, rel=0.06)
    assert saw.high == pytest.approx(150.0, rel=0.06)


def test_a_shifted_spring_is_not_held_for_friction():
    """It is pushed one way as much more as it is pushed less the other way."""
    problem = problem_of(rubbing(300.0, 100.0, slice(None), bench_set_shift=2e3))
    assert read_saw(problem, problem.start()).high == pytest.approx(400.0, rel=0.04)


@pytest.mark.parametrize('without', ['chamber_pressure', 'valve_position', 'motion'])
def test_nothing_is_read_where_pressure_or_motion_is_not_seen(without):
    problem = problem_of(rubbing(300.0, 100.0))
    experiment = problem.experiment
    measured = dict(experiment.measured)
    if without == 'motion':
        measured['valve_position'] = np.full(len(experiment.time), 5e-3)
    else:
        del measured[without]
    blind = replace(problem, experiment=replace(experiment, measured=measured))
    assert read_saw(blind, blind.start()) is None
    assert not rows_going(blind, blind.start()).any()
    assert fit_slip_by_slip(blind, blind.start()) is None


def test_a_gap_in_a_channel_is_no_motion():
    problem = problem_of(rubbing(300.0, 100.0))
    before = read_saw(problem, problem.start())
    for values in problem.experiment.measured.values():
        values[300:400] = np.nan
    assert read_saw(problem, problem.start()).high == pytest.approx(before.high, rel=0.03)


def test_the_part_of_a_problem_up_to_a_time_is_its_first_rows():
    problem = problem_of(rubbing(300.0, 100.0))
    part = problem.until(10.0)
    assert part.experiment.time[-1] == pytest.approx(10.0)
    assert len(part.rows) == len(part.experiment.time) == len(part.experiment.current)
    z = problem.start()
    rows = part.counted['valve_position']
    whole, first = (one.predict(z)['valve_position'][:len(rows)] for one in (problem, part))
    assert np.array_equal(first[rows], whole[rows])
    assert len(problem.until(-1.0).experiment.time) == 2


def test_friction_is_found_where_a_fit_of_the_whole_gets_stuck():
    """From declared parameters that are a little off."""
    search = rubbing(300.0, 100.0)
    problem = problem_of(search)
    z = standing_at(search, ('stem_friction',), {'ep_converter.offset': 100.0}).fit.z
    fit = fit_slip_by_slip(problem, z)
    found = fit.parameters.actuator
    assert found.coulomb_friction == pytest.approx(300.0, rel=0.01)
    assert found.stiction == pytest.approx(100.0, rel=0.05)
    assert problem.mean_square(fit) < 1.05
    stuck = problem.fit_through_slips(z, 10)
    assert problem.mean_square(stuck) > 2.3


def test_what_the_model_misses_for_a_while_does_not_hide_which_friction_is_right():
    """The pressure is read 1.5 kPa too high for two seconds, while the stem goes."""
    search = rubbing(300.0, 100.0)
    problem = problem_of(search)
    right = standing_with(search, 300.0, 100.0).fit.z
    others = [standing_with(search, sliding, stiction).fit.z for sliding, stiction in (
        (294.0, 100.0), (306.0, 100.0), (300.0, 85.0), (300.0, 115.0))]
    going = rows_going(problem, right)
    problem.experiment.measured['chamber_pressure'][500:600] += 1.5e3
    assert going[500:600].any()
    assert 0.0 < steps(problem, right).missed(going) < 0.1
    left = cost_in_step(problem, right)
    assert problem.cost(right) > 3.0 * left
    for other in others:
        assert cost_in_step(problem, other) > 1.1 * left


def test_a_window_out_of_step_counts_no_more_than_a_fixed_cost():
    search = rubbing(300.0, 100.0)
    problem, z = problem_of(search), standing_with(search, 340.0, 20.0).fit.z
    found = steps(problem, z)
    assert 0.7 < found.missed(rows_going(problem, z)) <= 1.0
    assert 0.4 < np.mean(~found.kept) < 0.8  # it rests in step
    most = OUT_OF_STEP * problem.rows_counted()
    assert cost_in_step(problem, z) < min(most, 0.8 * problem.cost(z))


def test_what_is_in_step_counts_in_full():
    search = rubbing(300.0, 100.0)
    problem, z = problem_of(search), standing_with(search, 300.0, 100.0).fit.z
    going = rows_going(problem, z)
    found = steps(problem, z)
    assert found.missed(going) == 0.0
    assert found.kept.all()
    assert cost_in_step(problem, z) == pytest.approx(problem.cost(z), rel=1e-12)


def test_windows_are_counted_kept_and_missed():
    window = np.repeat(np.arange(4), 10)
    found = Steps(window, np.full(4, 20), np.array([1.0, 3.5, 9.0, 5.0]))
    assert found.cost == pytest.approx(20.0 * (1.0 + 3.5 + 2.0 * OUT_OF_STEP))
    assert list(found.kept[::10]) == [True, True, False, False]
    assert found.missed(window > 0) == pytest.approx(2.0 / 3.0)
    assert found.missed(np.zeros(len(window), dtype=bool)) == 1.0  # nothing goes, or is followed


def test_where_no_friction_is_free_no_slip_is_followed(monkeypatch):
    problem = problem_of(rubbing(300.0, 100.0))
    bare = replace(problem, freedoms=problem.freedoms[:2])
    monkeypatch.setattr(Problem, 'residuals', None)
    assert fit_slip_by_slip(bare, bare.start()) is None


def test_the_last_fit_follows_slips_that_the_search_had_missed():
    search = rubbing(300.0, 100.0)
    last = last_fit(search, standing_with(search, 340.0, 20.0, {'actuator.viscous_friction': 4e3}))
    assert last.fit.parameters.actuator.coulomb_friction == pytest.approx(300.0, rel=0.01)
    assert last.problem.mean_square(last.fit) < 1.05
    cost = cost_in_step(last.problem, last.fit.z)
    assert cost == pytest.approx(last.trials.cost.min(), rel=1e-3)


def a_little_off(sliding, stiction, damping):
    """Return the search for friction of a packing that yields, and a candidate near to it."""
    search = rubbing(sliding, stiction, presliding_stiffness=2e7, presliding_damping=damping)
    return search, standing_at(search, ('stem_friction',), {
        'actuator.coulomb_friction': 1.004 * sliding, 'actuator.stiction': 0.988 * stiction,
        'actuator.presliding_stiffness': 2.2e7, 'actuator.presliding_damping': 1.5 * damping})


def left_in_step(problem, z):
    """Return the cost in step of each row that counts."""
    return cost_in_step(problem, z) / problem.rows_counted()


def test_a_packing_that_yields_is_made_to_keep_step():
    search, candidate = a_little_off(400.0, 150.0, 0.5)
    problem = problem_of(search)
    before = left_in_step(problem, candidate.fit.z)
    assert before > 1.1
    after = left_in_step(problem, more_in_step(problem, candidate.fit.z))
    assert after < 1.0 + 0.4 * (before - 1.0)


def test_the_last_fit_of_a_packing_that_yields_keeps_step():
    """Fits through slips end at 1.23, and trials of friction are not as sure of it as slips."""
    last = last_fit(*a_little_off(500.0, 200.0, 0.3))
    assert left_in_step(last.problem, last.fit.z) < 1.1
    sliding = last.fit.parameters.actuator.coulomb_friction
    assert sliding == pytest.approx(500.0, rel=0.01)
    index = [free.knob.parameter for free in last.problem.freedoms].index(
        'actuator.coulomb_friction')
    low, high = map(last.problem.freedoms[index].value, last.trials.ends(index))
    assert low < 500.0 < high
    assert high - low > 0.01 * sliding
