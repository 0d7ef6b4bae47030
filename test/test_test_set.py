# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The test set: opened once, what stands in it, and a term that does not."""

from dataclasses import replace

from made_task import P, seen, steps_seen, task_of
import numpy as np
import pytest

from booster_ros.diagnosis import pipeline
from booster_ros.diagnosis.data.blocks import rows_of, split, training_blocks
from booster_ros.diagnosis.estimation import final_fit
from booster_ros.diagnosis.estimation.parametrisation import declared_freedom
from booster_ros.diagnosis.hypotheses.discrepancy import terms
from booster_ros.diagnosis.judging.test_set import stands, without_test_set
from booster_ros.diagnosis.result import ChannelError, errors_of
from booster_ros.diagnosis.selection import terms as best
from booster_ros.diagnosis.selection.neighbours import refitted
from booster_ros.diagnosis.selection.stepwise import Selection
from booster_ros.model.discrepancy import KNOTS, STEM, VALVE_POSITION, Discrepancy

WAVE = 300.0 * np.sin(np.linspace(0.0, 15.0, KNOTS))
LEVELS = np.array([3.8, 4.3, 4.0, 4.4, 3.9, 4.2])


def waving(sign=1.0):
    """Return what is seen of a spring whose force goes up and down along the travel."""
    table = Discrepancy(
        STEM, VALVE_POSITION, tuple(np.linspace(0.0, 0.016, len(WAVE))), tuple(sign * WAVE))
    return steps_seen(P._replace(discrepancy=table), LEVELS, 1.7e5, seed=4)


def rows_tested(experiment):
    """Return a rows' mark of the test set."""
    return rows_of(split(experiment.time, experiment.current), 'test', len(experiment.time))


def errors(before, after):
    return {name: ChannelError('Pa', before, before, value, 1.0)
            for name, value in zip(('chamber_pressure', 'valve_position'), after)}


@pytest.mark.parametrize(('before', 'after', 'stays'), [
    (10.0, (10.4, 10.4), True),
    (10.0, (10.4, 11.2), False),
    (10.0, (3.0, 6.0), True),
    (1.0, (1.04, 1.04), True),
    (1.0, (1.5, 1.5), False),
    (0.5, (1.0, 1.0), True),  # all is less than noise
    (10.0, (np.nan, 1.0), False),
])
def test_what_was_added_stands_where_it_makes_the_error_no_larger(before, after, stays):
    assert stands(errors(before, after)) == stays


def test_a_channel_without_a_value_in_the_test_set_says_nothing():
    blind = errors(np.nan, (np.nan, np.nan))
    assert stands(blind)


def test_nothing_can_be_chosen_by_what_is_hidden():
    experiment = seen(P)
    hidden = without_test_set(experiment, split(experiment.time, experiment.current))
    for name, values in hidden.measured.items():
        assert np.array_equal(np.isnan(values), rows_tested(experiment))
        assert np.isfinite(experiment.measured[name]).all()


def test_a_run_that_was_lost_on_the_way_is_no_small_error():
    experiment = seen(P)
    run = {name: np.where(np.arange(len(values)) < 100, values, np.nan)
           for name, values in experiment.measured.items()}
    runs = {'declared': run, 'before': experiment.measured, 'after': run}
    lost = errors_of(experiment, runs, np.ones(len(experiment.time), dtype=bool))
    assert not any(np.isfinite(error.after) for error in lost.values())


@pytest.fixture(scope='module')
def waved():
    """Return the task of a spring that waves, its declared model, and the one with a term."""
    experiment = waving()
    free = tuple(one for one in declared_freedom(P, experiment)
                 if one.knob.parameter in ('ep_converter.gain', 'actuator.bench_set'))
    task = replace(task_of(experiment, freedoms=free), places=frozenset({'stem'}))
    root = refitted(task)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(best, 'terms', lambda *valve: [
            one for one in terms(*valve) if one.label == 'stem over valve_position'])
        (term,) = best.best_terms(task, root)
    return task, root, term


def seen_anew(experiment, model):
    """Return a model as it would be, had it been fitted to the training rows of this experiment."""
    return replace(model, problem=replace(model.problem, experiment=experiment))


@pytest.mark.parametrize('stays', [True, False])
def test_a_term_that_the_test_set_speaks_against_is_not_in_the_model(stays, waved, monkeypatch):
    """It was there as long as was looked, and the other way round when that part came."""
    monkeypatch.setattr(final_fit, 'ROUNDS', 1)  # how exactly a valley is fitted does not matter
    task, root, term = waved
    if not stays:
        other = waving(-1.0).measured
        experiment = replace(task.experiment, measured={
            name: np.where(rows_tested(task.experiment), other[name], values)
            for name, values in task.experiment.measured.items()})
        task = replace(task, experiment=experiment)
        root, term = seen_anew(experiment, root), seen_anew(experiment, term)
    selection = Selection(root, term, root, (root, term), ())
    block = training_blocks(task.segments, len(task.experiment.time))
    chosen, after, runs, refused = pipeline._tested(task, selection, block)
    found = pipeline._diagnosis(task, selection, chosen, after, runs, refused, ())
    assert found.verdict == 'unknown'
    assert [effect.location for effect in found.effects] == ['stem']
    assert found.added == stays == (found.refused is None)
    assert found.decided != stays
    if stays:
        assert found.after.discrepancy.location == STEM
        return
    assert found.after == found.before
    assert found.unknown is None
    assert found.refused.beyond < 0.2
    for name, error in found.held_out.items():
        assert error.after == error.before
        assert found.refused.error[name] > 0.0
