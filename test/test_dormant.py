# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters that move nothing where they are given, but where they ought to be."""

from made_search import P, everywhere, steps_seen
import numpy as np
import pytest

from booster_ros.diagnosis.fitting.dormant import place_beyond
from booster_ros.diagnosis.fitting.fit import Problem
from booster_ros.diagnosis.fitting.freedom import declared_freedom

LEVELS = np.array(
    [3.8, 4.55, 4.2, 4.4, 3.65, 4.0, 3.7, 4.1, 4.5, 3.75, 3.9, 4.65, 4.2, 3.8, 4.0, 4.3])
START = 101.93e3
ROOM = (np.array([-3.0, -3.0]), np.array([3.0, 3.0]))


def fitted_to(largest_opening):
    """Return the fit to a valve with this largest opening (m2), and where the opening stands."""
    experiment = steps_seen(
        P._replace(booster=P.booster._replace(max_area=largest_opening)), LEVELS, START, seed=4)
    freedoms = tuple(declared_freedom(P, experiment))
    problem = Problem(experiment, everywhere(experiment), P, freedoms)
    return problem, problem.fit(), [free.knob.parameter for free in freedoms].index(
        'booster.max_area')


def test_a_smaller_largest_opening_is_found_though_the_given_one_is_never_reached():
    smaller = 0.88 * P.booster.max_area
    problem, fit, opening = fitted_to(smaller)
    beside = problem.start()
    rows = problem.rows_counted()
    for step in (-0.1, 0.1):
        beside[opening] = step
        assert np.array_equal(problem.residuals(beside)[:rows],
                              problem.residuals(problem.start())[:rows])
    assert fit.parameters.booster.max_area == pytest.approx(smaller, rel=0.02)
    assert fit.cost < 1.05 * rows


def test_a_largest_opening_that_no_record_speaks_against_stays_as_it_is_given():
    problem, fit, opening = fitted_to(1.1 * P.booster.max_area)
    assert abs(fit.z[opening]) < 0.05
    assert np.linalg.norm(fit.jacobian[:problem.rows_counted(), opening]) == 0.0


def missed(true):
    """Return what makes residuals of z: its second variable moves them from -1 down alone."""
    rows = np.linspace(0.0, 1.0, 100)
    return lambda z: np.concatenate(
        [100.0 * rows**2 * (min(z[1] + 1.0, 0.0) - true - 1.0) + 50.0 * rows * z[0], z])


def columns():
    """Return the columns of these residuals at z = 0, the second that of its prior alone."""
    rows = np.linspace(0.0, 1.0, 100)
    return np.vstack([np.column_stack([50.0 * rows, 0.0 * rows]), np.eye(2)])


def test_a_descent_may_begin_where_the_other_parameters_make_up_for_more():
    begin = place_beyond(missed(-2.0), np.zeros(2), columns(), [1], ROOM)
    assert begin[1] == -2.0
    assert begin[0] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(('true', 'lowest'), [(1.0, -3.0), (-2.0, 0.0), (-1.02, -3.0)])
def test_none_begins_uphill_or_beyond_a_bound_or_for_what_may_be_chance(true, lowest):
    room = (np.full(2, lowest), np.full(2, 3.0))
    assert place_beyond(missed(true), np.zeros(2), columns(), [1], room) is None


def test_none_begins_for_what_another_parameter_can_do_as_well():
    def alike(z):
        rows = np.linspace(0.0, 1.0, 100)
        return np.concatenate([50.0 * rows * (z[0] + min(z[1] + 1.0, 0.0) + 1.0), z])

    assert place_beyond(alike, np.zeros(2), columns(), [1], ROOM) is None
