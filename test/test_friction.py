# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Friction that a fit may begin with, wherever an earlier fit had got stuck."""

from made_diagnosis import NOISE
from made_effect import add_effect
import numpy as np
import pytest

from booster_ros.diagnosis.data.experiment import Experiment, Initial
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.diagnosis.fitting.friction_start import best_friction, each_damping
from booster_ros.diagnosis.fitting.friction_trials import Trials, friction_trials
from booster_ros.diagnosis.estimation.uncertainty import interval_of
from booster_ros.diagnosis.hypotheses.compose import with_effect
from booster_ros.model.catalogue import EFFECTS, Knob
from booster_ros.model.parameters import from_values
from booster_ros.model.simulation import simulate
from booster_ros.model.system import PositionerParameters

TIME = np.arange(0.0, 60.0, 0.04)
CURRENT = 0.41e-3 + 0.03e-3 * np.abs((TIME / 12.0) % 2.0 - 1.0) + 0.015e-3 * (TIME % 17.0 > 9.0)


def problem_of(values, effect='stem_friction'):
    """Return the fit of friction alone to a noisy record of a valve with this friction."""
    start = {'chamber_pressure': 250e3}
    run = simulate(from_values(values), TIME, CURRENT, start)
    rng = np.random.default_rng(5)
    measured = {name: run[name] + level * rng.standard_normal(len(TIME))
                for name, level in NOISE.items()}
    initial = Initial(start['chamber_pressure'], valve_position=float(run['valve_position'][0]))
    experiment = Experiment(TIME, CURRENT, measured, NOISE, {}, initial)
    rows = np.ones(len(TIME), dtype=bool)
    return with_effect(Problem(experiment, rows, PositionerParameters(), ()), EFFECTS[effect])


def far_off(problem):
    """Return z of friction that is a fraction of what it was, on a packing that yields."""
    z = problem.start()
    far = {'actuator.coulomb_friction': 120.0, 'actuator.presliding_stiffness': 5e7,
           'actuator.stribeck_velocity': 0.004}
    for j, free in enumerate(problem.freedoms):
        if free.knob.parameter in far:
            z[j] = free.variable(far[free.knob.parameter])
    return z


RIGID = {'actuator.coulomb_friction': 380.0, 'actuator.stiction': 130.0}


@pytest.mark.parametrize('values', [
    RIGID, RIGID | {'actuator.presliding_stiffness': 2e7}, {'actuator.coulomb_friction': 900.0},
], ids=['sticks', 'yields', 'no stiction'])
def test_friction_is_found_from_far_off(values):
    problem = problem_of(values)
    found = problem.parameters(best_friction(problem, far_off(problem))).actuator
    assert found.coulomb_friction == pytest.approx(values['actuator.coulomb_friction'], rel=0.15)
    assert found.stiction == pytest.approx(values.get('actuator.stiction', 0.0), abs=100.0)
    assert found.presliding_stiffness <= 2e7 or 'actuator.presliding_stiffness' in values


def test_what_linear_algebra_rounds_is_no_other_slip():
    """Runs of the same diagnosis end in the same place, whatever else the machine does."""
    problem = problem_of(RIGID)
    z = problem.start() + 0.3
    again = z * (1.0 + 1e-14)
    rows, here = problem.observed, problem.residuals(z)
    assert np.array_equal(problem.residuals(again)[:rows], here[:rows])
    slopes = problem.jacobian(z, here)
    after, before = (problem.jacobian(place, here, scale * slopes)[:rows]
                     for place, scale in ((again, 1.0 + 1e-14), (z, 1.0)))
    assert np.array_equal(after, before)


def test_a_fit_from_there_ends_where_one_from_far_off_does_not_come():
    problem = problem_of(RIGID)
    stuck = problem.fit(far_off(problem), 10)
    found = problem.fit_through_slips(best_friction(problem, stuck.z), 10)
    missed, left = (float(np.sum(problem.means(fit.z)**2)) for fit in (stuck, found))
    assert left < 0.7 * missed
    assert abs(stuck.parameters.actuator.coulomb_friction - 380.0) > 50.0
    assert abs(found.parameters.actuator.coulomb_friction - 380.0) < 20.0


def test_a_new_shape_of_friction_begins_as_it_typically_is(monkeypatch):
    add_effect(monkeypatch, 'dry_packing', 'stem',
               Knob('actuator.coulomb_friction', 300.0, 0.0, 6e3, rubs=True),
               Knob('actuator.flow_force_decay', 0.7, 0.05, 3.0, 0.3, shape=True))
    monkeypatch.setattr(Problem, 'cost_through_slips', lambda self, z: float(np.sum((z - 1.0)**2)))
    problem = problem_of(RIGID, 'dry_packing')
    found = problem.parameters(best_friction(problem, problem.start()))
    assert found.actuator.flow_force_decay == pytest.approx(0.7)


def z_of(problem, values):
    """Return z of this friction, all shapes typical."""
    z = problem.start()
    for j, free in enumerate(problem.freedoms):
        z[j] = free.variable(values.get(free.knob.parameter, free.value(free.without_size)))
    return z


def test_the_damping_of_a_packing_is_found_from_each_but_not_from_much_of_it():
    values = RIGID | {'actuator.presliding_stiffness': 2e7, 'actuator.presliding_damping': 0.3}
    problem = problem_of(values)
    start = z_of(problem, values | {'actuator.presliding_damping': 2.5})
    much = problem.fit_through_slips(start)
    fits = [problem.fit_through_slips(z) for z in each_damping(problem, start)]
    best = min(fits, key=lambda fit: problem.cost_through_slips(fit.z))
    assert much.parameters.actuator.presliding_damping > 2.0
    assert best.parameters.actuator.presliding_damping < 0.6
    assert problem.cost_through_slips(best.z) < 0.8 * problem.cost_through_slips(much.z)


def test_from_a_rigid_packing_a_fit_begins_with_a_soft_one():
    problem = problem_of(RIGID)
    for stiffness, begun in ((0.0, 1e7), (3e7, 3e7)):
        z = z_of(problem, RIGID | {'actuator.presliding_stiffness': stiffness})
        packings = [problem.parameters(start).actuator for start in each_damping(problem, z)]
        assert [one.presliding_stiffness for one in packings] == pytest.approx([begun, begun])
        assert [one.presliding_damping for one in packings] == pytest.approx([0.3, 0.6])
        assert {one.stiction for one in packings} == {problem.parameters(z).actuator.stiction}


def test_shapes_on_which_nothing_depends_end_as_typical():
    problem = problem_of(RIGID)
    given = RIGID | {'actuator.presliding_stiffness': 0.0, 'actuator.presliding_damping': 2.5}
    found = problem.without_unseen(problem.at(z_of(problem, given))).parameters.actuator
    assert (found.presliding_stiffness, found.presliding_damping) == (0.0, 1.0)
    yields = given | {'actuator.presliding_stiffness': 1e7}
    found = problem.without_unseen(problem.at(z_of(problem, yields))).parameters.actuator
    assert (found.presliding_stiffness, found.presliding_damping) == pytest.approx((1e7, 2.5))


def test_trials_find_what_is_better_nearby():
    problem = problem_of(RIGID)
    beside = z_of(problem, RIGID | {'actuator.coulomb_friction': 420.0})
    trials = friction_trials(problem, beside)
    assert trials.z[0] == pytest.approx(beside)
    assert trials.cost[0] == problem.cost_through_slips(beside)
    assert problem.cost_through_slips(trials.best) == trials.cost.min() < 0.3 * trials.cost[0]


def test_trials_around_a_fit_hold_what_was_put_in():
    problem = problem_of(RIGID)
    fit = problem.fit_through_slips(best_friction(problem, far_off(problem)), 10)
    trials = friction_trials(problem, fit.z)
    for j, free in enumerate(problem.freedoms):
        good = [free.value(z) for z in trials.as_good[:, j]]
        if free.knob.parameter in RIGID:
            assert min(good) < RIGID[free.knob.parameter] < max(good)
            assert max(good) - min(good) < 0.75 * RIGID[free.knob.parameter]
        if free.knob.parameter == 'actuator.presliding_stiffness':
            assert set(good) == {0.0}  # a packing that is rigid stays so
        if free.knob.parameter == 'actuator.presliding_damping':
            assert len(set(good)) == 1  # and has none


def test_the_interval_of_a_size_is_all_that_good_trials_show():
    """They crowd around the best: of 41 here, 38 are within a percent of it."""
    problem = problem_of(RIGID)
    names = [free.knob.parameter for free in problem.freedoms]
    k = names.index('actuator.coulomb_friction')
    free, centre = problem.freedoms[k], z_of(problem, RIGID)
    z = np.tile(centre, (41, 1))
    z[:, k] *= np.concatenate([np.linspace(0.995, 1.005, 38), [0.8, 1.3, 3.0]])
    trials = Trials(z, np.array([1.0] * 40 + [9.0]), (k,))
    assert trials.ends(k) == pytest.approx((0.8 * centre[k], 1.3 * centre[k]))
    assert trials.ends(k + 1) is None
    found = interval_of(
        problem, trials.instead_of(z), problem.at(centre), k, trials.ends(k))
    assert (found.low, found.high) == pytest.approx(
        (free.value(0.8 * centre[k]), free.value(1.3 * centre[k])))


def test_draws_have_what_was_varied_from_good_trials_and_the_rest_as_it_was():
    z = np.array([[0.0, 1.0], [0.1, 1.0], [0.2, 1.0], [9.0, 1.0]])
    trials = Trials(z, np.array([1.0, 1.2, 1.1, 8.0]), (0,))
    draws = np.column_stack([np.full(50, 7.0), np.linspace(2.0, 3.0, 50)])
    again = trials.instead_of(draws)
    assert set(again[:, 0]) == {0.0, 0.1, 0.2}
    assert (again[:, 1] == draws[:, 1]).all()


def test_of_friction_along_the_travel_the_gradient_stays():
    problem = problem_of({'actuator.coulomb_friction': 400.0, 'actuator.friction_gradient': 300.0},
                         'position_dependent_friction')
    names = [free.knob.parameter for free in problem.freedoms]
    z = far_off(problem)
    z[names.index('actuator.friction_gradient')] = 0.4
    moved = best_friction(problem, z)
    assert moved[names.index('actuator.friction_gradient')] == 0.4
    assert moved[names.index('actuator.coulomb_friction')] != z[0]


def test_of_a_stem_that_has_galled_the_place_stays():
    problem = problem_of({'actuator.coulomb_friction': 400.0}, 'position_dependent_friction')
    z = z_of(problem, {
        'actuator.coulomb_friction': 900.0, 'actuator.friction_peak': 500.0,
        'actuator.friction_peak_position': 5e-3, 'actuator.friction_peak_width': 1e-3,
        'actuator.presliding_damping': 2.5})
    found = problem.parameters(best_friction(problem, z)).actuator
    assert found.coulomb_friction != pytest.approx(900.0, rel=0.2)
    assert found.friction_peak == pytest.approx(500.0)
    assert found.friction_peak_position == pytest.approx(5e-3)
    assert found.friction_peak_width == pytest.approx(1e-3)
    assert found.presliding_damping == pytest.approx(1.0)


def test_friction_that_fits_better_than_all_that_is_tried_stays():
    values = RIGID | {'actuator.presliding_stiffness': 2e7, 'actuator.presliding_damping': 0.3}
    problem = problem_of(values)
    z = problem.fit_through_slips(z_of(problem, values), 10).z
    assert best_friction(problem, z) is z


def test_where_no_friction_is_free_nothing_is_tried(monkeypatch):
    problem = problem_of(RIGID, 'chamber_leak')
    monkeypatch.setattr(Problem, 'through_slips', None)
    z = problem.start() + 0.1
    assert best_friction(problem, z) is z
