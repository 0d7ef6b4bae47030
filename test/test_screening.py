# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Lines in what the model misses, the size of a ripple, places and shapes that are tried."""

from dataclasses import replace

from made_effect import add_effect
from made_task import P, STEPS, TIME, everywhere, problem_of, seen, steps_seen, task_of
import numpy as np
import pytest

from booster_ros.diagnosis.estimation.fit import fit, fit_at
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.diagnosis.estimation.parametrisation import (
    declared_freedom, effect_freedom, put)
from booster_ros.diagnosis.selection import screening
from booster_ros.diagnosis.selection.screening import (
    first_steps, reference_at, references, screen, strong_frequencies)
from booster_ros.model.catalogue import EFFECTS, Knob


def declared(*starts):
    """Return the declared parameters that may change whose names start like one of these."""
    return tuple(free for free in declared_freedom(P, seen(P))
                 if free.knob.parameter.startswith(starts))


FILLING = ('ep_converter.', 'actuator.bench_set', 'actuator.dead_volume')
"""What tells where the valve rests, and how soon."""


def test_frequencies_are_sought_in_the_fitted_rows_alone():
    problem = task_of(seen(P)).problem()
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
    around = references(problem, fit_at(problem, problem.start()))
    quick = screen(problem, around, 'supply_ripple', found)
    ended = first_steps(problem, quick)
    without = float(np.sum(problem.residuals(problem.start())**2))
    noise = problem.observed
    assert ended.cost - noise < 0.15 * (without - noise)
    sizes = dict(zip((f.knob.parameter for f in quick.problem.freedoms), ended.z))
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


def promised(plant, effect, frequencies):
    """Return the parameters at which an effect promises most for the record of a plant."""
    problem = task_of(seen(plant)).problem()
    reference = reference_at(problem, fit_at(problem, problem.start()))
    found = screen(problem, [reference], effect, frequencies, (0.25,))
    return found.problem.parameters(found.starts[0][1])


def test_a_new_effect_that_repeats_itself_is_tried_at_the_frequencies_that_were_found(monkeypatch):
    pace = Knob('ep_converter.drift_time_constant', 100.0, 5.0, 2e3, shape=True, frequency=True)
    size = Knob('ep_converter.drift', 1e3, -3e4, 3e4, clocked=True)
    add_effect(monkeypatch, 'pulsing', 'ep_converter', pace, size)
    found = promised(P, 'pulsing', np.array([30.0, 70.0])).ep_converter
    assert found.drift_time_constant in (pytest.approx(30.0), pytest.approx(70.0))


def test_new_friction_is_not_tried_without_as_much_of_what_slides(monkeypatch):
    for rubs in (False, True):
        add_effect(monkeypatch, 'worn_guide', 'stem',
                   Knob('actuator.flow_force', 500.0, -1e4, 1e4, rubs=rubs),
                   Knob('actuator.spring_bend', 300.0, -5e3, 5e3))
        sizes = screening._sizes_to_try(
            tuple(effect_freedom(EFFECTS['worn_guide'])), np.array([0.5]), screening.SIZES)
        assert any(rubbing == 0.0 and bend != 0.0 for rubbing, bend in sizes) is not rubs


def test_a_ripple_that_stands_still_is_none():
    """Zero is in the range of its frequency."""
    still = P._replace(supply=P.supply._replace(ripple=2e3, ripple_frequency=0.0))
    predicted = seen(P).predict(still)['chamber_pressure']
    assert np.isfinite(predicted).all()


def test_an_effect_is_seen_from_parameters_as_given_once_what_is_told_at_rest_is_fitted():
    """A gain that is off by a percent hides a tube from the parameters as given; it bent others."""
    plant = put(P, 'ep_converter.gain', 1.012 * P.ep_converter.gain)
    for name, value in {'restriction_area': 2.8e-6, 'laminar_share': 1.0}.items():
        plant = put(plant, f'tubing.{name}', value)
    problem = problem_of(steps_seen(plant, STEPS[:6], 1.2e5, seed=5),
                         freedoms=declared(*FILLING, 'booster.'))
    places = references(problem, fit(problem))
    before, after = (first_steps(problem, screen(problem, some, 'tubing_restriction')).cost
                     for some in (places[:2], places))
    assert after < 1.3 * problem.observed
    assert after <= before


def test_a_tube_with_little_air_before_it_is_seen_beside_a_hysteresis():
    """Air before the tube that is not there costs as much as the tube explains."""
    plant = P
    for name, value in {
            'ep_converter.gain': 1.003 * P.ep_converter.gain, 'ep_converter.hysteresis': 4.2e-6,
            'actuator.dead_volume': 1.06 * P.actuator.dead_volume,
            'tubing.restriction_area': 5.8e-6, 'tubing.outlet_volume': 1e-5}.items():
        plant = put(plant, name, value)
    beside = problem_of(steps_seen(plant, STEPS[:8], 1.7e5, seed=3), 'ep_hysteresis',
                        freedoms=declared(*FILLING))
    found = fit(beside, evaluations=30)
    seen_as = first_steps(beside, screen(
        beside, references(beside, found), 'tubing_restriction'))
    assert found.cost > 1.2 * beside.observed
    assert seen_as.cost < 1.05 * beside.observed


def test_screening_ends_where_an_effect_was_simulated_to_be_not_where_it_was_reckoned():
    """The declared parameters have to move far before this exhaust is recognised."""
    problem = problem_of(steps_seen(
        put(P, 'booster.exhaust_gain_ratio', 0.6), STEPS[:5], 1.7e5, seed=7),
        freedoms=declared(*FILLING, 'booster.'))
    refit = fit(problem)
    found = screen(problem, references(problem, refit), 'exhaust_asymmetry')
    costs = [cost for cost, *_ in found.starts]
    assert costs == sorted(costs)
    ended = first_steps(problem, found)
    assert ended.cost == pytest.approx(float(np.sum(found.problem.residuals(ended.z)**2)))
    assert ended.cost < 0.5 * refit.cost
    low, high = found.problem.bounds()
    assert all((low <= z).all() and (z <= high).all() for _, z, _ in found.starts)


@pytest.mark.parametrize(('bias', 'places'), [(30e3, 3), (1e3, 2)])
def test_what_only_an_unlikely_gain_explains_at_rest_is_screened_for_as_given_too(bias, places):
    plant = P._replace(sensors=P.sensors._replace(pressure_bias=bias))
    problem = task_of(seen(plant)).problem()
    around = references(problem, fit(problem))
    assert len(around) == places
    at_rest = [f.knob.parameter for f in problem.freedoms].index('ep_converter.gain')
    assert around[1].z[at_rest] != 0.0
    assert all(one.z[at_rest] == 0.0 for one in around[2:])
