# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A fit: the state in which it begins, and what it leaves of a size that no row shows."""

from dataclasses import replace

from made_effect import add_effect
from made_search import CURRENT, P, TIME, everywhere, searching, seen, standing_at
import numpy as np
import pytest

from booster_ros.diagnosis.data.experiment import Experiment, Initial
from booster_ros.diagnosis.estimation.problem import START, Problem
from booster_ros.diagnosis.estimation.parametrisation import declared_freedom, possible_departures, put
from booster_ros.diagnosis.estimation.uncertainty import interval_of
from booster_ros.diagnosis.selection.screening import with_effect
from booster_ros.model.catalogue import EFFECTS, Knob
from booster_ros.model.memory import Departure
from booster_ros.model.simulation import simulate


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


def test_at_the_edge_of_a_play_slopes_are_those_within_it():
    """Beyond the edge there is nothing: the first row takes the place back to it."""
    plant = P._replace(ep_converter=P.ep_converter._replace(hysteresis=6e-6))
    experiment = seen(plant, Departure(ep_play=1.0))
    problem = Problem(experiment, everywhere(experiment), plant, ())
    edge = problem.start()
    edge[2] = 1.0 - 1e-6
    here, step = problem.residuals(edge), np.zeros(len(edge))
    step[2] = 0.01
    within = (here - problem.residuals(edge - step)) / 0.01
    assert np.linalg.norm(within) > 100.0
    np.testing.assert_allclose(problem.jacobian(edge, here)[:, 2], within, rtol=0.0,
                               atol=0.05 * np.max(np.abs(within)))


def test_a_start_without_play_warmth_or_past_costs_no_simulation_and_stays_free_of_data():
    experiment = seen(P)
    problem = Problem(experiment, everywhere(experiment), P, tuple(declared_freedom(P, experiment)))
    places = problem.at(problem.start()).jacobian[:, -4:]
    assert np.count_nonzero(places) == 4
    assert np.abs(places[-4:]) == pytest.approx(np.diag(1.0 / START[-4:]))


def test_the_model_is_run_no_further_than_the_last_row_that_counts(monkeypatch):
    """What comes later changes nothing before. One channel ends earlier, and no row may count."""
    experiment = seen(P)
    experiment.measured['valve_position'][150:] = np.nan
    rows = np.arange(len(experiment.time)) < 200
    problem = Problem(experiment, rows, put(P, 'supply.pressure', 3.9e5), ())
    z = problem.start()
    whole, ends = problem.predict(z), []
    run = Experiment.predict
    monkeypatch.setattr(
        Experiment, 'predict', lambda self, *one: ends.append(self.time[-1]) or run(self, *one))
    left = problem.residuals(z)[:350]
    assert ends == [experiment.time[199]]
    expected = np.concatenate([
        (experiment.measured[name][:count] - whole[name][:count]) / experiment.noise[name]
        for name, count in (('chamber_pressure', 200), ('valve_position', 150))])
    assert np.array_equal(left, expected)
    assert len(replace(problem, rows=rows & False).residuals(z)) == problem.nuisances


def test_what_may_be_off_at_the_start_goes_with_the_sizes_of_effects(monkeypatch):
    assert possible_departures(P) == set()
    assert possible_departures(put(P, 'ep_converter.hysteresis', 1e-6)) == {'ep_play'}
    leaking = put(P, 'actuator.leak_area', 1e-8)
    assert possible_departures(leaking) == set()
    knob = Knob('actuator.leak_area', 5e-8, 0.0, 1e-6, departs='temperature')
    add_effect(monkeypatch, 'draught', 'chamber', knob)
    assert possible_departures(leaking) == {'temperature'}
    named = {knob.departs for effect in EFFECTS.values() for knob in effect.knobs} - {''}
    assert named < set(Departure._fields)


def test_play_of_the_position_reading_starts_where_it_was_left():
    plant = P._replace(sensors=P.sensors._replace(position_backlash=4e-4))
    high, low = (simulate(plant, TIME, CURRENT, {'chamber_pressure': 2e5},
                          departure=Departure(position_play=place)) for place in (1.0, -1.0))
    apart = high['measured_valve_position'][0] - low['measured_valve_position'][0]
    assert apart == pytest.approx(4e-4)
    assert high['valve_position'][0] == low['valve_position'][0]


@pytest.mark.parametrize(('pressure', 'position', 'kept'), [(97e3, 0.0, False), (2e5, 5e-3, True)])
def test_a_stem_that_sticks_starts_where_it_was_read_but_on_a_stop(pressure, position, kept):
    """On a stop, what noise makes of the reading is hundreds of newtons in a packing."""
    plant = P._replace(actuator=P.actuator._replace(
        coulomb_friction=550.0, stiction=190.0, presliding_stiffness=2e7))
    experiment = seen(P)

    def started(noise):
        read = replace(experiment, initial=Initial(pressure, valve_position=position + noise))
        problem = Problem(read, everywhere(read), plant, ())
        return problem.initial(problem.start(), plant).valve_position

    assert started(8e-6) == (pytest.approx(position + 8e-6) if kept else None)
    assert started(-8e-6) == (pytest.approx(position - 8e-6) if kept else None)


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
    found = interval_of(one.problem, never_drawn, fit, lift)
    assert (found.value, found.high) == pytest.approx((3.5, 8.0))
    assert found.low == pytest.approx(least, rel=0.15)  # as far as the exhaust was opened
