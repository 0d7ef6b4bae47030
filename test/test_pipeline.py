# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Short diagnoses from end to end of the pipeline."""

from dataclasses import replace

from made_task import P, seen, task_of
import numpy as np
import pytest

from booster_ros.diagnosis.data.blocks import rows_of, split, training_blocks
from booster_ros.diagnosis import pipeline
from booster_ros.diagnosis.estimation.parametrisation import declared_freedom, put
from booster_ros.diagnosis.pipeline import diagnose
from booster_ros.diagnosis.selection.neighbours import refitted
from booster_ros.diagnosis.selection.stepwise import Selection
from booster_ros.records import RecordError

LEVELS = np.array([3.8, 4.3, 4.0, 4.4, 3.9, 4.2])
NAMES = ('chamber_leak', 'position_backlash')


def steps_of(parameters, seed):
    """Return the experiment of 30 s of steps, 5 s each, with rows 50 ms apart."""
    time = np.arange(0.0, 5.0 * len(LEVELS), 0.05)
    return seen(parameters, None, 1.7e5, 1e-4 * LEVELS[(time // 5.0).astype(int)], seed, time)


@pytest.fixture(scope='module')
def leaking():
    """Return the diagnosis of 30 s of steps of a valve that leaks."""
    told = []
    found = diagnose(steps_of(put(P, 'actuator.leak_area', 5e-8), 3), P,
                     lambda phrase, share: told.append(share), ('a note',), NAMES)
    return found, told


def test_a_leak_is_named_with_its_size(leaking):
    found, _ = leaking
    assert found.verdict == 'effect'
    (effect,) = found.effects
    assert (effect.name, effect.location) == ('chamber_leak', 'chamber')
    size = effect.parameters['actuator.leak_area']
    assert size.value == pytest.approx(5e-8, rel=0.05)
    assert size.low < size.value < size.high
    assert effect.standing == 'confirmed'
    assert effect.explained > 0.9
    assert found.added
    for error in found.held_out.values():
        assert error.met


def test_each_step_of_the_selection_is_in_the_trace(leaking):
    found, _ = leaking
    step = [one for one in found.trace if one.outcome == 'accepted'][-1]
    assert (step.effects, step.against) == (('chamber_leak',), ())
    assert step.found.log_evidence > 100.0
    assert step.found.gain > 2.0 * step.found.gain_standard_error > 0.0
    assert 1.0 <= step.found.dispersion < 2.0
    assert step.reduced_chi2 < 1.15
    chosen, *others = sorted(found.suspects, key=lambda one: one.reason != 'chosen')
    assert chosen.effects == ('chamber_leak',)
    assert () in [one.effects for one in others]


def test_progress_rises_to_the_end_and_notes_are_kept(leaking):
    found, told = leaking
    assert told == sorted(told)
    assert (told[0] >= 0.0, told[-1]) == (True, 1.0)
    assert found.notes[0] == 'a note'


def test_nothing_is_added_to_a_clean_record():
    found = diagnose(steps_of(P, 4), P, names=NAMES)
    assert (found.verdict, found.effects, found.unknown) == ('none', (), None)
    assert not found.added
    assert all(step.outcome != 'accepted' for step in found.trace)
    assert all(error.met for error in (*found.error.values(), *found.held_out.values()))


@pytest.mark.parametrize(('role', 'purpose'), [('train', 'fit'), ('test', 'judge')])
def test_a_record_without_a_value_to_fit_or_to_judge_by_is_refused(role, purpose):
    experiment = steps_of(P, 4)
    gone = rows_of(split(experiment.time, experiment.current), role, len(experiment.time))
    empty = replace(experiment, measured={
        name: np.where(gone, np.nan, values) for name, values in experiment.measured.items()})
    with pytest.raises(RecordError, match=f'no row to {purpose} by'):
        diagnose(empty, P, names=())


def test_an_effect_that_the_last_fit_puts_back_to_none_is_not_found():
    """Fits that models are compared by may end early: a slower converter was once a dead time."""
    leaking = put(P, 'actuator.leak_area', 5e-8)
    experiment = steps_of(leaking, 3)
    few = tuple(free for free in declared_freedom(P, experiment) if free.knob.parameter.startswith(
        ('ep_converter.', 'actuator.bench_set', 'actuator.dead_volume')))
    task = task_of(experiment, NAMES, few)
    root, leak = refitted(task), refitted(task, ('chamber_leak',))
    both = refitted(task, ('chamber_leak', 'dead_time'), leak.fit)
    selection = Selection(root, both, both, (root, leak, both), ())
    block = training_blocks(task.segments, len(task.experiment.time))
    chosen, last, _, refused = pipeline._tested(task, selection, block)
    assert (chosen, refused) == (leak, None)
    assert last.fit.parameters.ep_converter.dead_time == 0.0
    assert last.fit.parameters.actuator.leak_area == pytest.approx(5e-8, rel=0.05)
