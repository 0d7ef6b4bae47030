# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Variables that do nearly the same: what a record does not tell apart has to look like that."""

from dataclasses import replace

from made_diagnosis import diagnosis_of, timed_columns
from made_report import undrawn_page
import made_task
from made_task import P, START_PRESSURE
import numpy as np
import pytest

from booster_ros.diagnosis.estimation.fit import fit as best_fit, fit_at
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.diagnosis.estimation.parametrisation import declared_freedom
from booster_ros.diagnosis.estimation.uncertainty import Interval, block_bootstrap, interval_of
from booster_ros.diagnosis.estimation.final_fit import at_the_bottom, slopes_along_axes
from booster_ros.diagnosis.result import FoundEffect
from booster_ros.diagnosis.hypotheses.compose import with_effect
from booster_ros.model.catalogue import EFFECTS
from booster_ros.model.simulation import simulate
from booster_ros.report.notes import either

TIME, CURRENT = made_task.TIME[::2], made_task.CURRENT[::2]
NAMES = ('ep_converter.offset', 'booster.intake_preload', 'booster.exhaust_preload')
NOISE = {'chamber_pressure': 5.0, 'valve_position': 1e-7}
"""As little as any channel is held to have."""
PER_PASCAL = P.booster.s1
"""Newton by which the one preload has to rise, the other to fall, for a pascal of offset."""


def seen(parameters):
    """Return the experiment that a plant with these parameters would give, with its noise."""
    return made_task.seen(parameters, time=TIME, current=CURRENT)


@pytest.fixture(scope='module')
def fitted():
    """Return problem and fit of a dead band, 30 mN on either side, beside declared parameters."""
    experiment = seen(P._replace(booster=P.booster._replace(
        intake_preload=0.03, exhaust_preload=0.03)))
    declared = Problem(experiment, np.ones(len(TIME), dtype=bool), P,
                       tuple(declared_freedom(P, experiment)))
    problem = with_effect(declared, EFFECTS['booster_dead_band'])
    z = problem.start()
    for j, free in enumerate(problem.freedoms):
        if free.knob.parameter in NAMES[1:]:
            z[j] = free.variable(0.03)
    return problem, best_fit(problem, [z])


def places(problem):
    """Return where the offset and the two preloads stand among the variables."""
    names = [free.knob.parameter for free in problem.freedoms]
    return [names.index(name) for name in NAMES]


def along_the_valley(problem):
    """Return the step in z that raises the offset by one standard deviation, and seats with it."""
    offset, intake, exhaust = places(problem)
    step = np.zeros(len(problem.start()))
    force = PER_PASCAL * problem.freedoms[offset].scale
    step[offset] = 1.0
    step[intake] = force / problem.freedoms[intake].scale
    step[exhaust] = -force / problem.freedoms[exhaust].scale
    return step


def refined(problem, fit):
    """Return the slopes of a fit along the axes of its Jacobian."""
    here = problem.residuals(fit.z)
    return slopes_along_axes(problem, fit.z, here, fit.jacobian)


def test_along_axes_slopes_are_those_of_the_valley(fitted):
    problem, fit = fitted
    step = along_the_valley(problem)
    rows = problem.observed
    moved = problem.residuals(fit.z + 0.3 * step) - problem.residuals(fit.z - 0.3 * step)
    truth = np.linalg.norm(moved[:rows]) / 0.6
    across = np.linalg.norm(fit.jacobian[:rows, places(problem)[0]])
    assert truth < 1e-3 * across  # a valley it is
    slopes = refined(problem, fit)
    assert np.linalg.norm(slopes[:rows] @ step) < truth + 1.0
    np.testing.assert_allclose(  # and across it they are as they were
        np.linalg.norm(slopes, axis=0), np.linalg.norm(fit.jacobian, axis=0), rtol=0.02, atol=1.0)


def test_what_trades_with_a_declared_parameter_is_as_unsure_as_that(fitted):
    problem, fit = fitted
    fit = at_the_bottom(problem, fit)
    draws = block_bootstrap(problem, fit, (TIME // 2.5).astype(int))
    offset, intake, exhaust = places(problem)
    assert 0.7 < np.std(draws[:, offset]) < 1.3  # of its prior
    together, apart = draws[:, intake] + draws[:, exhaust], draws[:, intake] - draws[:, exhaust]
    assert np.std(together) < 0.02 * np.std(apart)
    scale = problem.freedoms[intake].scale
    assert scale * np.mean(together) == pytest.approx(0.06, abs=0.002)


def test_the_fit_goes_on_to_the_bottom_of_the_valley(fitted):
    problem, fit = fitted
    moved = fit_at(problem, fit.z + along_the_valley(problem), fit.jacobian)
    assert abs(moved.z[places(problem)[0]]) > 0.7
    found = at_the_bottom(problem, moved)
    assert found.cost < moved.cost - 0.5
    assert abs(found.z[places(problem)[0]]) < 0.3
    assert found.parameters == problem.parameters(found.z)
    assert at_the_bottom(problem, found).cost <= found.cost


@pytest.fixture(scope='module')
def one_at_its_bound(fitted):
    """Return problem and fit of a dead band of the intake alone: the exhaust's stands at none."""
    experiment = seen(P._replace(booster=P.booster._replace(intake_preload=0.06)))
    problem = replace(fitted[0], experiment=experiment)
    z = problem.start()
    z[places(problem)[1]] = problem.freedoms[places(problem)[1]].variable(0.06)
    return problem, fit_at(problem, z)


def test_beside_a_bound_slopes_are_those_of_the_valley_too(one_at_its_bound):
    problem, fit = one_at_its_bound
    step, rows = along_the_valley(problem), problem.observed
    here, moved = (problem.residuals(z)[:rows] for z in (fit.z, fit.z - 0.3 * step))
    truth = np.linalg.norm(moved - here) / 0.3  # the exhaust's preload can but rise
    assert np.linalg.norm(fit.jacobian[:rows] @ step) > 5.0 * truth
    assert np.linalg.norm(refined(problem, fit)[:rows] @ step) < truth + 1.0


def test_beside_a_bound_an_interval_holds_what_the_rows_hardly_notice(one_at_its_bound):
    problem, fit = one_at_its_bound
    fit = at_the_bottom(problem, fit)
    draws = block_bootstrap(problem, fit, (TIME // 2.5).astype(int))
    assert problem.cost(fit.z - along_the_valley(problem)) < fit.cost + 3.84
    for j in places(problem):
        moved = problem.freedoms[j].value(fit.z[j] - along_the_valley(problem)[j])
        found = interval_of(problem, draws, fit, j)
        assert found.low < moved < found.high


def test_with_next_to_no_noise_sizes_that_trade_stand_as_their_sum_does():
    """Either may be none beside the offset; their sum is known a million times better."""
    experiment = seen(P._replace(booster=P.booster._replace(intake_preload=0.06)))
    exact = simulate(P._replace(booster=P.booster._replace(intake_preload=0.06)), TIME, CURRENT,
                     {'chamber_pressure': START_PRESSURE})
    quiet = replace(experiment, measured={name: exact[f'measured_{name}'] for name in NOISE},
                    noise=NOISE)
    problem = with_effect(Problem(quiet, np.ones(len(TIME), dtype=bool), P,
                                  tuple(declared_freedom(P, quiet))), EFFECTS['booster_dead_band'])
    z = problem.start()
    z[places(problem)[1]] = problem.freedoms[places(problem)[1]].variable(0.06)
    fit = at_the_bottom(problem, fit_at(problem, z))
    draws = block_bootstrap(problem, fit, (TIME // 2.5).astype(int))
    scale = problem.freedoms[places(problem)[1]].scale
    together = scale * draws[:, places(problem)[1:]].sum(axis=1)
    assert np.mean(together) == pytest.approx(0.06, rel=1e-3)
    assert np.std(together) < 1e-3 * 0.06


@pytest.mark.parametrize(('lowest', 'said'), [(0.0, True), (0.01, False)])
def test_sizes_of_which_each_may_be_none_are_said_to_be_known_together(lowest, said):
    parameters = {name: Interval(0.03, low, 0.06, 'N')
                  for name, low in zip(NAMES[1:], (0.0, lowest))}
    found = FoundEffect('booster_dead_band', 'booster', parameters, (), '', {})
    assert bool(either(found)) == said
    if said:
        assert either(found).startswith(
            'booster.intake_preload and booster.exhaust_preload: each may be none, but not all')
    alone = replace(found, parameters={NAMES[1]: parameters[NAMES[1]]})
    assert not either(alone)
    assert not either(replace(found, name='unknown', parameters={}))


def test_the_page_says_it_below_their_intervals():
    parameters = {name: Interval(0.03, 0.0, 0.06, 'N') for name in NAMES[1:]}
    found = FoundEffect('booster_dead_band', 'booster', parameters, (), '', {})
    page = undrawn_page(diagnosis_of(timed_columns(seconds=30.0), 'effect', effects=(found,)))
    added = page[page.index('What was added'):]
    assert 0 < added.index('0 to 0.0600') < added.index('each may be none, but not all')
