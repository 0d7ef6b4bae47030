# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Stepwise selection: one comparison, by whichever observation either model needs."""

from dataclasses import replace

from made_task import P, steps_seen, task_of
import numpy as np
import pytest

from booster_ros.diagnosis.estimation.fit import fit_at
from booster_ros.diagnosis.estimation.observation import ROWS, WINDOWS
from booster_ros.diagnosis.estimation.parametrisation import put
from booster_ros.diagnosis.selection.neighbours import neighbours, refitted
from booster_ros.diagnosis.selection.stepwise import (
    _best, _Trace, _upstream_first, comparison, leaves_noise, select)
from booster_ros.diagnosis.selection.task import explained
from booster_ros.model.discrepancy import KNOTS, STEM, VALVE_POSITION, Discrepancy

LEVELS = np.array([3.8, 4.3, 4.0, 4.4, 3.9, 4.2])


def recorded(plant=P, seed=3):
    """Return the experiment of 30 s of steps of a valve."""
    return steps_seen(plant, LEVELS, 1.7e5, seed)


def nothing_said(phrase, share):
    pass


def as_given(task, *effects):
    """Return the model with these effects as they are given, not fitted."""
    problem = task.problem(effects)
    return task.scored(effects, problem, fit_at(problem, problem.start()))


@pytest.fixture(scope='module')
def models():
    """Return a task, its declared model, one with a leak, and one with friction, as given."""
    task = task_of(recorded(), ('chamber_leak', 'stem_friction'), ())
    return task, as_given(task), as_given(task, 'chamber_leak'), as_given(task, 'stem_friction')


def test_models_are_compared_by_windows_where_either_needs_them(models):
    task, root, leak, friction = models
    assert (root.problem.observation, friction.problem.observation) == (ROWS, WINDOWS)
    for one, other in ((friction, root), (root, friction)):
        found = comparison(task, one, other, [])
        windows = task.observed_as(root, friction)
        sign = 1.0 if one is friction else -1.0
        assert found.log_evidence == pytest.approx(sign * (
            friction.score.log_evidence(found.dispersion)
            - windows.score.log_evidence(found.dispersion)))
    rows = comparison(task, leak, root, [])
    assert rows.log_evidence == pytest.approx(
        leak.score.log_evidence(rows.dispersion) - root.score.log_evidence(rows.dispersion))


def test_it_is_the_best_rival_of_the_same_observation_that_tempers(models):
    task, root, leak, friction = models
    loud = replace(leak, score=replace(leak.score, cost=0.5 * leak.score.cost, dispersion=7.0))
    assert comparison(task, leak, root, [loud]).dispersion == 7.0
    worse = replace(leak, score=replace(leak.score, cost=2.0 * leak.score.cost, dispersion=9.0))
    assert comparison(task, leak, root, [worse]).dispersion < 7.0
    assert comparison(task, friction, root, [loud]).dispersion < 7.0


@pytest.mark.parametrize(('before', 'after', 'share'), [
    (11.0, 1.0, 1.0), (11.0, 6.0, 0.5), (11.0, 11.0, 0.0), (0.9, 0.8, 0.0)])
def test_what_is_explained_is_of_what_was_there_beyond_noise(models, before, after, share):
    _, root, leak, _ = models
    assert explained(replace(leak, reduced_chi2=after),
                     replace(root, reduced_chi2=before)) == pytest.approx(share)
    assert leaves_noise(replace(root, reduced_chi2=1.1))


def test_of_laws_of_friction_that_leave_what_idealising_leaves_the_first_counts():
    """Whatever the evidence: a law is never quite the valve's, and a richer one takes up more."""
    task = task_of(recorded(), ('stem_friction', 'position_dependent_friction'), ())
    root = replace(as_given(task), reduced_chi2=100.0)
    plain, rich = (as_given(task, name) for name in task.names)
    rich = replace(rich, reduced_chi2=1.2, score=replace(rich.score, cost=0.5 * plain.score.cost))
    for left, expected in ((2.0, 'stem_friction'), (20.0, 'position_dependent_friction')):
        found = _best(task, root, [replace(plain, reduced_chi2=left), rich])
        assert found.effects == (expected,)


def test_where_nothing_is_missing_the_score_test_promises_nothing():
    """So no further model is fitted."""
    task = task_of(recorded(seed=4), ('chamber_leak', 'ep_hysteresis', 'position_backlash'))
    root = refitted(task)
    assert leaves_noise(root)
    found = neighbours(task, root, task.names)
    assert found.far == []
    assert select(task, nothing_said).chosen.effects == ()


@pytest.mark.campaign
def test_a_stem_that_sticks_is_found():
    plant = put(put(P, 'actuator.coulomb_friction', 400.0), 'actuator.stiction', 150.0)
    task = task_of(recorded(plant), ('stem_friction', 'chamber_leak'))
    found = select(task, nothing_said)
    assert found.chosen.effects == ('stem_friction',)
    assert found.chosen.problem.observation is WINDOWS
    rubs = found.chosen.fit.parameters.actuator
    assert rubs.coulomb_friction + rubs.stiction == pytest.approx(550.0, rel=0.25)
    assert found.chosen.reduced_chi2 < 0.1 * found.root.reduced_chi2


@pytest.mark.campaign
def test_what_has_no_name_is_a_term_in_its_place():
    """A spring whose force goes up and down along the travel."""
    wave = 300.0 * np.sin(np.linspace(0.0, 15.0, KNOTS))
    plant = P._replace(discrepancy=Discrepancy(
        STEM, VALVE_POSITION, tuple(np.linspace(0.0, 0.016, KNOTS)), tuple(wave)))
    task = replace(task_of(recorded(plant), ('chamber_leak',)), places=frozenset({'stem'}))
    found = select(task, nothing_said)
    # over a record so short, a change with a long memory is the position
    (found_there,) = found.chosen.effects
    assert found_there.startswith('unknown: stem over valve_position')
    assert found.named.effects != found.chosen.effects
    assert explained(found.chosen, found.root) > 0.9


@pytest.mark.parametrize('asked', [set(), {'sensor'}, {'booster', 'stem'}])
def test_below_a_subsystem_that_is_met_terms_are_tried_where_they_were_asked_for(asked):
    """As if all that is missing were in the stem: above it noise is left, said to be loud."""
    seen = recorded()
    seen = replace(seen, noise={name: 2.0 * level for name, level in seen.noise.items()})
    task = replace(task_of(seen, ('chamber_leak', 'position_backlash'), ()),
                   places=frozenset(asked))
    root = as_given(task)
    root = replace(root, reduced_chi2=1e3, score=replace(root.score, cost=1e3 * root.score.cost))
    below, begin = _upstream_first(task, root, _Trace(root), nothing_said)
    assert begin is root
    assert below.names == ('position_backlash',)
    assert below.places == asked - {'booster'}
