# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a record could not tell apart, whatever its noise was."""

from dataclasses import replace

from made_task import P, steps_seen, task_of
import numpy as np
import pytest

from booster_ros.diagnosis.estimation.parametrisation import put
from booster_ros.diagnosis.selection.equivalence import alike
from booster_ros.diagnosis.selection.neighbours import refitted
from booster_ros.diagnosis.selection.stepwise import Selection

LEVELS = np.array([4.0, 4.5, 4.2, 4.35, 4.1, 4.55])
OTHERS = ('exhaust_seat_leak', 'spring_nonlinearity', 'position_backlash')


@pytest.fixture(scope='module')
def leaking():
    """Return task, declared model and the one with a leak of the chamber of a valve with one."""
    experiment = steps_seen(put(P, 'actuator.leak_area', 3e-8), LEVELS, 1e5, 7)
    task = task_of(experiment, ('chamber_leak', *OTHERS))
    root = refitted(task)
    return task, root, refitted(task, ('chamber_leak',), root.fit)


def selection(root, chosen, *others):
    return Selection(root, chosen, chosen, (root, chosen, *others), ())


def test_two_leaks_of_the_same_air_are_one_to_a_record_and_a_curved_spring_is_not(leaking):
    """By expected discrimination: no other model was fitted."""
    task, root, chosen = leaking
    assert alike(task, selection(root, chosen), chosen, 'chamber_leak') == ('exhaust_seat_leak',)


def test_a_fitted_model_of_the_same_evidence_is_alike_and_one_of_less_is_not(leaking):
    task, root, chosen = leaking
    alone = replace(task, names=('chamber_leak',))  # expected discrimination asks no other
    for name, cost, said in (('position_backlash', 1.0, True), ('position_backlash', 30.0, False),
                             ('unknown: stem over time', 0.0, False)):
        other = replace(chosen, effects=(name,), score=replace(
            chosen.score, cost=chosen.score.cost + cost))
        found = alike(alone, selection(root, chosen, other), chosen, 'chamber_leak')
        assert found == ((name,) if said else ())


def test_what_was_fitted_to_other_rows_is_no_rival(leaking):
    task, root, chosen = leaking
    fewer = replace(chosen, effects=('position_backlash',), score=replace(
        chosen.score, observed=chosen.score.observed // 2))
    assert alike(replace(task, names=('chamber_leak',)), selection(root, chosen, fewer), chosen,
                 'chamber_leak') == ()
