# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""When a term without a name is the verdict."""

from dataclasses import replace

from made_diagnosis import DECLARED, record_of, timed_columns, unknown_found
from made_task import P, searching, seen
import numpy as np
import pytest

from booster_ros.diagnosis.pipeline import _best_without
from booster_ros.diagnosis.data.experiment import rmse
from booster_ros.diagnosis.data.blocks import USED, rows_of, split
from booster_ros.diagnosis.hypotheses.applicable import free_to_refit
from booster_ros.diagnosis.estimation.problem import Fit, Problem
from booster_ros.diagnosis.estimation.parametrisation import declared_freedom
from booster_ros.diagnosis.last_fit import _without
from booster_ros.diagnosis.prepare.preparation import prepare
from booster_ros.diagnosis.searching.candidate import (
    Candidate, clearly_better, explains, why_dropped)
from booster_ros.diagnosis.searching.nameless import (
    _best_on_both, as_good, beyond_names, compete, over_time, preferable, term_alone)
from booster_ros.diagnosis.searching.search import Search
from booster_ros.diagnosis.searching.selection import Tried
from booster_ros.diagnosis.hypotheses.discrepancy import UNNAMED, terms, with_term
from booster_ros.model import discrepancy as term
from booster_ros.report.html_report import html_page
from booster_ros.report.provenance import Provenance
from booster_ros.report.unknown_term import unknown_rivals
from booster_ros.report.wording import verdict_sentences

SAMPLES = 1000
DRIFTING = UNNAMED + 'ep_converter over time'


STICKING = DECLARED._replace(actuator=DECLARED.actuator._replace(coulomb_friction=200.0))


def scored(effects, *by_segment, parameters=DECLARED):
    """Return a model that scored so, in units of the noise, on segments of equal length."""
    each = SAMPLES / len(by_segment)
    fit = Fit((), np.zeros(0), parameters, None, 0.0, np.zeros((0, 0)))
    return Candidate(effects, None, fit, each * np.array(by_segment), 0.0, SAMPLES)


def tried(named):
    refit = scored((), 40.0, 40.0, 40.0, 40.0)
    return Tried(refit, named, (refit, named), {})


UNEVEN = scored((DRIFTING,), 1.0, 14.0, 1.0, 14.0)


@pytest.mark.parametrize(('named', 'wins'), [
    (scored(('ep_drift', 'seat_load'), 9.0, 9.0, 9.0, 9.0), True),
    (scored(('ep_drift',), 9.0, 9.0, 9.0, 9.0), True),  # it explains 31 of 39
    (scored(('ep_drift', 'seat_load'), 7.0, 7.0, 7.0, 7.0), False),
    (scored(('ep_drift',), 8.5, 8.5, 8.5, 8.5), False),  # 7.5 of 39 is little
])
def test_names_that_leave_structure_give_way_to_a_term_that_leaves_less(named, wins):
    assert not clearly_better(UNEVEN, named)
    assert preferable(UNEVEN, tried(named)) is wins


def test_the_commoner_kind_leads_only_where_scores_are_nearly_the_same():
    best = scored((UNNAMED + 'supply over time',), 2.0, 2.0, 2.0, 2.0)
    near = scored((DRIFTING,), 2.05, 2.05, 2.05, 2.05)
    unsteady = scored((UNNAMED + 'chamber over stem_velocity',), 0.0, 0.0, 0.0, 12.0)
    worse = scored((UNNAMED + 'booster over booster_force',), 6.0, 6.0, 6.0, 6.0)
    assert as_good([near, unsteady, worse, best], best) == [near, best, unsteady]
    assert as_good([unsteady, best], best) == [best, unsteady]


def test_what_learnt_the_held_back_segments_is_no_measure_of_what_did_not():
    refit, named = scored((), 50.0, 1.0), scored(('seat_load',), 1.2, 1.1)
    taught, refit_taught = (replace(one, learnt=True, by_segment=SAMPLES / 2 * np.array(misfits))
                            for one, misfits in ((named, (1.0, 1.0)), (refit, (1.4, 1.1))))
    everything = (refit, named, taught, refit_taught)
    both = Tried(refit, taught, everything, {})
    assert both.held_out is named
    assert _best_without((), both.held_out, both) is refit
    only = Tried(refit, taught, (refit, taught, refit_taught), {})
    assert _best_without((), only.held_out, only) is refit_taught


def test_one_over_time_stands_behind_one_over_a_state_that_does_as_well():
    best = scored((UNNAMED + 'chamber over valve_position',), 2.0, 2.0, 2.0, 2.0)
    near = scored((DRIFTING,), 2.05, 2.05, 2.05, 2.05)
    assert as_good([near, best], best) == [best, near]
    assert as_good([near, best], near) == [best, near]


def test_one_over_time_stands_behind_also_where_all_segments_count(monkeypatch):
    refit = searching(seen(P), ()).refit()
    rows = refit.problem.observed
    left = {(): 9.0, (DRIFTING,): 1.0, (UNNAMED + 'chamber over valve_position',): 1.02}

    def on_both(_, one, factor):
        return replace(refit, effects=one.effects, fit=replace(
            refit.fit, cost=left[one.effects] * rows))

    monkeypatch.setattr(Search, 'on_both', on_both)
    drifting, moving = (scored(effects, 2.0) for effects in list(left)[1:])
    found = _best_on_both(searching(seen(P), ()), scored((), 2.0), [drifting, moving])
    assert [one.effects for one in found] == [moving.effects, drifting.effects]


def test_several_effects_that_leave_little_do_not_give_way():
    named = scored(('ep_drift', 'seat_load'), 2.5, 2.5, 2.5, 2.5)
    unnamed = scored((DRIFTING,), 1.0, 3.6, 1.0, 3.6)
    assert not preferable(unnamed, tried(named))
    assert preferable(scored((DRIFTING,), 1.0, 1.1, 1.0, 1.1), tried(named))


def test_a_fault_of_its_own_is_why_a_model_was_dropped_before_any_comparison():
    chosen = scored(('ep_drift',), 2.0, 2.0, 2.0, 2.0)
    more = scored(('ep_drift', 'seat_load'), 1.9, 1.9, 1.9, 1.9)
    assert 'does not lower the held-back error' in why_dropped(more, chosen)
    assert why_dropped(replace(more, fault='its size is not told from none'), chosen) == (
        'its size is not told from none')
    assert why_dropped(scored(('seat_load',), 8.0, 8.0, 8.0, 8.0), chosen) == (
        '4 times the squared error of the choice')
    assert why_dropped(scored(('seat_load',), 2.0, 2.1, 2.0, 2.1), chosen) == (
        'not told apart from the choice by this record')


def test_what_shows_where_slips_do_not_decide_need_not_lower_the_score():
    friction = scored(('stem_friction',), 6.0, 7.0, 6.0, 7.0)
    leak = scored(('stem_friction', 'chamber_leak'), 7.0, 6.0, 8.0, 7.0)
    assert not clearly_better(leak, friction)
    lasts = replace(leak, lasting=frozenset({'chamber_leak'}))
    assert clearly_better(lasts, friction)
    assert not clearly_better(lasts, leak)
    assert why_dropped(friction, lasts) == (
        'without chamber_leak more is left of what no slip explains')


def test_friction_that_does_not_differ_along_the_travel_stays_friction():
    bent = scored(('chamber_leak', 'position_dependent_friction'), 1.15, 1.15, 1.15, 1.15)
    plain = scored(('stem_friction', 'chamber_leak'), 1.22, 1.22, 1.22, 1.22)
    leak = scored(('chamber_leak',), 28.0, 28.0, 28.0, 28.0)
    models = Tried(leak, bent, (leak, bent, plain), {})
    assert _without(models, 'position_dependent_friction', 'not told from none').chosen is plain
    assert _without(replace(models, chosen=plain), 'stem_friction', 'none').chosen is leak


def test_what_is_held_out_is_the_best_fit_that_did_not_learn_from_it():
    stuck = scored(('stem_friction',), 24.0, 24.0, 24.0, 24.0)
    found = scored(('stem_friction',), 1.1, 1.1, 1.1, 1.1)
    taught = replace(scored(('stem_friction',), 1.0, 1.0, 1.0, 1.0), learnt=True)
    for order in ((stuck, taught, found), (taught, found, stuck)):
        assert Tried(stuck, taught, order, {}).held_out is found


@pytest.mark.parametrize(('before', 'after', 'explained'), [
    (3000.0, 2350.0, True),  # a third of the 2000 that noise does not cost
    (3000.0, 2450.0, False),
    (1000.0, 940.0, True), (1000.0, 960.0, False),  # where all is noise: a twentieth
])
def test_what_is_added_has_to_explain_what_matters(before, after, explained):
    without, with_it = (
        Fit((), np.zeros(0), DECLARED, None, cost, np.zeros((0, 0))) for cost in (before, after))
    assert explains(with_it, without, SAMPLES) is explained


def test_where_no_name_was_found_a_term_is_the_verdict():
    refit = scored((), 40.0, 40.0, 40.0, 40.0)
    assert preferable(UNEVEN, Tried(refit, refit, (refit,), {}))


def test_a_term_that_leaves_far_less_than_several_effects_settles_it():
    several = scored(('ep_drift', 'seat_load'), 9.0, 9.0, 9.0, 9.0)
    term_over_time = scored((DRIFTING,), 2.0, 2.0, 2.0, 2.0)
    assert beyond_names([term_over_time], tried(several))
    assert not beyond_names([], tried(several))
    assert not beyond_names([scored((DRIFTING,), 6.0, 6.0, 6.0, 6.0)], tried(several))
    one = tried(scored(('ep_drift',), 9.0, 9.0, 9.0, 9.0))
    assert not beyond_names([term_over_time], one)
    assert beyond_names([scored((DRIFTING,), 1.1, 1.1, 1.1, 1.1)], one)
    nearly = tried(scored(('ep_drift',), 1.2, 1.2, 1.2, 1.2))
    assert not beyond_names([scored((DRIFTING,), 1.14, 1.14, 1.14, 1.14)], nearly)


def test_terms_compete_where_named_effects_leave_much_of_what_was_there():
    assert compete(tried(scored(('ep_drift',), 4.0, 4.0, 4.0, 4.0)))
    assert not compete(tried(scored(('ep_drift',), 2.0, 2.0, 2.0, 2.0)))  # 1 of 39
    quiet = scored((), 2.0, 2.0, 2.0, 2.0)
    assert compete(Tried(quiet, quiet, (quiet,), {}))
    for left, parameters, competing in (
            (1.4, DECLARED, True), (1.1, DECLARED, False), (1.4, STICKING, False)):
        named = scored(('ep_drift',), left, left, left, left, parameters=parameters)
        assert compete(Tried(quiet, named, (quiet, named), {})) is competing


def test_of_several_effects_nothing_but_noise_is_to_be_left():
    """Two bent lines nearly make a leak that opens with travel."""
    quiet = scored((), 2.6, 2.6, 2.6, 2.6)
    for left, competing in ((1.36, True), (1.1, False)):
        both = scored(('opening_nonlinearity', 'ep_nonlinearity'), left, left, left, left)
        assert compete(Tried(quiet, both, (quiet, both), {})) is competing


def test_several_are_held_to_noise_however_much_they_explain_but_where_the_stem_sticks():
    """Drift, hysteresis and a ripple nearly make a converter that creeps."""
    left = (2.0, 2.0, 2.0, 2.0)  # 1 of 39
    assert compete(tried(scored(('ep_drift', 'ep_hysteresis'), *left)))
    assert not compete(tried(scored(('ep_drift', 'stem_friction'), *left, parameters=STICKING)))


def test_a_table_ends_where_the_rows_end_that_it_was_fitted_to():
    experiment = prepare(record_of(timed_columns()), DECLARED)
    rows = experiment.time < 0.6 * experiment.time[-1]
    free = tuple(declared_freedom(DECLARED, experiment))
    problem = Problem(experiment, rows, DECLARED, free)
    over_time = next(one for one in terms(experiment.channels) if one.variable == term.TIME)
    joint = with_term(problem, problem.at(problem.start()), over_time, rows)
    table = joint.base.discrepancy
    spacing = table.knots[-1] - table.knots[-2]
    assert table.knots[-1] <= experiment.time[rows][-1] + spacing
    assert table.knots[0] <= experiment.time[0]


def test_a_table_covers_what_was_measured_and_not_where_a_model_without_it_stays():
    """Also between the fitted rows: beyond its range it is zero, and what follows would suffer."""
    columns = timed_columns()
    columns['valve_position'] *= 1.5
    experiment = prepare(record_of(columns), DECLARED)
    measured = experiment.measured['valve_position']
    rows = measured < np.median(measured)
    free = tuple(declared_freedom(DECLARED, experiment))
    problem = Problem(experiment, rows, DECLARED, free)
    over_travel = next(one for one in terms(experiment.channels)
                       if one.label == 'chamber over valve_position')
    joint = with_term(
        problem, problem.at(problem.start()), over_travel, np.ones(len(rows), dtype=bool))
    table = joint.base.discrepancy
    spacing = np.diff(table.knots)
    assert spacing == pytest.approx(spacing[0])
    assert term.covered(table) == pytest.approx(
        (measured.min(), measured.max()), abs=0.5 * spacing[0])


def test_a_term_over_time_leaves_the_rest_of_the_model_as_it_is_at_any_other_time():
    """Fitted together, the gain of the E/P converter would follow what the supply did once."""
    swell = np.r_[np.zeros(2), 6e3 * np.sin(np.linspace(0.0, np.pi, 6)), np.zeros(4)]
    plant = DECLARED._replace(discrepancy=term.Discrepancy(
        term.SUPPLY, term.TIME, tuple(np.linspace(0.0, 60.0, 12)), tuple(swell)))
    experiment = prepare(record_of(timed_columns(plant)), DECLARED)
    search = Search(experiment, split(experiment.time, experiment.current), DECLARED,
                    free_to_refit(DECLARED, experiment))
    refit = search.refit()
    thin = refit.problem
    in_supply = next(one for one in terms(experiment.channels) if one.label == 'supply over time')
    seen, _ = search.rows_and_experiment(USED, search.thinning)
    joint = with_term(thin, thin.at(refit.fit.z), in_supply, seen)
    candidate = search.rate((UNNAMED + in_supply.label,), joint, joint.fit(evaluations=8))
    assert over_time(candidate)
    assert not over_time(refit)
    gain = DECLARED.ep_converter.gain
    assert abs(candidate.fit.parameters.ep_converter.gain / gain - 1.0) > 1e-4
    _, fit = term_alone(search, candidate, refit.fit)
    table = fit.parameters.discrepancy
    assert fit.parameters == refit.fit.parameters._replace(discrepancy=table)
    assert (table.location, table.variable) == (term.SUPPLY, term.TIME)
    used = rows_of(search.segments, USED, len(experiment.time))
    left = [rmse(experiment.measured['chamber_pressure'],
                 experiment.predict(one.parameters, one.initial)['chamber_pressure'], used)
            for one in (refit.fit, fit)]
    assert left[1] < 0.5 * left[0]


def test_terms_that_do_as_well_are_said():
    found = unknown_found()
    assert unknown_rivals(found) == []
    effect = replace(found.effects[0], confused_with=('supply over time',))
    rivalled = replace(found, effects=(effect,))
    said = 'A term in supply over time explains this record as well.'
    assert said in verdict_sentences(rivalled)
    assert said in html_page(rivalled, Provenance('valve.csv', 'declared.yaml', ''))
