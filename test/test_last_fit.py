# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What of a verdict stands where it is fitted to all but the locked part."""

from dataclasses import replace

from made_search import (
    P, RAMPS, RAMPS_TIME, STEPS, searching, seen, standing_at, steps_seen)
import numpy as np
import pytest

from booster_ros.diagnosis import last_fit as finishing
from booster_ros.diagnosis.data.blocks import USED
from booster_ros.diagnosis.estimation.parametrisation import get, put
from booster_ros.diagnosis.last_fit import _without, last_fit, verdict_of
from booster_ros.diagnosis.searching.nameless import preferable
from booster_ros.diagnosis.searching.selection import Tried
from booster_ros.diagnosis.hypotheses.discrepancy import UNNAMED, terms, with_term


def test_a_term_that_leaves_no_less_on_all_but_the_locked_part_is_no_verdict():
    search = searching(steps_seen(P, STEPS, 1.7e5, seed=5), ())
    refit = search.refit()
    last = last_fit(search, refit)
    in_stem = next(one for one in terms(search.experiment.channels)
                   if one.label == 'stem over valve_position')
    used, _ = search.rows_and_experiment(USED, search.thinning)
    joint = with_term(refit.problem, refit.problem.at(refit.fit.z), in_stem, used)
    candidate = search.rate((UNNAMED + in_stem.label,), joint, joint.fit(evaluations=3))
    tried = Tried(refit, refit, (refit,), {})
    assert preferable(candidate, tried)
    assert verdict_of(search, tried, [candidate], last) == ('none', tried, last)


@pytest.mark.parametrize(('bend', 'verdict'), [(0.0, 'none'), (400.0, 'effect')])
def test_an_effect_that_all_but_the_locked_part_does_not_show_is_left_out(bend, verdict):
    search = searching(steps_seen(put(P, 'actuator.spring_bend', bend), STEPS, 1.7e5, seed=5),
                       ('spring_nonlinearity',))
    refit = search.refit()
    chosen = standing_at(search, ('spring_nonlinearity',), {'actuator.spring_bend': 100.0})
    reasons = {frozenset(('spring_nonlinearity',)): 'chosen', frozenset(): 'refitted'}
    tried = Tried(refit, chosen, (refit, chosen), reasons)
    said, after, last = verdict_of(search, tried, [], last_fit(search, refit))
    assert said == verdict
    why = after.reasons[frozenset(('spring_nonlinearity',))]
    if verdict == 'none':
        assert after.chosen is refit
        assert why == ('fitted to all but the locked part: spring_nonlinearity: its size is not '
                       'told from none')
        assert last.fit.parameters.actuator.spring_bend == 0.0
    else:
        assert after.chosen is chosen
        assert why == 'chosen'
        assert last.fit.parameters.actuator.spring_bend == pytest.approx(bend, rel=0.2)


@pytest.mark.parametrize(('left', 'remains'), [(0.99, ()), (0.5, ('ep_drift',))])
def test_what_remains_of_two_effects_has_to_be_called_for(left, remains):
    """However well it does on segments that it has learnt."""
    refit = searching(seen(P), ()).refit()
    refit = replace(refit, by_segment=np.full(6, 100.0), prior=0.0, samples=100)
    one = replace(refit, effects=('ep_drift',), by_segment=left * refit.by_segment)
    learnt = replace(one, by_segment=0.2 * refit.by_segment, learnt=True)
    both = replace(learnt, effects=('ep_drift', 'dead_time'))
    tried = Tried(refit, both, (refit, one, learnt, both), {})
    after = _without(tried, 'dead_time', 'its size is not told from none')
    assert after.chosen.effects == remains
    assert not after.chosen.learnt


@pytest.mark.parametrize(('sliding', 'stiction', 'seed', 'rows', 'left'), [
    (40.0, 10.0, 1, slice(None), 1.05), (100.0, 30.0, 2, slice(3000), 1.7)],
    ids=['near the noise at once', 'after trials of friction'])
def test_declared_parameters_come_back_where_the_stem_sticks(
        sliding, stiction, seed, rows, left, monkeypatch):
    """
    A search ends with parameters that had imitated friction, and slips hold them there.

    So it is where no fit follows the slips.
    """
    monkeypatch.setattr(finishing, 'fit_slip_by_slip', lambda *_: None)
    plant = put(put(P, 'actuator.coulomb_friction', sliding), 'actuator.stiction', stiction)
    search = searching(
        seen(plant, current=RAMPS[rows], time=RAMPS_TIME[rows], seed=seed), ('stem_friction',))
    bent = {'ep_converter.time_constant': 0.02, 'actuator.dead_volume': 1.94e-4,
            'actuator.viscous_friction': 2500.0}
    candidate = standing_at(search, ('stem_friction',), {
        **bent, 'actuator.coulomb_friction': 1.02 * sliding, 'actuator.stiction': 0.5 * stiction,
        'actuator.presliding_stiffness': 1e8, 'actuator.presliding_damping': 0.95,
        'actuator.stribeck_velocity': 8e-4})
    last = last_fit(search, candidate)
    for name in ('ep_converter.time_constant', 'actuator.dead_volume'):
        assert get(last.fit.parameters, name) == pytest.approx(get(P, name), rel=0.03)
    assert last.problem.mean_square(last.fit) < left
    if last.trials is not None:
        missed = last.problem.cost_through_slips(last.fit.z)
        assert missed == pytest.approx(last.trials.cost.min(), rel=1e-3)
        assert any(np.array_equal(last.fit.z, z) for z in last.trials.as_good)
