# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What is left when an effect is taken from a choice again."""

from dataclasses import replace

from made_search import (
    LEAKING, P, RUBBING, STEPS, searching, seen, standing_at, steps_seen)
import pytest

from booster_ros.diagnosis.estimation.uncertainty import left_of
from booster_ros.diagnosis.searching.backward import (
    _backward, _pruned, _two_in_its_place, _without)
from booster_ros.model.parameters import from_values


def test_what_is_left_without_an_effect_that_was_none_begins_where_it_was_with_it():
    """The round that had friction alone got stuck: its misfit would let any term win."""
    search = searching(seen(LEAKING), ())
    chosen = standing_at(search, ('ep_hysteresis', 'stem_friction', 'chamber_leak'), {
        **RUBBING, 'actuator.leak_area': 4e-8, 'ep_converter.hysteresis': 1e-9})
    rest = ('stem_friction', 'chamber_leak')
    stuck = standing_at(search, rest, {
        **RUBBING, 'actuator.coulomb_friction': 2000.0, 'actuator.leak_area': 4e-8})
    assert search.fault(chosen.problem, chosen.fit, 'ep_hysteresis')
    assert stuck.score > 2.0 * chosen.score
    left = _backward(search, chosen, [chosen, stuck], {})
    assert set(left.effects) == set(rest)
    assert left.misfit < 1.3


def test_a_bent_stem_is_left_alone_by_the_plain_friction_that_it_was_found_beside():
    """Uniform friction came first, and is in the bent stem's: alone that had got stuck."""
    search = searching(seen(P._replace(actuator=P.actuator._replace(
        coulomb_friction=100.0, friction_gradient=600.0))), ())
    values = {'actuator.coulomb_friction': 100.0, 'actuator.friction_gradient': 600.0,
              'actuator.stiction': 2.0, 'actuator.presliding_stiffness': 0.0}
    both = ('stem_friction', 'position_dependent_friction')
    chosen = standing_at(search, both, values)
    stuck = standing_at(search, both[1:], {**values, 'actuator.friction_gradient': 60.0})
    assert not search.fault(chosen.problem, chosen.fit, 'stem_friction')
    assert stuck.score > 2.0 * chosen.score
    left = _backward(search, chosen, [chosen, stuck], {})
    assert left.effects == both[1:]
    assert left.misfit < 1.3
    assert left.fit.parameters.actuator.friction_gradient == pytest.approx(600.0, rel=0.05)


@pytest.mark.parametrize(('effects', 'name', 'left'), [
    (('chamber_leak', 'dead_time'), 'dead_time', ('chamber_leak',)),
    (('position_dependent_friction',), 'position_dependent_friction', ('stem_friction',)),
    (('position_dependent_friction', 'stem_friction'), 'position_dependent_friction',
     ('stem_friction',)),
    (('position_dependent_friction', 'chamber_leak'), 'chamber_leak',
     ('position_dependent_friction',))])
def test_what_is_left_of_friction_along_the_travel_is_friction(effects, name, left):
    assert left_of(effects, name) == left


@pytest.mark.parametrize('without', [_backward, _pruned])
def test_friction_stays_where_it_is_not_shown_to_differ_along_the_travel(without):
    search = searching(seen(LEAKING), ())
    chosen = standing_at(search, ('chamber_leak', 'position_dependent_friction'), {
        **RUBBING, 'actuator.leak_area': 4e-8, 'actuator.friction_gradient': 1.0,
        'actuator.presliding_stiffness': 1e7})
    assert search.fault(chosen.problem, chosen.fit, 'position_dependent_friction')
    everything = [chosen]
    left = without(search, chosen, everything, *([{}] if without is _backward else []))
    assert set(left.effects) == {'chamber_leak', 'stem_friction'}
    assert left in everything
    assert left.misfit < 1.3


@pytest.mark.parametrize('learnt', [False, True])
def test_what_learnt_from_held_back_segments_is_compared_with_what_did_as_well(learnt):
    search = searching(seen(P), ())
    chosen = replace(standing_at(search, ('chamber_leak', 'ep_hysteresis'), {
        'actuator.leak_area': 1e-9, 'ep_converter.hysteresis': 1e-9}), learnt=learnt)
    left = _without(search, chosen, ('chamber_leak',), [], {})
    roles = ('fit', 'select') if learnt else ('fit',)
    assert left.learnt == learnt
    assert left.problem.rows_counted() == search.on(
        left.problem, roles, search.thinning).rows_counted()


@pytest.mark.parametrize(('plant', 'effects'), [
    ({'ep_converter.hysteresis': 3.5e-6, 'actuator.spring_bend': -75.0,
      'actuator.spring_excess': 290.0}, ('ep_hysteresis', 'spring_nonlinearity')),
    ({'booster.intake_preload': 0.02, 'booster.exhaust_preload': 0.02}, ('booster_dead_band',)),
], ids=['imitated', 'itself'])
def test_two_effects_that_a_third_imitated_take_its_place(plant, effects):
    """On some records a dead band leaves little, and a bent spring a part of that."""
    search = searching(steps_seen(from_values(plant), STEPS, 1.7e5, seed=5), ())

    def as_if(effects, values, left, **start):
        """Return a model that would leave so much on average."""
        model = standing_at(search, effects, {**values, **start})
        return replace(model, by_segment=left * model.samples * search.values_held_back()
                       / search.values_held_back().sum())

    dead = {'booster.intake_preload': 0.02, 'booster.exhaust_preload': 0.005}
    chosen = as_if(('booster_dead_band',), dead, 1.26)
    lagging = as_if(('ep_hysteresis',), {
        'ep_converter.hysteresis': 3.2e-6, 'ep_converter.offset': 7e3}, 3.7)
    bent = as_if(('booster_dead_band', 'spring_nonlinearity'), {
        **dead, 'actuator.spring_bend': -75.0, 'actuator.spring_excess': 170.0}, 1.09)
    rubbing = as_if(('booster_dead_band', 'stem_friction'), {**dead, **RUBBING}, 1.08)
    everything = [chosen, lagging, bent, rubbing]
    assert _two_in_its_place(search, chosen, everything, lambda *_: None).effects == effects
    assert everything[-1].effects == ('ep_hysteresis', 'spring_nonlinearity')
