# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What of a record a fit is made to meet: rows, or statistics of windows where a stem slips."""

from dataclasses import replace

from made_task import P, TIME, problem_of, seen, z_of
import numpy as np
import pytest

from booster_ros.diagnosis.data.experiment import Chance
from booster_ros.diagnosis.estimation.observation import ROWS, WINDOWS
from booster_ros.diagnosis.hypotheses.compose import with_effects
from booster_ros.signals.window_statistics import Windows

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


def drawn(chance, time, seed):
    """Return noise of variance 1, of which a share is that of a first-order process."""
    rng = np.random.default_rng(seed)
    carried = np.exp(-np.diff(time) / chance.seconds)
    kicks = rng.standard_normal(len(time))
    slow = np.empty(len(time))
    slow[0] = kicks[0]
    for k, share in enumerate(carried, start=1):
        slow[k] = share * slow[k - 1] + np.sqrt(1.0 - share**2) * kicks[k]
    return (np.sqrt(chance.share) * slow
            + np.sqrt(1.0 - chance.share) * rng.standard_normal(len(time)))


def test_noise_that_carries_over_counts_as_white():
    chance = Chance(0.8, 2.0)
    time = np.delete(0.05 * np.arange(900), np.s_[300:420])  # with a gap
    windows = Windows.of(time, np.zeros(len(time)), *chance)
    found = np.array([ROWS.of(windows, drawn(chance, time, seed)) for seed in range(40)])
    assert np.mean(found**2) == pytest.approx(1.0, abs=0.03)
    for lag in (1, 10, 60):
        assert abs(np.mean(found[:, lag:] * found[:, :-lag])) < 0.03
    # what stands for long costs little, what comes and goes as much as beside white noise alone
    stands, comes = np.zeros((2, len(time)))
    stands[100:200], comes[100:200:2] = 1.0, 1.0
    assert np.sum(ROWS.of(windows, stands)**2) < 0.3 * np.sum(stands**2)
    quick = np.sum((ROWS.of(windows, comes) - ROWS.of(windows, 0.5 * stands))**2)
    assert quick == pytest.approx(np.sum((comes - 0.5 * stands)**2) / (1.0 - chance.share), rel=0.1)


def test_means_of_windows_know_what_their_rows_share():
    chance = Chance(0.8, 1e3)
    time = 0.05 * np.arange(200)
    windows = Windows.of(time, np.zeros(len(time)), *chance)
    means = [windows.means(drawn(chance, time, seed)) for seed in range(200)]
    assert np.std(means) == pytest.approx(1.0, abs=0.05)
