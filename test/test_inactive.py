# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters that move nothing where they are given, but where they ought to be."""

from made_task import P, everywhere, steps_seen
import numpy as np
import pytest

from booster_ros.diagnosis.estimation import fit as fit_module
from booster_ros.diagnosis.estimation.fit import FIRST_STEPS, fit as best_fit
from booster_ros.diagnosis.estimation.inactive import place_beyond
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.diagnosis.estimation.parametrisation import declared_freedom
from booster_ros.diagnosis.hypotheses.applicable import matters
from booster_ros.diagnosis.hypotheses.compose import with_effect
from booster_ros.model.catalogue import EFFECTS

LEVELS = np.array(
    [3.8, 4.55, 4.2, 4.4, 3.65, 4.0, 3.7, 4.1, 4.5, 3.75, 3.9, 4.65, 4.2, 3.8, 4.0, 4.3])
START = 101.93e3
ROOM = (np.array([-3.0, -3.0]), np.array([3.0, 3.0]))


def made(largest_opening, effect=None):
    """Return the problem of a valve with this largest opening (m2), and the opening's place."""
    experiment = steps_seen(
        P._replace(booster=P.booster._replace(max_area=largest_opening)), LEVELS, START, seed=4)
    freedoms = tuple(free for free in declared_freedom(P, experiment)
                     if matters(free.knob.parameter, experiment))
    problem = Problem(experiment, everywhere(experiment), P, freedoms)
    names = [free.knob.parameter for free in problem.freedoms]
    problem = with_effect(problem, EFFECTS[effect]) if effect else problem
    return problem, names.index('booster.max_area')


@pytest.mark.parametrize('evaluations', [10, 20])
@pytest.mark.parametrize('begun', [0.0, 0.3])
def test_a_smaller_largest_opening_is_found_though_the_given_one_is_never_reached(
        evaluations, begun):
    smaller = 0.88 * P.booster.max_area
    problem, opening = made(smaller)
    beside = problem.start()
    rows = problem.observed
    for step in (-0.1, begun):
        beside[opening] = step
        assert np.array_equal(problem.residuals(beside)[:rows],
                              problem.residuals(problem.start())[:rows])
    fit = best_fit(problem, [beside], evaluations)
    assert fit.parameters.booster.max_area == pytest.approx(smaller, rel=0.02)
    assert fit.cost < 1.05 * rows


def test_a_largest_opening_that_no_record_speaks_against_stays_as_it_is_given():
    problem, opening = made(1.1 * P.booster.max_area)
    fit = best_fit(problem)
    assert abs(fit.z[opening]) < 0.05
    assert np.linalg.norm(fit.jacobian[:problem.observed, opening]) < 1e-6


def test_only_declared_parameters_that_move_nothing_are_moved_and_not_in_first_steps(monkeypatch):
    """A ripple of no size has a frequency and a phase that move nothing either."""
    asked = []
    monkeypatch.setattr(fit_module, 'place_beyond', lambda *args: asked.append(args[3]))
    problem, opening = made(P.booster.max_area, 'supply_ripple')
    best_fit(problem, [problem.start()], FIRST_STEPS)
    assert asked == []
    best_fit(problem, evaluations=10)
    assert asked == [{opening: 1.0}]


def test_the_better_of_two_ends_is_taken(monkeypatch):
    problem, _ = made(P.booster.max_area)
    alone = best_fit(problem, evaluations=10)
    far = problem.bounds()[1]
    far[len(problem.freedoms):] = 0.0
    monkeypatch.setattr(fit_module, 'place_beyond', lambda *_: far)
    assert best_fit(problem, evaluations=10).cost == alone.cost
    assert best_fit(problem, [far], 10).cost > alone.cost


RISE = np.linspace(0.0, 1.0, 100)
COLUMNS = np.vstack([np.column_stack([50.0 * RISE, 0.0 * RISE]), np.eye(2)])
"""Slopes at z = 0 of the residuals below, those of the second variable its prior's alone."""


def missed(true, from_here):
    """Return residuals of z: the second variable moves them beyond `from_here` alone."""
    side = np.sign(from_here)

    def residuals(z):
        moved, ought = (max(side * (place - from_here), 0.0) for place in (z[1], true))
        return np.concatenate([100.0 * RISE**2 * (moved - ought) + 50.0 * RISE * (z[0] - 0.7), z])

    return residuals


@pytest.mark.parametrize(
    ('true', 'from_here'), [(-2.0, -1.0), (-1.0, -0.5), (1.0, 0.5), (2.0, 1.0)])
def test_a_descent_may_begin_where_the_other_parameters_make_up_for_more(true, from_here):
    begin = place_beyond(missed(true, from_here), np.zeros(2), COLUMNS, {1: 1.0}, ROOM)
    assert begin == pytest.approx([0.7, true], abs=0.01)


def test_steps_are_as_wide_as_priors_and_end_at_bounds():
    residuals, z = missed(-4.0, -3.0), np.zeros(2)
    assert place_beyond(residuals, z, COLUMNS, {1: 1.0}, ROOM) is None
    room = (np.full(2, -5.0), np.full(2, 0.3))
    assert place_beyond(residuals, z, COLUMNS, {1: 2.0}, room) == pytest.approx([0.3, -4.0])


@pytest.mark.parametrize(('true', 'lowest'), [(0.0, -3.0), (-2.0, 0.0), (-1.02, -3.0)])
def test_none_begins_for_nothing_or_beyond_a_bound_or_for_what_may_be_chance(true, lowest):
    room = (np.full(2, lowest), np.full(2, 3.0))
    residuals = missed(true, -1.0)
    assert place_beyond(residuals, np.zeros(2), COLUMNS, {1: 1.0}, room) is None


def test_chance_is_more_where_more_than_noise_is_missed():
    def with_waves(z):
        waves = np.tile([20.0, -20.0], 50)
        return missed(-2.0, -1.95)(z) + np.concatenate([waves, np.zeros(2)])

    alone = place_beyond(missed(-2.0, -1.95), np.zeros(2), COLUMNS, {1: 1.0}, ROOM)
    assert alone is not None
    assert place_beyond(with_waves, np.zeros(2), COLUMNS, {1: 1.0}, ROOM) is None


def test_none_begins_for_what_another_parameter_can_do_as_well():
    def alike(z):
        return np.concatenate([50.0 * RISE * (z[0] + min(z[1] + 1.0, 0.0) + 1.0), z])

    assert place_beyond(alike, np.zeros(2), COLUMNS, {1: 1.0}, ROOM) is None
