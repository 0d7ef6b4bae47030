# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The score of a model that was lost on the way, and how it compares with others."""

from dataclasses import replace

from made_search import P, searching, seen
import numpy as np
import pytest

from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.diagnosis.searching.candidate import (
    clearly_better, clears, gain, shows_faintly, told_apart)


def test_a_model_that_is_lost_on_the_way_is_told_from_one_that_is_not_and_not_from_another():
    found = replace(searching(seen(P), ()).refit(), by_segment=np.full(6, 100.0), prior=0.0)
    lost = replace(found, by_segment=np.array([100.0, 100.0, np.inf, 100.0, 100.0, 100.0]))
    assert gain(lost, found) == (np.inf, 0.0)
    assert gain(found, lost) == (-np.inf, 0.0)
    assert clearly_better(found, lost)
    assert not clearly_better(lost, found)
    assert not clearly_better(lost, lost)
    assert gain(lost, lost) == (0.0, 0.0)
    assert told_apart(lost, found)
    assert not told_apart(found, lost)
    assert not told_apart(lost, lost)


@pytest.mark.parametrize(('cost', 'falls', 'shows'), [
    (20.0, [3.0] * 6, True),
    (15.0, [3.0] * 6, False),
    (20.0, [1.0] * 6, False),
    (20.0, [30.0, 0.0, 0.0, 0.0, 0.0, 0.0], False),
    (20.0, [50.0, 0.0, 0.0, 0.0, 0.0, 0.0], True),
    (20.0, [90.0, -60.0, 0.0, 0.0, 0.0, 0.0], False),
    (20.0, [-50.0, 0.0, 0.0, 0.0, 0.0, 0.0], False),
])
def test_what_matters_little_shows_where_cost_and_score_fall_beyond_chance(cost, falls, shows):
    """In all segments alike, or in one by so much that its standard error is no measure."""
    found = replace(searching(seen(P), ()).refit(), by_segment=np.full(6, 100.0), prior=0.0)
    better = replace(found, by_segment=found.by_segment - falls,
                     fit=replace(found.fit, cost=found.fit.cost - cost))
    assert shows_faintly(better, found) == shows


@pytest.mark.parametrize(('before', 'after', 'cleared'), [
    (1.5, 1.1, True), (1.5, 1.2, False), (0.98, 0.97, False), (0.98, 0.99, False)])
def test_nothing_is_cleared_where_no_more_than_noise_was_left(before, after, cleared):
    refit = replace(searching(seen(P), ()).refit(), samples=600)
    worse, better = (
        replace(refit, by_segment=np.full(6, 100.0 * left)) for left in (before, after))
    assert clears(better, worse) == cleared


def test_what_a_fit_leaves_is_counted_for_each_row_it_was_fitted_to():
    search = searching(seen(P), ())
    refit = search.refit()
    both = search.on_both(refit, search.thinning)
    assert both.fit.cost > 1.3 * refit.fit.cost
    assert both.fitted_misfit == pytest.approx(refit.fitted_misfit, rel=0.1)


@pytest.mark.parametrize('reached', [None, 0, 700])
def test_a_model_that_cannot_run_scores_infinitely_however_far_it_came(reached):
    search = searching(seen(P), ())
    problem = search.problem()

    class Lost(Problem):
        def predict(self, z):
            if reached is None:
                return None
            late = np.arange(len(self.experiment.time)) >= reached
            return {name: np.where(late, np.nan, values)
                    for name, values in super().predict(z).items()}

    lost = Lost(problem.experiment, problem.rows, problem.base, problem.freedoms)
    assert search.rate((), lost, problem.at(problem.start())).score == np.inf
