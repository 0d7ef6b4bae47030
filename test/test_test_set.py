# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What of a verdict stands in the locked part."""

from dataclasses import replace

from made_task import P, RAMPS, RAMPS_TIME, searching, seen, standing_at
import numpy as np
import pytest

from booster_ros.diagnosis import diagnose, last_fit, locked_part
from booster_ros.diagnosis.data.blocks import USED, rows_of, split
from booster_ros.diagnosis.estimation.problem import Fit
from booster_ros.diagnosis.estimation.parametrisation import put
from booster_ros.diagnosis.judging.test_set import EXPLAINS_LITTLE, leave_much, stands
from booster_ros.diagnosis.result import ChannelError, errors_of
from booster_ros.diagnosis.searching.nameless import TOO_LITTLE
from booster_ros.diagnosis.searching.selection import Tried
from booster_ros.diagnosis.hypotheses.discrepancy import UNNAMED, Term, with_term
from booster_ros.model.discrepancy import KNOTS, STEM, VALVE_POSITION, Discrepancy

WAVE = 150.0 * np.sin(np.linspace(0.0, 15.0, KNOTS))


def waving(sign=1.0, current=RAMPS):
    """Return what is seen of a spring whose force goes up and down along the travel."""
    table = Discrepancy(
        STEM, VALVE_POSITION, tuple(np.linspace(0.0, 0.016, len(WAVE))), tuple(sign * WAVE))
    return seen(P._replace(discrepancy=table), None, 1.7e5, current, 4, RAMPS_TIME)


def concluded(search, *chosen, fault=''):
    """Return the diagnosis where these were chosen, a term of the spring competing with them."""
    refit = search.refit()
    tried = Tried(refit, (*chosen, refit)[0], (refit, *chosen), dict.fromkeys(
        (frozenset(one.effects) for one in (refit, *chosen)), ''))
    one = Term(STEM, VALVE_POSITION, 200.0)
    rows, _ = search.rows_and_experiment(USED, search.thinning)
    joint = with_term(refit.problem, refit.fit, one, rows)
    term = replace(search.rate((UNNAMED + one.label,), joint, joint.fit()), fault=fault)
    return diagnose._conclude(search, tried, [term], ())


def bent_in(experiment):
    """Return a search and the model with a bent spring, fitted to the parts that are not locked."""
    search = searching(experiment, ('spring_nonlinearity',))
    begun = standing_at(search, ('spring_nonlinearity',), {'actuator.spring_bend': 100.0})
    return search, search.on_both(begun, 1)


def with_another_end(experiment, end):
    """Return the experiment with the locked part of another one."""
    locked = rows_of(split(experiment.time, experiment.current), ('test',), len(experiment.time))
    return replace(experiment, measured={
        name: np.where(locked, end.measured[name], values)
        for name, values in experiment.measured.items()})


def errors(before, after):
    return {name: ChannelError('Pa', before, before, value, 1.0)
            for name, value in zip(('chamber_pressure', 'valve_position'), after)}


@pytest.mark.parametrize(('before', 'after', 'stays', 'much'), [
    (10.0, (10.4, 10.4), True, True),
    (10.0, (10.4, 11.0), False, True),
    (10.0, (4.0, 4.0), True, False),
    (10.0, (3.0, 6.0), True, True),
    (1.0, (1.04, 1.04), True, False),
    (1.0, (1.5, 1.5), False, False),
    (1.0, (1.8, 1.8), False, True),
    (10.0, (np.nan, 1.0), False, True),
])
def test_how_much_may_be_left(before, after, stays, much):
    assert stands(errors(before, after)) == stays
    assert leave_much(errors(before, after)) == much


def test_a_run_that_was_lost_on_the_way_is_no_small_error():
    experiment = waving()
    run = {name: np.where(np.arange(len(values)) < 100, values, np.nan)
           for name, values in experiment.measured.items()}
    rows = np.ones(len(experiment.time), dtype=bool)
    runs = {'declared': run, 'before': experiment.measured, 'after': run}
    lost = errors_of(experiment, runs, rows)
    assert not any(np.isfinite(error.after) for error in lost.values())


@pytest.mark.parametrize('stays', [True, False])
def test_a_term_that_the_locked_part_speaks_against_is_not_in_the_model(stays):
    """It was there as long as was looked, and the other way round when that part came."""
    experiment = waving() if stays else with_another_end(waving(), waving(-1.0))
    found = concluded(searching(experiment, ()))
    assert found.verdict == 'unknown'
    assert [effect.location for effect in found.effects] == ['stem']
    assert found.added == stays == (found.refused is None)
    assert found.decided != stays
    if stays:
        assert found.after.discrepancy.location == STEM
        return
    assert found.after == found.before
    assert found.unknown is None
    assert found.suspects[0].reason.startswith('does not stand')
    assert found.refused.beyond < 0.05
    for name, error in found.held_out.items():
        assert error.after == error.before
        assert found.refused.error[name] > error.before


def test_a_refused_term_says_how_much_of_the_locked_part_goes_beyond_it():
    locked = rows_of(split(RAMPS_TIME, RAMPS), ('test',), len(RAMPS_TIME))
    further = np.where(locked, RAMPS + 0.2e-4, RAMPS)
    straight_on = waving(1.0, further)
    experiment = with_another_end(straight_on, waving(-1.0, further))
    position = straight_on.measured['valve_position']
    locked = rows_of(split(RAMPS_TIME, further), ('test',), len(RAMPS_TIME))
    beyond = np.mean(position[locked] > position[~locked].max())
    assert 0.1 < beyond < 0.9
    found = concluded(searching(experiment, ()))
    assert found.refused.beyond == pytest.approx(beyond, abs=0.1)


@pytest.mark.parametrize('much', [True, False])
def test_a_term_that_explains_too_little_tells_where_much_is_missing(monkeypatch, much):
    monkeypatch.setattr(last_fit, 'explains', lambda *_: False)
    found = concluded(searching(waving() if much else seen(
        P, None, 1.7e5, RAMPS, 4, RAMPS_TIME), ()))
    assert (found.added, found.decided, found.unknown) == (False, False, None)
    assert found.after == found.before
    fate, = (one.reason for one in found.suspects
             if one.effects == ('unknown: stem over valve_position',))
    assert fate == 'fitted to all but the locked part, it explains too little'
    if not much:
        assert (found.verdict, found.effects, found.refused) == ('none', (), None)
        return
    assert found.verdict == 'unknown'
    assert [effect.location for effect in found.effects] == ['stem']
    assert (found.refused.location, found.refused.error) == ('stem', None)


def test_a_term_that_only_comes_nearest_tells_the_place_and_is_not_in_the_model():
    found = concluded(searching(waving(), ()), fault=TOO_LITTLE)
    assert (found.verdict, found.added, found.unknown) == ('unknown', False, None)
    assert [effect.location for effect in found.effects] == ['stem']
    assert found.refused.error is None
    assert found.after == found.before


@pytest.mark.parametrize('kept', [True, False])
def test_what_a_refused_term_displaced_has_to_explain_what_is_missing(monkeypatch, kept):
    search, bent = bent_in(seen(put(P, 'actuator.spring_bend', 400.0), None, 1.7e5, RAMPS, 4,
                                RAMPS_TIME) if kept else waving())
    monkeypatch.setattr(locked_part, 'stands', lambda errors: False)
    monkeypatch.setattr(last_fit, 'preferable', lambda unnamed, tried: True)
    found = concluded(search, bent)
    if kept:
        assert (found.verdict, [one.name for one in found.effects]) == (
            'effect', ['spring_nonlinearity'])
        return
    assert (found.verdict, found.added) == ('unknown', False)
    assert found.after == found.before
    (fate,) = [one.reason for one in found.suspects if one.effects == bent.effects]
    assert fate == EXPLAINS_LITTLE


@pytest.mark.parametrize('case', ['little', 'little held back', 'sticking'])
def test_names_that_explain_little_give_way_to_a_term(monkeypatch, case):
    """Unless one of the two parts says otherwise, or the stem sticks."""
    search, bent = bent_in(waving())
    if case == 'little held back':
        bent = replace(bent, by_segment=bent.by_segment / bent.misfit)
    if case == 'sticking':
        monkeypatch.setattr(Fit, 'sticks', True)
    monkeypatch.setattr(last_fit, 'preferable', lambda unnamed, tried: not tried.chosen.effects)
    found = concluded(search, bent)
    assert found.verdict == ('unknown' if case == 'little' else 'effect')
    assert found.decided == (case == 'little')
    if case == 'little':
        assert found.after.discrepancy.location == STEM
