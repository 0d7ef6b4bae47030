# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The final estimate: sizes that no row shows go back to none, all else goes to its end."""

from dataclasses import replace
from types import SimpleNamespace

from made_record import flow_bench
from made_task import CURRENT, P, TIME, place_of, problem_of, seen, z_of
import numpy as np
import pytest

from booster_ros.diagnosis.estimation import final_fit as last_fit
from booster_ros.diagnosis.estimation.final_fit import (
    at_the_bottom, called_for, final_fit, without_unseen)
from booster_ros.diagnosis.estimation.fit import fit_at
from booster_ros.diagnosis.estimation.parametrisation import put
from booster_ros.diagnosis.estimation.uncertainty import block_bootstrap, interval_of


@pytest.mark.parametrize(('falls_to', 'left'), [(3.4e-4, 3.5), (4.3e-4, 1.0)])
def test_a_lift_that_is_never_reached_is_kept_where_that_of_the_intake_is_too_little(
        falls_to, left):
    """It has no slope in either record; one opens the exhaust further than the intake goes."""
    current = np.where(TIME < 10.0, 4.8e-4, np.where(TIME < 20.0, falls_to, 4.4e-4))
    plant = P._replace(booster=P.booster._replace(exhaust_lift_ratio=3.0))
    problem = problem_of(seen(plant, current=current), 'exhaust_asymmetry')
    fit = fit_at(problem, z_of(problem, {'booster.exhaust_lift_ratio': 3.5}))
    lift = place_of(problem, 'booster.exhaust_lift_ratio')
    assert not fit.seen[lift]
    booster = without_unseen(problem, fit).parameters.booster
    assert booster.exhaust_lift_ratio == pytest.approx(left)
    never_drawn = np.tile(fit.z, (400, 1))
    found = interval_of(problem, never_drawn, fit, lift)
    assert (found.value, found.low, found.high) == pytest.approx((3.5, 0.1, 8.0))  # all its range


def test_what_is_seen_stays_and_its_slopes_with_it():
    problem = problem_of(seen(put(P, 'actuator.leak_area', 3e-8)), 'chamber_leak', freedoms=())
    fit = fit_at(problem, z_of(problem, {'actuator.leak_area': 3e-8}))
    assert without_unseen(problem, fit) is fit


def test_what_had_made_up_for_a_size_that_is_not_shown_goes_on_without_it():
    """The rate at which stiction fades means nothing where there is next to none."""
    problem = problem_of(seen(put(P, 'actuator.coulomb_friction', 150.0)), 'stem_friction',
                         freedoms=())
    begun = fit_at(problem, z_of(problem, {
        'actuator.coulomb_friction': 149.0, 'actuator.stiction': 0.02,
        'actuator.stribeck_velocity': 5e-3}))
    found = without_unseen(problem, begun)
    actuator = found.parameters.actuator
    assert (actuator.stiction, actuator.stribeck_velocity) == (0.0, pytest.approx(1e-3))
    assert actuator.coulomb_friction == pytest.approx(150.0, abs=0.5)
    assert found.cost < begun.cost
    assert at_the_bottom(problem, found).parameters.actuator.stiction == 0.0


@pytest.mark.parametrize(('costs', 'left', 'begun'), [
    ((500.0, 400.0, 300.0, 299.5, 299.2), 299.2, 5),  # then too little to go on
    ((500.0, 600.0, 600.0), 500.0, 3),
    ((500.0, 400.0, 450.0, 399.8, 450.0), 399.8, 5)])
def test_slopes_grow_finer_over_slips_again_and_again_while_that_pays(
        costs, left, begun, monkeypatch):
    problem = problem_of(seen(P), 'stem_friction')
    ends, starts, changes = iter(costs), [], []

    def descended(one, several, **_):
        starts.append([float(each[0]) for each in several])
        changes.append(one.observation.steps.change)
        return SimpleNamespace(cost=next(ends), z=np.full(len(several[0]), len(starts)))

    monkeypatch.setattr(last_fit, 'fit', descended)
    z = np.full(len(problem.start()), 0.5)
    assert last_fit._descended(problem, [z]).cost == left
    assert len(starts) == begun
    assert starts[:2] == [[0.5], [1.0]]  # the second where the first ended
    ends_so_far = np.array(costs[:begun])
    assert [one for one, in starts[1:]] == [
        1.0 + np.argmin(ends_so_far[:k]) for k in range(1, begun)]  # where the least was left
    assert changes == [100.0, *(30.0, 10.0) * (begun // 2)]


def test_fits_of_friction_end_together_wherever_they_begin():
    """By slopes over several slips alone, they end 7 N apart."""
    plant = P._replace(actuator=P.actuator._replace(coulomb_friction=250.0, stiction=120.0))
    short = slice(0, 900)
    problem = problem_of(seen(plant, current=CURRENT[short], time=TIME[short]), 'stem_friction',
                         freedoms=())
    sliding = place_of(problem, 'actuator.coulomb_friction')
    ends = [last_fit._descended(problem, [z_of(problem, {
        'actuator.coulomb_friction': 250.0 * more, 'actuator.stiction': 120.0 / more})])
        for more in (1.0, 1.02)]
    forces = [problem.freedoms[sliding].value(end.z[sliding]) for end in ends]
    assert abs(forces[0] - forces[1]) < 0.1
    assert abs(ends[0].cost - ends[1].cost) < 1.0


def friction_along_the_travel(peak):
    """Return the problem of a stem that rubs the more the further it is, and at a peak of it."""
    plant = P._replace(actuator=P.actuator._replace(
        coulomb_friction=80.0, friction_gradient=600.0, friction_peak=peak,
        friction_peak_position=0.008, friction_peak_width=0.002))
    return problem_of(seen(plant), 'position_dependent_friction', freedoms=())


@pytest.mark.parametrize('there', [0.0, 200.0])
def test_a_size_beside_the_first_is_kept_where_the_record_calls_for_it(there):
    problem = friction_along_the_travel(there)
    begun = last_fit._descended(problem, [z_of(problem, {
        'actuator.coulomb_friction': 80.0, 'actuator.friction_gradient': 600.0,
        'actuator.friction_peak': there or 8.0, 'actuator.presliding_stiffness': 0.0})])
    assert begun.parameters.actuator.friction_peak > 1.0
    actuator = called_for(problem, at_the_bottom(problem, begun)).parameters.actuator
    assert (actuator.friction_peak > 100.0) if there else (actuator.friction_peak == 0.0)
    assert actuator.coulomb_friction > 50.0  # the first size of an effect is no question


@pytest.mark.parametrize('effect', ['chamber_leak', 'stem_friction'])
def test_intervals_are_by_slopes_along_the_axes_of_a_valley_be_it_over_slips_or_not(
        effect, monkeypatch):
    problem, begun = problem_of(seen(P), effect, freedoms=()), []

    def doubled(one, z, here, columns):
        begun.append(columns)
        return 2.0 * columns

    monkeypatch.setattr(last_fit, 'fit', lambda one, starts, **_: fit_at(one, starts[0]))
    monkeypatch.setattr(last_fit, 'slopes_along_axes', doubled)
    last = final_fit(problem, problem.start(), (TIME // 3.0).astype(int))
    assert last.fit.jacobian == pytest.approx(2.0 * begun[-1])


@pytest.mark.parametrize('effect', ['chamber_leak', 'stem_friction'])
def test_axes_begin_with_slopes_over_several_slips_whatever_finer_ones_said(effect, monkeypatch):
    problem, begun = problem_of(seen(P), effect, freedoms=()), []
    monkeypatch.setattr(last_fit, 'slopes_along_axes',
                        lambda one, z, here, columns: begun.append(columns) or columns)
    found = fit_at(problem, np.full(len(problem.start()), 0.1))
    finer = replace(found, jacobian=10.0 * found.jacobian)
    at_the_bottom(problem, finer)
    over_slips = problem.jacobian(found.z, found.residuals, finer.jacobian)
    assert begun[0] == pytest.approx(over_slips if effect == 'stem_friction' else finer.jacobian)


@pytest.mark.parametrize('leak', [0.0, 4e-8])
def test_a_final_fit_says_how_sure_a_leak_is(leak):
    problem = problem_of(seen(put(P, 'actuator.leak_area', leak)), 'chamber_leak', freedoms=())
    last = final_fit(problem, z_of(problem, {'actuator.leak_area': 2e-8}),
                     (TIME // 3.0).astype(int))
    found = interval_of(last.problem, last.draws, last.fit, 0)
    assert abs(found.value - leak) <= found.high - found.low < 1e-8
    assert last.fit.cost < 1.1 * problem.observed
    if not leak:
        assert found.low == 0.0


def test_a_size_that_no_row_shows_goes_back_to_neutral():
    problem = problem_of(flow_bench(7e-6, 0.37), 'booster_dead_band', freedoms=())
    fit = fit_at(problem, np.array([10.0, 4.0]))
    booster = without_unseen(problem, fit).parameters.booster
    assert fit.parameters.booster.exhaust_preload > 0.0  # a bench never exhausts
    assert booster.exhaust_preload == 0.0
    without = without_unseen(problem, fit)
    assert without.cost == problem.cost(without.z) < fit.cost  # what was there beside goes on
    assert 0.0 < booster.intake_preload != fit.parameters.booster.intake_preload
    preload = [free.knob.parameter for free in fit.freedoms].index('booster.exhaust_preload')
    drawn = block_bootstrap(problem, fit, np.arange(54))
    nothing = interval_of(problem, drawn, fit, preload)
    assert (nothing.low, nothing.high) == (0.0, 1.0)
