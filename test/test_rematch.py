# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Rivals of a choice meet it again, with what is known of the friction of the stem."""

from made_search import LEAKING, P, RUBBING, searching, seen, standing_at
import numpy as np
import pytest

from booster_ros.diagnosis.searching.candidate import preferred_first
from booster_ros.diagnosis.searching.rematch import _by_slips, _plainest_above, rematch


def test_rivals_above_a_stem_that_sticks_meet_again_with_the_same_friction():
    """The leak that a fit without the right friction had left behind is the plainer of two."""
    search = searching(seen(LEAKING), ())
    chosen = standing_at(search, ('exhaust_seat_leak', 'stem_friction'), {
        **RUBBING, 'booster.exhaust_leak_area': 4e-8})
    behind = standing_at(search, ('stem_friction', 'chamber_leak'), {
        **RUBBING, 'actuator.coulomb_friction': 385.0, 'actuator.leak_area': 4e-8})
    assert chosen.score < behind.score < 2.0 * chosen.score
    again = rematch(search, chosen, [chosen, behind])
    assert again[0].effects == ('stem_friction', 'chamber_leak')
    assert again[0].score < behind.score


@pytest.mark.parametrize(('plainer', 'place'), [('chamber_leak', 0), ('supply_seat_leak', 1)])
def test_slips_by_chance_do_not_decide_between_effects_above_the_stem(plainer, place):
    """A leak of the chamber and one of the seat are the same air; one from the supply is not."""
    search = searching(seen(LEAKING), ())
    chosen = standing_at(search, ('exhaust_seat_leak', 'stem_friction'), {
        **RUBBING, 'booster.exhaust_leak_area': 4e-8})
    unlucky = standing_at(search, ('stem_friction', plainer), {
        **RUBBING, 'actuator.coulomb_friction': 385.0, 'actuator.leak_area': 4e-8})
    assert unlucky.score > 1.2 * chosen.score
    assert _plainest_above(search, [chosen, unlucky]) is (unlucky, chosen)[place]


def test_a_rival_that_got_stuck_meets_again_if_it_leaves_less_above_the_stem():
    """Its own friction is far off: it begins with that of the choice."""
    search = searching(seen(LEAKING), ())
    chosen = standing_at(search, ('exhaust_asymmetry', 'stem_friction'), {
        **RUBBING, 'booster.exhaust_gain_ratio': 1.1})
    stuck = standing_at(search, ('stem_friction', 'chamber_leak'), {
        **RUBBING, 'actuator.coulomb_friction': 2000.0, 'actuator.leak_area': 4e-8})
    assert stuck.score > 2.0 * chosen.score
    again = rematch(search, chosen, [chosen, stuck])
    assert again[0].effects == ('stem_friction', 'chamber_leak')
    assert again[0].misfit < 1.3
    found = again[0].fit.parameters.actuator
    assert found.coulomb_friction == pytest.approx(400.0, rel=0.05)
    assert rematch(search, again[0], [again[0], chosen])[0] is again[0]


@pytest.mark.parametrize(('stuck', 'least', 'most'), [(385.0, 1.0, 2.0), (340.0, 2.0, 50.0)])
def test_rivals_of_a_stem_that_sticks_begin_with_the_friction_they_share(stuck, least, most):
    """
    Of a bent stem whose friction is the same everywhere nothing is left but friction.

    However far behind the fit of that got stuck: the choice has it in it.
    """
    plain = P._replace(actuator=P.actuator._replace(
        coulomb_friction=400.0, presliding_stiffness=1e7))
    search = searching(seen(plain), ())
    bent = standing_at(search, ('position_dependent_friction',), {
        'actuator.coulomb_friction': 400.0, 'actuator.friction_gradient': 0.3})
    behind = standing_at(search, ('stem_friction',), {
        'actuator.coulomb_friction': stuck, 'actuator.stiction': 10.0})
    assert least * bent.score < behind.score < most * bent.score
    again = rematch(search, bent, [bent, behind])
    assert again[0].effects == ('stem_friction',)
    assert again[0].fit.parameters.actuator.coulomb_friction == pytest.approx(400.0, rel=0.02)


def test_a_bent_stem_far_behind_is_no_rival_of_plain_friction():
    search = searching(seen(P._replace(actuator=P.actuator._replace(
        coulomb_friction=400.0, presliding_stiffness=1e7))), ())
    plain = standing_at(search, ('stem_friction',), {'actuator.coulomb_friction': 400.0})
    behind = standing_at(search, ('position_dependent_friction',), {
        'actuator.coulomb_friction': 340.0, 'actuator.friction_gradient': 0.3})
    assert behind.score > 2.0 * plain.score
    assert rematch(search, plain, [plain, behind]) == [plain]


@pytest.mark.parametrize(('true', 'kind'), [
    ({'coulomb_friction': 85.0, 'stiction': 85.0}, 'stem_friction'),
    ({'coulomb_friction': 60.0, 'friction_gradient': 300.0}, 'position_dependent_friction'),
], ids=['slips', 'bent'])
def test_kinds_of_friction_are_told_by_what_slips_do(true, kind):
    """What does not slip leaves less than slips of the right size that come out of step."""
    time = np.arange(0.0, 80.0, 0.02)
    current = 4.2e-4 + 0.3e-4 * np.abs((time / 20.0) % 2.0 - 1.0) + 0.15e-4 * ((time // 10.0) % 2.0)
    search = searching(seen(P._replace(actuator=P.actuator._replace(**true)), None, 1.9e5, current,
                            5, time), ())
    bent = standing_at(search, ('position_dependent_friction',), {
        'actuator.coulomb_friction': 114.0, 'actuator.friction_gradient': 20.0,
        'actuator.presliding_stiffness': 0.0})
    slips = standing_at(search, ('stem_friction',), {
        'actuator.coulomb_friction': 115.0, 'actuator.stiction': 20.0,
        'actuator.presliding_stiffness': 9e7, 'actuator.viscous_friction': 5000.0})
    ranked = preferred_first([bent, slips])
    assert ranked[0].misfit > 2.0
    assert ranked[0].effects != (kind,)
    assert _by_slips(search, ranked)[0].effects == (kind,)
