# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What of a record a fit is made to meet: rows, or statistics of windows where a stem slips."""

from dataclasses import replace

from made_task import P, TIME, problem_of, seen, z_of
import numpy as np
import pytest

from booster_ros.diagnosis.estimation.observation import ROWS, WINDOWS
from booster_ros.diagnosis.estimation.observation import Windows
from booster_ros.diagnosis.hypotheses.compose import with_effects

FRICTION = {'actuator.coulomb_friction': 380.0, 'actuator.stiction': 130.0,
            'actuator.presliding_stiffness': 0.0}


def windows_of(rows):
    """Return the windows of so many rows, fifty a second."""
    return Windows.of(0.02 * np.arange(rows), np.random.default_rng(1).standard_normal(rows))


def test_rows_are_what_is_left_of_each():
    windows = windows_of(150)
    scaled = np.arange(150.0)
    found = ROWS.of(windows, scaled)
    assert np.array_equal(found, scaled)
    (rows,) = ROWS.first_rows(windows)
    assert np.array_equal(rows, np.arange(150))


def test_windows_are_a_mean_and_a_strength_of_each():
    windows = windows_of(150)
    found = WINDOWS.of(windows, np.full(150, 2.0))
    assert found[:3] == pytest.approx(2.0 * np.sqrt(50.0))  # in standard deviations of a mean
    assert len(found) == 6
    means, strengths = WINDOWS.first_rows(windows)
    assert np.array_equal(means, [0, 50, 100])
    assert np.array_equal(strengths, [0, 50, 100])


def test_a_window_too_short_for_a_strength_has_no_residual_of_one():
    windows = windows_of(105)  # five rows in the last
    found = WINDOWS.of(windows, np.zeros(105))
    assert len(found) == 3 + 2
    assert [len(series) for series in WINDOWS.first_rows(windows)] == [3, 2]


@pytest.fixture(scope='module')
def slipping():
    """Return the problem of a stem that slips, friction alone free."""
    plant = P._replace(actuator=P.actuator._replace(coulomb_friction=380.0, stiction=130.0))
    return problem_of(seen(plant), 'stem_friction', freedoms=())


def test_a_model_that_rubs_is_observed_by_windows_unless_no_clock_runs(slipping):
    assert slipping.observation is WINDOWS
    assert problem_of(slipping.experiment, 'chamber_leak').observation is ROWS
    assert with_effects(slipping, ('chamber_leak',)).observation is ROWS
    assert with_effects(slipping, ('chamber_leak', 'stem_friction')).observation is WINDOWS
    declared = replace(slipping, base=P._replace(
        actuator=P.actuator._replace(coulomb_friction=100.0)))
    assert with_effects(declared, ()).observation is WINDOWS


def test_residuals_say_from_which_rows_they_are(slipping):
    for observation in (ROWS, WINDOWS):
        problem = replace(slipping, observation=observation)
        assert problem.observed == sum(len(rows) for rows in problem.first_rows)
        assert len(problem.residuals(problem.start())) == problem.observed + problem.nuisances
    assert problem.first_rows[0][:3] == pytest.approx([0, 50, 100])
    later = replace(problem, rows=TIME >= 10.0)
    assert min(map(min, later.first_rows)) == 500


def test_statistics_of_windows_lead_to_the_friction_that_there_is(slipping):
    """Single slips come at other moments for any other friction; what windows hold tells it."""
    forces = 380.0 + np.arange(-150.0, 151.0, 30.0)
    costs = [slipping.cost(z_of(slipping, FRICTION | {'actuator.coulomb_friction': force}))
             for force in forces]
    assert abs(forces[int(np.argmin(costs))] - 380.0) <= 30.0
    assert min(costs[0], costs[-1]) > 3.0 * min(costs)
