# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a record could not tell apart, whatever its noise was, and what screening reaches."""

from dataclasses import replace

import numpy as np
import pytest

from booster_ros.diagnosis.data.experiment import Experiment, Initial
from booster_ros.diagnosis.data.blocks import split
from booster_ros.diagnosis.hypotheses.applicable import applicable
from booster_ros.diagnosis.estimation.parametrisation import declared_freedom, put
from booster_ros.diagnosis.searching import rematch as rematching
from booster_ros.diagnosis.searching.candidate import UNLIKELY
from booster_ros.diagnosis.selection.equivalence import substitutes
from booster_ros.diagnosis.searching.next_effect import CLOSE, _Begun, _bring_to_equal_terms
from booster_ros.diagnosis.searching.rematch import NEAR, _from_the_end_of, rematch
from booster_ros.diagnosis.selection.screening import references, screen
from booster_ros.diagnosis.searching.search import Search
from booster_ros.model.simulation import simulate
from booster_ros.model.system import PositionerParameters

P = PositionerParameters()
TIME = np.arange(0.0, 60.0, 0.02)
LEVELS = np.array([4.0, 4.5, 4.2, 4.35, 4.1, 4.55, 4.3, 4.45, 4.05, 4.4, 4.15, 4.5])
NOISE = {'chamber_pressure': 150.0, 'valve_position': 8e-6}


def search_of(plant, channels=tuple(NOISE)):
    """Return a search over a noisy record of a plant whose effects nobody declared."""
    current = 1e-4 * LEVELS[(TIME // 5.0).astype(int)]
    run = simulate(plant, TIME, current, {'chamber_pressure': 1e5})
    rng = np.random.default_rng(7)
    measured = {name: run[f'measured_{name}'] + NOISE[name] * rng.standard_normal(len(TIME))
                for name in channels}
    experiment = Experiment(TIME, current, measured, {name: NOISE[name] for name in channels}, {},
                            Initial(float(measured['chamber_pressure'][0])))
    return Search(experiment, split(TIME, current), P, tuple(declared_freedom(P, experiment)),
                  applicable(experiment, P))


def begun_with(search, effect, size):
    """Return the problem with one effect, and z with so many typical sizes of it."""
    problem = search.joint(search.problem(), (effect,))
    start = problem.start()
    start[len(search.freedoms)] = size
    return problem, start


def model_with(search, effect, size):
    """Return the model with one effect, fitted from a size of so many typical ones."""
    problem, start = begun_with(search, effect, size)
    return search.rate((effect,), problem, problem.fit(start))


OTHERS = ('exhaust_seat_leak', 'opening_nonlinearity', 'spring_nonlinearity', 'ep_nonlinearity',
          'position_backlash', 'supply_droop', 'bench_set_shift', 'effective_area_change')


def places_of(search, chosen, others=OTHERS):
    """Return what other effects would cost in the place of the one that was chosen."""
    problem = search.on(chosen.problem, ('fit', 'select'), 1)
    rest = search.on(search.problem(), ('fit', 'select'), 1)
    found = substitutes(problem, problem.at(chosen.fit.z), rest, others)
    return {one.effect: one.cost for one in found}


@pytest.fixture(scope='module', name='leaking')
def fixture_leaking():
    search = search_of(put(P, 'actuator.leak_area', 3e-8))
    return search, model_with(search, 'chamber_leak', 0.5)


def test_how_a_record_starts_tells_no_two_leaks_apart(leaking):
    """A converter that had not settled is a departure from what is given, with either leak."""
    search, chosen = leaking
    problem = search.on(chosen.problem, ('fit', 'select'), 1)
    unsettled = chosen.fit.z.copy()
    unsettled[len(problem.freedoms) + 1] += 16.0  # 8 kPa
    rest = search.on(search.problem(), ('fit', 'select'), 1)
    (other,) = substitutes(problem, problem.at(unsettled), rest, ('exhaust_seat_leak',))
    assert abs(other.cost) < 1.0


def test_two_leaks_of_the_same_air_are_one_to_a_record_and_a_curved_spring_is_not(leaking):
    costs = places_of(*leaking)
    assert next(iter(costs)) == 'exhaust_seat_leak'
    assert abs(costs['exhaust_seat_leak']) < 1.0
    assert costs['spring_nonlinearity'] > 100.0
    assert costs['position_backlash'] > 100.0
    assert list(costs.values()) == sorted(costs.values())


def test_what_an_effect_had_made_unsure_is_sure_again_without_it(leaking, monkeypatch):
    """A converter that is not straight leaves its gain and its offset open."""
    search, _ = leaking
    chosen = model_with(search, 'ep_nonlinearity', 0.5)
    assert chosen.problem.freedoms[:len(search.freedoms)] != search.freedoms
    asked = []
    monkeypatch.setattr(
        rematching, 'substitutes', lambda _, __, rest, ___: asked.append(rest) or [])
    rematch(search, chosen, [chosen])
    assert [rest.freedoms for rest in asked] == [search.freedoms]


def test_without_the_stem_seen_a_leak_is_more_alike_to_others(leaking):
    seen = places_of(*leaking)
    blind = search_of(put(P, 'actuator.leak_area', 3e-8), ('chamber_pressure',))
    unseen = places_of(blind, model_with(blind, 'chamber_leak', 0.5))
    told_apart = [unseen[name] / seen[name] for name in OTHERS[1:]]
    assert np.median(told_apart) < 0.9


def test_what_cannot_be_told_apart_is_fitted_before_anything_is_chosen(leaking):
    search, chosen = leaking
    search = replace(search, names=('chamber_leak', *OTHERS))
    compared = rematch(search, chosen, [chosen])
    assert {one.effects for one in compared} == {('chamber_leak',), ('exhaust_seat_leak',)}
    assert compared[0].effects == ('chamber_leak',)
    assert compared[1].fit.cost == pytest.approx(compared[0].fit.cost, abs=1.0)
    alone = replace(search, names=tuple(n for n in search.names if n != 'exhaust_seat_leak'))
    assert rematch(alone, chosen, [chosen]) == [chosen]


class SeesNoLeakOfTheChamber(Search):
    """A search whose rows do not show a chamber leak, whatever was fitted."""

    def faults(self, candidate):
        leak = candidate.effects == ('chamber_leak',)
        return {'chamber_leak': 'none of it'} if leak else super().faults(candidate)


def test_the_plainer_one_gives_way_where_the_rows_do_not_show_it(leaking):
    search, chosen = leaking
    blind = SeesNoLeakOfTheChamber(search.experiment, search.segments, search.declared,
                                   search.freedoms, ('chamber_leak', 'exhaust_seat_leak'))
    first, last = rematch(blind, chosen, [chosen])
    assert (first.effects, first.fault) == (('exhaust_seat_leak',), '')
    assert (last.effects, last.fault) == (('chamber_leak',), 'none of it')


def test_the_best_of_a_round_is_carried_on_if_one_that_was_behind_it_came_below_it(leaking):
    search, chosen = leaking
    ended = {}
    for effect, size in (('chamber_leak', 0.8), ('exhaust_seat_leak', 0.1)):
        problem, start = begun_with(search, effect, size)
        ended[effect] = _Begun(effect, problem, problem.fit(start, evaluations=3))
    ahead, behind = sorted(ended, key=lambda name: ended[name].fit.cost)
    at_its_end = chosen.fit.cost
    assert 1.01 * at_its_end < ended[ahead].fit.cost < ended[behind].fit.cost
    assert ended[behind].fit.cost < CLOSE * ended[ahead].fit.cost
    _bring_to_equal_terms(ended)
    for one in ended.values():
        assert one.fit.cost == pytest.approx(at_its_end, rel=0.01)


def test_an_effect_in_a_flat_valley_is_fitted_from_where_the_best_is(leaking):
    search, chosen = leaking
    best = search.to_the_end(chosen)
    other = search.to_the_end(model_with(search, 'exhaust_seat_leak', 0.5))
    z = other.fit.z.copy()
    z[[free.knob.parameter for free in other.fit.freedoms].index('actuator.dead_volume')] += 0.2
    short = replace(other, fit=other.problem.at(z))
    assert UNLIKELY < short.fit.cost - best.fit.cost < (NEAR - 1.0) * best.fit.cost
    further = _from_the_end_of(best, search, short)
    assert further.learnt
    assert further.effects == ('exhaust_seat_leak',)
    assert further.fit.cost == pytest.approx(best.fit.cost, abs=1.0)
    assert _from_the_end_of(best, search, best) is best


def test_screening_ends_where_an_effect_was_simulated_to_be_not_where_it_was_reckoned():
    """The declared parameters have to move far before this exhaust is recognised."""
    plant = put(P, 'booster.exhaust_gain_ratio', 0.6)
    search = search_of(plant)
    refit = search.refit()
    problem = refit.problem
    found = screen(problem, references(problem, problem.at(refit.fit.z)), 'exhaust_asymmetry',
                   np.array([0.5]))
    reached = min(float(np.sum(found.problem.residuals(z)**2)) for z in found.starts)
    assert reached < 1.3 * problem.observed
    assert refit.fit.cost > 3.0 * problem.observed
