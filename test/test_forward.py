# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Effects are added one by one: which, when, and how faint they may be."""

from dataclasses import replace
import itertools

from made_search import (
    P, RAMPS, RAMPS_TIME, STEPS, searching, seen, selected, steps_seen, too_quiet)
import numpy as np
import pytest

from booster_ros.diagnosis.estimation.parametrisation import put
from booster_ros.diagnosis.searching import forward
from booster_ros.diagnosis.searching.candidate import NEAR_NOISE
from booster_ros.diagnosis.searching.forward import named
from booster_ros.diagnosis.searching.search import Search


@pytest.mark.parametrize(('restriction', 'effects'), [
    (0.0, ('ep_hysteresis',)), (4.2e-6, ('ep_hysteresis', 'tubing_restriction'))])
def test_a_second_effect_is_found_also_where_the_first_leaves_what_could_be_noise(
        restriction, effects):
    """On ramps a thin tube is nearly a slower converter: that leaves 13 % above the noise."""
    plant = put(put(P, 'ep_converter.hysteresis', 1e-6), 'tubing.restriction_area', restriction)
    search = searching(seen(plant, None, 1.7e5, RAMPS, 4, RAMPS_TIME),
                       ('ep_hysteresis', 'tubing_restriction', 'chamber_leak'))
    tried = named(search, search.refit(), lambda *_: None)
    assert tried.chosen.effects == effects
    first = next(one for one in tried.all if one.effects == ('ep_hysteresis',))
    assert first.misfit < NEAR_NOISE


def short_of_its_end():
    """Return a search on a plant as declared but for its parameters, refitted in too few steps."""
    plant = put(put(P, 'ep_converter.offset', 4e3), 'actuator.dead_volume',
                1.1 * P.actuator.dead_volume)
    search = searching(seen(plant), ())
    problem = search.problem()
    return search, search.rate((), problem, problem.fit(evaluations=5))


def test_a_fit_is_carried_on_to_its_end():
    search, begun = short_of_its_end()
    end = begun.problem.fit(evaluations=40).cost
    assert 1.01 * end < begun.fit.cost < NEAR_NOISE * end
    assert search.at_its_end(begun).fit.cost < 1.002 * end


def test_at_the_end_of_a_fit_an_effect_is_judged_anew():
    search, begun = short_of_its_end()
    end = search.at_its_end(replace(begun, effects=()))
    assert not end.fault
    problem = search.joint(search.problem(), ('chamber_leak',))
    leaking = search.rate(('chamber_leak',), problem, problem.fit(evaluations=5))
    assert not leaking.fault
    assert search.at_its_end(leaking).fault == 'its size is not told from none'


@pytest.mark.parametrize('taught', [True, False])
@pytest.mark.parametrize('better', [True, False])
def test_what_only_takes_the_steps_that_a_refit_lacks_is_no_effect(monkeypatch, taught, better):
    search, begun = short_of_its_end()
    end = search.at_its_end(begun)
    monkeypatch.setattr(forward, 'SURE', 20.0)
    assert end.fit.cost < begun.fit.cost - forward.SURE
    refit = replace(begun, by_segment=1.5 * end.by_segment)
    share, fall = (0.8, 25.0) if better else (1.0, 0.0)
    effect = replace(end, effects=('chamber_leak',), by_segment=share * end.by_segment,
                     fit=replace(end.fit, cost=end.fit.cost - fall))
    monkeypatch.setattr(Search, 'at_its_end', lambda _, one: one if one.effects else end)
    monkeypatch.setattr(forward, '_round', lambda *_, **__: [effect])
    monkeypatch.setattr(forward, 'shown_on_every_row', lambda *_: [])
    monkeypatch.setattr(forward, 'taught', lambda *_: end if taught else None)
    chosen = named(search, refit, lambda *_: None).chosen
    assert chosen.effects == (('chamber_leak',) if better else ())


def test_where_scores_are_alike_the_plainest_effect_that_is_called_for_is_added(monkeypatch):
    """One that is plainer and falls just short of being called for does not hide it."""
    search = searching(too_quiet(seen(P)), ())
    refit = search.refit()
    missing = replace(refit, by_segment=2.0 * refit.by_segment)
    short, enough, further = (
        replace(missing, effects=(name,), by_segment=share * refit.by_segment)
        for name, share in (('dead_time', 1.9), ('chamber_leak', 1.3), ('supply_droop', 1.2)))
    rounds = itertools.chain([[short, enough, further]], itertools.repeat([]))
    monkeypatch.setattr(forward, '_round', lambda *_, **__: next(rounds))
    assert named(search, missing, lambda *_: None).chosen is enough


@pytest.mark.parametrize('in_vain', [True, False])
def test_a_third_effect_is_not_sought_where_that_is_in_vain(in_vain, monkeypatch):
    search = searching(too_quiet(seen(P)), ())
    refit = search.refit()
    missing, first, second = (
        replace(refit, effects=effects, by_segment=times * refit.by_segment)
        for effects, times in (((), 9.0), (('dead_time',), 5.0),
                               (('dead_time', 'chamber_leak'), 3.0)))
    rounds = iter([[first], [second], []])
    monkeypatch.setattr(forward, '_round', lambda *_, **__: next(rounds))
    asked = []

    def beyond(tried):
        asked.append(tried.chosen.effects)
        return in_vain

    assert named(search, missing, lambda *_: None, beyond).chosen is second
    assert asked == [second.effects]
    assert len(list(rounds)) == in_vain


def test_of_two_missing_effects_the_one_that_fits_where_it_was_fitted_leads(monkeypatch):
    """With one of two effects, a model may go far astray in a segment it was not fitted to."""
    search = searching(too_quiet(seen(P)), ())
    refit = search.refit()
    rows = refit.problem.rows_counted()
    missing, astray, idle = (
        replace(refit, effects=effects, by_segment=left * refit.by_segment,
                fit=replace(refit.fit, cost=cost * rows))
        for effects, left, cost in (
            ((), 300.0, 500.0), (('supply_ripple',), 3000.0, 4.0), (('seat_load',), 285.0, 480.0)))
    parents = []

    def one_round(_, parent, *args, **options):
        parents.append(parent)
        return [idle, astray] if parent is missing else []

    monkeypatch.setattr(forward, '_round', one_round)
    named(search, missing, lambda *_: None)
    assert parents == [missing, astray]


def searched(plant, names):
    """Return what a search among these effects makes of 80 s of steps."""
    return selected(searching(steps_seen(plant, STEPS, 1.7e5, seed=5), names))


def test_an_effect_that_noise_could_be_is_seen_through_it():
    """Its excess over the noise is less than what the level of noise is known to."""
    names = ('chamber_leak', 'spring_nonlinearity', 'ep_hysteresis')
    tried = searched(put(P, 'actuator.spring_bend', 80.0), names)
    assert 1.03 < tried.refit.misfit < NEAR_NOISE
    assert tried.chosen.effects == ('spring_nonlinearity',)
    assert tried.chosen.fit.parameters.actuator.spring_bend == pytest.approx(80.0, rel=0.3)
    assert searched(P, names).chosen.effects == ()


def test_what_thinned_rows_blur_is_seen_on_every_row_before_more_is_added():
    """The shift of a jump between two rows eight apart looks like something still missing."""
    time = np.arange(0.0, 80.0, 0.01)
    current = 1e-4 * (3.95 + 1.5 * (STEPS - 3.95))[(time // 5.0).astype(int)]
    late = seen(put(P, 'ep_converter.dead_time', 0.153), None, 1.7e5, current, 5, time)
    tried = selected(searching(late, ('dead_time', 'position_sensor_lag', 'spring_nonlinearity')))
    assert tried.chosen.effects == ('dead_time',)
    assert tried.held_out.misfit < 1.1


@pytest.mark.parametrize('time_constant', [1200.0, 6000.0])
def test_a_drift_that_has_hardly_begun_is_one_though_its_size_may_be_any(time_constant):
    """After 80 s of 6000 s its size is at its bound, 25 Pa/s are as sure as ever."""
    size = 25.0 * time_constant
    plant = put(put(P, 'ep_converter.drift', size), 'ep_converter.drift_time_constant',
                time_constant)
    tried = searched(plant, ('ep_drift', 'chamber_leak'))
    assert tried.chosen.effects == ('ep_drift',)
    assert tried.chosen.misfit < 1.1
    found = tried.chosen.fit.parameters.ep_converter
    slope = found.drift / found.drift_time_constant
    assert slope == pytest.approx(25.0, rel=0.1)
