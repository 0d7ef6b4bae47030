# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parts of the diagnosis on small made records: starts, sweeps, lines in a residual, cascades."""

from dataclasses import replace
import itertools

from made_diagnosis import BENT, DECLARED, record_of, timed_columns, unknown_found
from made_search import (
    CURRENT, P, RAMPS, RAMPS_TIME, TIME, searching, seen, standing_at, steps_seen)
import numpy as np
import pytest

from booster_ros.diagnosis import diagnose
from booster_ros.diagnosis.experiment.segments import USED
from booster_ros.diagnosis.fitting.fit import START, Problem
from booster_ros.diagnosis.fitting.freedom import declared_freedom, put
from booster_ros.diagnosis.fitting.intervals import interval_of
from booster_ros.diagnosis.last_fit import _without, last_fit, verdict_of
from booster_ros.diagnosis.preparing.preparation import prepare
from booster_ros.diagnosis.result import UnknownTerm
from booster_ros.diagnosis.searching import forward
from booster_ros.diagnosis.searching.backward import _backward, compared
from booster_ros.diagnosis.searching.candidate import NEAR_NOISE, gain, preferred_first, told_apart
from booster_ros.diagnosis.searching.cascade import (
    above_the_stem, as_seen_above, shows_above_the_stem)
from booster_ros.diagnosis.searching.forward import named
from booster_ros.diagnosis.searching.nameless import best_terms, compete, preferable
from booster_ros.diagnosis.searching.rematch import _by_slips, _plainest_above, rematch
from booster_ros.diagnosis.searching.screening import (
    references, screen, strong_frequencies, with_effect)
from booster_ros.diagnosis.searching.selection import Tried
from booster_ros.diagnosis.searching.teaching import most_by_noise, taught
from booster_ros.diagnosis.searching.unknown import UNNAMED, terms, with_term
from booster_ros.diagnosis.validation import validated
from booster_ros.model.catalogue import EFFECTS
from booster_ros.model.discrepancy import (
    CHAMBER, KNOTS, STEM, TIME as OVER_TIME, Discrepancy)
from booster_ros.model.memory import Departure
from booster_ros.model.simulation import simulate


def everywhere(experiment):
    return np.ones(len(experiment.time), dtype=bool)


def test_a_converter_that_starts_at_the_edge_of_its_play_is_found_there():
    width = 6e-6
    plant = P._replace(ep_converter=P.ep_converter._replace(hysteresis=width))
    experiment = seen(plant, Departure(ep_play=1.0))
    free = with_effect(Problem(experiment, everywhere(experiment), P, ()),
                       EFFECTS['ep_hysteresis'])
    begin = free.start()
    begin[0] = 1.0
    fit = free.fit(begin)
    assert fit.parameters.ep_converter.hysteresis == pytest.approx(width, rel=0.05)
    assert fit.initial.departure.ep_play == pytest.approx(1.0, abs=0.1)
    assert fit.cost < 1.1 * free.rows_counted()


def test_a_start_without_play_warmth_or_past_costs_no_simulation_and_stays_free_of_data():
    experiment = seen(P)
    problem = Problem(experiment, everywhere(experiment), P, tuple(declared_freedom(P, experiment)))
    places = problem.at(problem.start()).jacobian[:, -4:]
    assert np.count_nonzero(places) == 4
    assert np.abs(places[-4:]) == pytest.approx(np.diag(1.0 / START[-4:]))


def test_play_of_the_position_reading_starts_where_it_was_left():
    plant = P._replace(sensors=P.sensors._replace(position_backlash=4e-4))
    high, low = (simulate(plant, TIME, CURRENT, {'chamber_pressure': 2e5},
                          departure=Departure(position_play=place)) for place in (1.0, -1.0))
    apart = high['measured_valve_position'][0] - low['measured_valve_position'][0]
    assert apart == pytest.approx(4e-4)
    assert high['valve_position'][0] == low['valve_position'][0]


def test_frequencies_are_sought_in_the_fitted_rows_alone():
    problem = searching(seen(P), ()).problem()
    time = problem.experiment.time
    for rows, is_there in ((problem.rows, True), (~problem.rows, False)):
        pressure = problem.experiment.measured['chamber_pressure'].copy()
        pressure[rows] += 3e3 * np.sin(2.0 * np.pi * 1.37 * time[rows])
        shaken = replace(problem, experiment=replace(
            problem.experiment, measured={**problem.experiment.measured,
                                          'chamber_pressure': pressure}))
        found = strong_frequencies(shaken, problem.start())
        assert bool(np.any(np.abs(found - 1.37) < 0.1)) == is_there


def test_the_line_of_a_rippling_supply_stands_out_of_noise():
    plant = P._replace(supply=P.supply._replace(ripple=6e3, ripple_frequency=0.7))
    experiment = seen(plant)
    problem = Problem(experiment, everywhere(experiment), P, ())
    assert np.min(np.abs(strong_frequencies(problem, problem.start()) - 0.7)) < 0.05


@pytest.mark.parametrize('bins', [21.0, 21.4, 21.5])
def test_a_ripple_far_below_the_typical_size_is_screened_as_what_it_is(bins):
    """Its frequency lies where it will between those that the record's length resolves."""
    frequency, ripple = bins / TIME[-1], 250.0
    plant = P._replace(supply=P.supply._replace(ripple=ripple, ripple_frequency=frequency))
    experiment = seen(plant)
    problem = Problem(experiment, everywhere(experiment), P, ())
    found = strong_frequencies(problem, problem.start())
    assert np.min(np.abs(found - frequency)) < 0.2 / TIME[-1]
    around = references(problem, problem.at(problem.start()))
    quick = screen(problem, around, 'supply_ripple', found)
    without = float(np.sum(problem.residuals(problem.start())**2))
    noise = problem.rows_counted()
    assert quick.cost - noise < 0.15 * (without - noise)
    sizes = dict(zip((f.knob.parameter for f in quick.problem.freedoms), quick.starts[0]))
    free = {f.knob.parameter: f for f in quick.problem.freedoms}
    assert free['supply.ripple'].value(sizes['supply.ripple']) == pytest.approx(ripple, rel=0.1)


def test_the_frequency_of_a_ripple_is_that_of_the_clock_where_thinned_rows_are_uneven():
    """Steps in one half keep rows that a slow ramp in the other does not."""
    time = np.arange(0.0, 120.0, 0.01)
    rng = np.random.default_rng(1)
    steps = rng.uniform(3.7e-4, 4.3e-4, 61)[time.astype(int) // 2 * 2 % 61]
    current = np.where(time < 60.0, steps, np.interp(time, [60.0, 120.0], [3.8e-4, 4.2e-4]))
    plant = P._replace(supply=P.supply._replace(ripple=3e3, ripple_frequency=0.613))
    thin, kept = seen(plant, current=current, time=time).thinned(8)
    assert np.ptp(np.diff(kept)) >= 7
    problem = Problem(thin, everywhere(thin), P, ())
    found = strong_frequencies(problem, problem.start())
    assert np.min(np.abs(found - 0.613)) < 0.2 / time[-1]


def test_a_ripple_that_stands_still_is_none():
    """Zero is in the range of its frequency."""
    still = P._replace(supply=P.supply._replace(ripple=2e3, ripple_frequency=0.0))
    predicted = seen(P).predict(still)['chamber_pressure']
    assert np.isfinite(predicted).all()


def test_above_the_stem_friction_does_not_matter_but_a_leak_shows():
    rubbing = P._replace(actuator=P.actuator._replace(coulomb_friction=400.0, stiction=150.0))
    leaking = rubbing._replace(actuator=rubbing.actuator._replace(leak_area=4e-8))

    def misfit(plant, model):
        above = above_the_stem(seen(plant))
        assert set(above.measured) == {'chamber_pressure'}
        predicted = above.predict(model)['chamber_pressure']
        difference = above.measured['chamber_pressure'] - predicted
        return float(np.mean((difference[200:] / 150.0) ** 2))  # without the first rush

    settled = seen(rubbing)
    whole = settled.predict(P)['chamber_pressure'] - settled.measured['chamber_pressure']
    blurred = np.mean((whole[200:] / 150.0) ** 2)
    blameless = misfit(rubbing, P)
    assert blameless < blurred / 20.0
    assert misfit(leaking, P) > 20.0 * blameless


def test_a_record_without_position_has_nothing_above_its_stem():
    experiment = seen(P)
    del experiment.measured['valve_position']
    assert above_the_stem(experiment) is None


@pytest.mark.parametrize(('effect', 'shows'), [
    ('supply_droop', True), ('chamber_leak', True), ('pressure_sensor_lag', True),
    ('stem_friction', False), ('position_backlash', False)])
def test_effects_above_the_stem(effect, shows):
    assert shows_above_the_stem(effect) is shows


def test_a_term_asked_for_what_it_has_not_seen_is_said():
    found = unknown_found()
    within = prepare(record_of(timed_columns(BENT, seed=2)), DECLARED)
    assert validated(found, within).notes == found.notes

    narrow = UnknownTerm(found.unknown.table._replace(low=0.004, high=0.010))
    notes = validated(replace(found, unknown=narrow), within).notes
    seen = within.measured['valve_position']
    share = np.mean((seen < narrow.knots[1]) | (seen > narrow.knots[-2]))
    assert notes[-1].startswith(f'{100.0 * share:.0f} % of the other record lies beyond the valve_')


def test_what_drove_the_other_record_and_is_compared_in_it_is_said_where_it_is_not_the_same():
    found = unknown_found()
    columns = timed_columns(BENT, seed=2)
    del columns['control_current']
    said = validated(found, prepare(record_of(columns), DECLARED)).notes[len(found.notes):]
    assert said == (
        'the other record is driven by chamber_pressure and compared in valve_position, the first '
        'is driven by control_current and compared in chamber_pressure and valve_position',)


def test_what_goes_by_time_since_the_record_began_is_said_of_the_other_record():
    found = unknown_found()
    another = prepare(record_of(timed_columns(BENT, seed=2)), DECLARED)
    swinging = found.after._replace(supply=found.after.supply._replace(ripple=2e3))
    said = set(validated(replace(found, after=swinging), another).notes) - set(found.notes)
    assert sum('the other record is judged as if it began like the first' in one
               for one in said) == 1


def test_a_seat_fully_open_in_the_other_record_alone_is_said():
    found = unknown_found()
    columns = timed_columns(BENT, seed=2)
    assert validated(found, prepare(record_of(columns), DECLARED)).notes == found.notes

    columns['control_current'] = np.where(columns['time'] < 30.0, 0.46e-3, 0.36e-3)
    run = simulate(BENT, columns['time'], columns['control_current'], {'chamber_pressure': 230e3})
    columns |= {name: run[name] for name in ('chamber_pressure', 'valve_position')}
    notes = validated(found, prepare(record_of(columns), DECLARED)).notes
    assert sum('has the exhaust open as far as it goes' in note for note in notes) == 1
    assert not any('has the intake open' in note for note in notes)

    del columns['control_current']  # then nothing says how far the booster is open
    assert not any('open as far as it goes' in note
                   for note in validated(found, prepare(record_of(columns), DECLARED)).notes)


def selected(search):
    return compared(search, named(search, search.refit(), lambda *_: None), lambda *_: None)


# 0.1 mA; one step opens the booster fully, in a select segment
ONE_LARGE_STEP = np.array(
    [4.3, 4.5, 4.3, 4.5, 3.4, 3.6, 3.8, 4.0, 4.2, 4.4, 4.3, 4.4, 4.3, 4.4, 4.3])


def test_what_only_the_select_segments_teach_is_nothing_missing():
    """One select segment needs the largest opening, no fit segment does: it is a little off."""
    plant = put(P, 'booster.max_area', 0.93 * P.booster.max_area)
    search = searching(steps_seen(plant, ONE_LARGE_STEP, 1.9e5, seed=4), ())
    assert next(s for s in search.segments if s.first <= 1001 < s.last).role == 'select'
    tried = selected(search)
    assert tried.refit.misfit > 1.3
    assert tried.chosen.effects == ()
    assert tried.chosen.misfit < 1.1
    assert best_terms(search, tried) == []


def test_an_effect_is_not_blamed_for_what_only_a_select_segment_teaches():
    """The same and a leak: alone it raises the error there, as the refit imitates both at once."""
    plant = put(put(P, 'booster.max_area', 0.93 * P.booster.max_area), 'actuator.leak_area', 1e-8)
    search = searching(steps_seen(plant, ONE_LARGE_STEP, 1.9e5, seed=4), ('chamber_leak',))
    tried = named(search, search.refit(), lambda *_: None)
    assert tried.chosen.effects == ('chamber_leak',)
    assert tried.chosen.misfit < 1.1
    assert tried.held_out.misfit > tried.refit.misfit
    assert tried.chosen.fit.parameters.actuator.leak_area == pytest.approx(1e-8, rel=0.2)


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


def test_what_few_select_segments_teach_is_noise_also_where_values_are_missing_unevenly():
    """A segment is judged by its own values: one without gaps has more than the average."""
    experiment = seen(P, current=CURRENT, seed=3)
    search = searching(experiment, ())
    refit = search.refit()
    assert taught(search, refit) is not None
    sparse = next(s for s in search.segments if s.role == 'select')
    for measured in experiment.measured.values():
        measured[sparse.first:sparse.last][np.arange(sparse.last - sparse.first) % 4 > 0] = np.nan
    refit = search.refit()
    assert search.values_held_back().min() < 0.5 * search.values_held_back().max()
    assert taught(search, refit) is not None


def too_quiet(experiment, share=0.6):
    """Return the experiment with noise that is said to be less than it is."""
    return replace(experiment, noise={
        name: share * level for name, level in experiment.noise.items()})


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


def test_terms_without_a_name_are_fitted_once_beside_a_choice(monkeypatch):
    search = searching(too_quiet(seen(P)), ())
    refit = search.refit()
    first, second = (Tried(refit, replace(refit, effects=(name,)), (refit,), {})
                     for name in ('dead_time', 'chamber_leak'))
    fitted = []

    def best_terms_of(_, tried):
        fitted.append(tried.chosen.effects[0])
        return [refit]

    monkeypatch.setattr(diagnose, 'best_terms', best_terms_of)
    monkeypatch.setattr(diagnose, 'beyond_names', lambda *_: True)
    for asked, end, expected in (
            (first, first, ['dead_time']), (first, second, ['dead_time', 'chamber_leak'])):
        def named_with(_search, _refit, _tell, beyond, asked=asked, end=end):
            beyond(asked)
            return end

        monkeypatch.setattr(diagnose, 'named', named_with)
        fitted.clear()
        assert diagnose._sought(search, refit, lambda *_: None) == (end, [refit])
        assert fitted == expected


def test_where_no_term_leaves_less_than_the_refit_none_is_a_candidate():
    search = searching(too_quiet(steps_seen(P, STEPS, 1.7e5, seed=5)), ())
    refit = search.refit()
    tried = Tried(refit, refit, (refit,), {})
    assert compete(tried)
    assert best_terms(search, tried) == []


def test_a_stem_that_shifts_in_the_course_of_time_lacks_something_in_the_stem():
    """A shift of the reading explains the position as well, but not the air that the stem moves."""
    wave = 200.0 * np.sin(np.linspace(0.0, 9.0, KNOTS))
    plant = P._replace(discrepancy=Discrepancy(STEM, OVER_TIME, -5.0, 125.0, tuple(wave)))
    search = searching(seen(plant, None, 1.7e5, RAMPS, 4, RAMPS_TIME), ())
    refit = search.refit()
    best = best_terms(search, Tried(refit, refit, (refit,), {}))[0]
    assert best.effects == ('unknown: stem over time',)
    assert best.misfit < 1.5 < 0.1 * refit.misfit


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


def test_a_model_that_is_lost_on_the_way_is_told_from_one_that_is_not_and_not_from_another():
    found = replace(searching(seen(P), ()).refit(), by_segment=np.full(6, 100.0), prior=0.0)
    lost = replace(found, by_segment=np.array([100.0, 100.0, np.inf, 100.0, 100.0, 100.0]))
    assert gain(lost, found) == (np.inf, 0.0)
    assert gain(found, lost) == (-np.inf, 0.0)
    assert gain(lost, lost) == (0.0, 0.0)
    assert told_apart(lost, found)
    assert not told_apart(found, lost)
    assert not told_apart(lost, lost)


def test_a_declared_term_that_gave_way_to_another_is_named():
    declared = P._replace(discrepancy=Discrepancy(STEM, values=(9.0,) * KNOTS))
    another = P._replace(discrepancy=Discrepancy(CHAMBER, values=(1e-6,) * KNOTS))
    assert diagnose._replaced(P, another) == diagnose._replaced(declared, declared) == ()
    (note,) = diagnose._replaced(declared, another)
    assert 'stem over time' in note


@pytest.mark.parametrize('reached', [None, 0, 700])
def test_a_model_that_cannot_run_scores_infinitely_however_far_it_came(reached):
    search = searching(seen(P), ())
    problem = search.problem()

    class Lost(Problem):
        def predict(self, z):
            if reached is None:
                return None
            late = np.arange(len(self.experiment.time)) >= reached
            return {name: np.where(late, np.nan, values)
                    for name, values in super().predict(z).items()}

    lost = Lost(problem.experiment, problem.rows, problem.base, problem.freedoms)
    assert search.rate((), lost, problem.at(problem.start())).score == np.inf


def test_what_was_dropped_from_the_other_record_is_said():
    found = unknown_found()
    another = prepare(record_of(timed_columns(BENT, seed=2)), DECLARED)
    notes = validated(found, another, ('rows 7 to 9, column time: dropped',)).notes
    assert notes[len(found.notes):] == ('the other record: rows 7 to 9, column time: dropped',)


STEPS = np.array([3.6, 4.0, 4.4, 4.1, 3.7, 3.5, 3.8, 4.2, 4.4, 4.2, 3.9, 3.6, 3.9, 4.3, 4.0, 3.7])


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


LEAKING = P._replace(actuator=P.actuator._replace(
    coulomb_friction=400.0, stiction=100.0, presliding_stiffness=1e7, leak_area=4e-8))
RUBBING = {'actuator.coulomb_friction': 400.0, 'actuator.stiction': 100.0,
           'actuator.stribeck_velocity': P.actuator.stribeck_velocity}


def test_what_lies_above_a_stem_that_sticks_is_taken_from_there():
    search = searching(seen(LEAKING), ())
    bent = standing_at(search, ('stem_friction', 'chamber_leak'), {
        **RUBBING, 'ep_converter.offset': 5e3, 'actuator.leak_area': 1e-8,
        'actuator.viscous_friction': 4000.0})
    z = as_seen_above(search, bent, bent.fit.z, ('fit',))
    p = bent.problem.parameters(z)
    assert abs(p.ep_converter.offset) < 500.0
    assert p.actuator.leak_area == pytest.approx(4e-8, rel=0.1)
    # of the stem itself viscous friction goes back, which may have stood in for the other kind
    assert p.actuator.viscous_friction == pytest.approx(P.actuator.viscous_friction)
    assert p.actuator.coulomb_friction == pytest.approx(400.0)
    assert p.actuator.stiction == pytest.approx(100.0)
    elsewhere = standing_at(search, bent.effects, {
        **RUBBING, 'actuator.coulomb_friction': 250.0}).fit.z
    p = bent.problem.parameters(as_seen_above(search, bent, elsewhere, ('fit',)))
    assert p.actuator.coulomb_friction == pytest.approx(400.0, rel=0.03)
    smooth = standing_at(search, ('chamber_leak',), {'ep_converter.offset': 5e3})
    assert (as_seen_above(search, smooth, smooth.fit.z, ('fit',)) == smooth.fit.z).all()


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


@pytest.mark.parametrize(('falls_to', 'left', 'least'), [(3.4e-4, 3.5, 1.7), (4.3e-4, 1.0, 0.5)])
def test_a_lift_that_is_never_reached_is_kept_where_that_of_the_intake_is_too_little(
        falls_to, left, least):
    """It has no slope in either record; one opens the exhaust further than the intake goes."""
    current = np.where(TIME < 10.0, 4.8e-4, np.where(TIME < 20.0, falls_to, 4.4e-4))
    plant = P._replace(booster=P.booster._replace(exhaust_lift_ratio=3.0))
    search = searching(seen(plant, current=current), ())
    one = standing_at(search, ('exhaust_asymmetry',), {'booster.exhaust_lift_ratio': 3.5})
    fit = one.problem.at(one.fit.z)
    lift = [free.knob.parameter for free in fit.freedoms].index('booster.exhaust_lift_ratio')
    assert not fit.seen[lift]
    booster = one.problem.without_unseen(fit).parameters.booster
    assert booster.exhaust_lift_ratio == pytest.approx(left)
    never_drawn = np.tile(fit.z, (400, 1))
    value, low, high = interval_of(one.problem, never_drawn, fit, lift)
    assert (value, high) == pytest.approx((3.5, 8.0))
    assert low == pytest.approx(least, rel=0.15)  # as far as the exhaust was opened


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


@pytest.mark.parametrize('values', [12, 60, 1000, 10000])
def test_noise_alone_is_noise_in_each_select_segment_however_few_values_it_has(values):
    rng = np.random.default_rng(values)
    segments = np.full(13, values)
    left = rng.chisquare(values, (2000, 13))
    beyond = np.mean((left > most_by_noise(segments)).any(axis=1))
    assert beyond < 0.02
    assert (most_by_noise(segments) < 4.0 * segments).all()
    if values >= 1000:
        assert (most_by_noise(segments) == 1.3 * segments).all()
