# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A problem: the state in which it begins, which rows count, slopes at the edge of a play."""

from dataclasses import replace

from made_effect import add_effect
from made_task import CURRENT, P, TIME, everywhere, problem_of, seen
import numpy as np
import pytest

from booster_ros.diagnosis.data.experiment import Experiment, Initial
from booster_ros.diagnosis.estimation.fit import fit, fit_at
from booster_ros.diagnosis.estimation.parametrisation import (
    declared_freedom, possible_departures, put)
from booster_ros.diagnosis.estimation.problem import START, Problem
from booster_ros.model.catalogue import EFFECTS, Knob
from booster_ros.model.memory import Departure
from booster_ros.model.simulation import simulate


def test_a_converter_that_starts_at_the_edge_of_its_play_is_found_there():
    width = 6e-6
    plant = P._replace(ep_converter=P.ep_converter._replace(hysteresis=width))
    experiment = seen(plant, Departure(ep_play=1.0))
    free = problem_of(experiment, 'ep_hysteresis', freedoms=())
    begin = free.start()
    begin[0] = 1.0
    found = fit(free, [begin])
    assert found.parameters.ep_converter.hysteresis == pytest.approx(width, rel=0.05)
    assert found.initial.departure.ep_play == pytest.approx(1.0, abs=0.1)
    assert found.cost < 1.1 * free.observed


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
    places = fit_at(problem, problem.start()).jacobian[:, -4:]
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


@pytest.mark.parametrize('noise', [-200.0, 0.0, 200.0])
def test_a_stem_at_the_edge_of_breaking_away_is_held_as_it_was_seen(noise):
    """A pressure some pascals off would set it off at once, which no slope could take back."""
    plant = P._replace(actuator=P.actuator._replace(coulomb_friction=350.0, stiction=120.0))
    act = plant.actuator
    rate = act.effective_area * (act.bench_set[1] - act.bench_set[0]) / act.travel
    edge = act.bench_set[0] + (rate * 5e-3 + 470.0) / act.effective_area
    still = replace(seen(plant), current=np.full(len(TIME), 4e-4), initial=Initial(
        edge + noise, valve_position=5e-3))
    problem = Problem(still, everywhere(still), plant, ())
    start = problem.initial(problem.start(), plant).valve_position
    beyond = max(noise, 0.0) * act.effective_area / rate  # where friction holds it next
    assert start == pytest.approx(5e-3 + beyond, abs=1e-8)


def test_what_the_process_does_to_a_stem_counts_where_friction_holds_it():
    """The stem rests where pressure and pressure drop balance; without the drop it would slide."""
    plant = P._replace(actuator=P.actuator._replace(
        coulomb_friction=350.0, stiction=120.0, plug_area=2e-3))
    act, drop = plant.actuator, 2.5e5
    rate = act.effective_area * (act.bench_set[1] - act.bench_set[0]) / act.travel
    balanced = act.bench_set[0] + (rate * 5e-3 + 2e-3 * drop) / act.effective_area
    still = replace(seen(plant), initial=Initial(balanced, valve_position=5e-3),
                    pinned={'pressure_drop': np.full(len(TIME), drop)})
    problem = Problem(still, everywhere(still), plant, ())
    assert problem.initial(problem.start(), plant).valve_position == 5e-3


def test_what_linear_algebra_rounds_is_no_other_slip():
    """Runs of the same diagnosis end in the same place, whatever else the machine does."""
    plant = P._replace(actuator=P.actuator._replace(coulomb_friction=380.0, stiction=130.0))
    problem = problem_of(seen(plant), 'stem_friction', freedoms=())
    z = problem.start() + 0.3
    again = z * (1.0 + 1e-14)
    rows, here = problem.observed, problem.residuals(z)
    assert np.array_equal(problem.residuals(again)[:rows], here[:rows])
    slopes = problem.jacobian(z, here)
    after, before = (problem.jacobian(place, here, scale * slopes)[:rows]
                     for place, scale in ((again, 1.0 + 1e-14), (z, 1.0)))
    assert np.array_equal(after, before)


def test_a_stem_that_sticks_starts_behind_the_play_of_its_sensor():
    sticking = put(put(P, 'actuator.coulomb_friction', 300.0), 'sensors.position_backlash', 5e-4)
    experiment = replace(seen(P), initial=Initial(2e5, valve_position=4e-3))
    problem = Problem(experiment, everywhere(experiment), sticking, ())
    z = problem.start()
    z[3] = -1.0  # the sensor's part lies at the lower end of its play
    assert problem.predict(z)['valve_position'][0] == pytest.approx(4e-3, abs=1e-7)


def test_a_model_that_cannot_run_is_far_off_and_flat():
    problem = problem_of(seen(P))
    lost = replace(problem, freedoms=(), base=P._replace(
        actuator=P.actuator._replace(bench_set=(210e3, 140e3))))
    z = lost.start()
    left = lost.residuals(z)[:lost.observed]
    assert set(left) == {1e3}
