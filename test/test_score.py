# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The score of a model against what is known of linear Gaussian problems and of noise."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import multivariate_normal

from booster_ros.diagnosis.selection.score import score_of
from booster_ros.signals.dispersion import dispersion

ROWS, BLOCKS = 120, 6
DEVIATION = np.array([1.0, 3.0, 0.2])
"""Of what is known beforehand of three variables."""


def linear(seed=1, high=np.inf):
    """Return problem, fit, design and readings of a line through noise, z fitted exactly."""
    rng = np.random.default_rng(seed)
    design = rng.standard_normal((ROWS, 3)) * [1.0, 0.2, 2.0]
    readings = design @ (DEVIATION * rng.standard_normal(3)) + rng.standard_normal(ROWS)
    z = posterior_mean(design, readings)
    jacobian = np.vstack([-design, np.diag(1.0 / DEVIATION)])
    residuals = np.concatenate([readings - design @ z, z / DEVIATION])
    problem = SimpleNamespace(
        observed=ROWS, sigma=DEVIATION, experiment=SimpleNamespace(chance={}),
        freedoms=tuple(SimpleNamespace(prior_deviation=lambda z, one=one: one)
                       for one in DEVIATION),
        bounds=lambda: (np.full(3, -np.inf), np.array([np.inf, high, np.inf])),
        first_rows=(np.arange(ROWS // 2), np.arange(ROWS // 2)),
        series=lambda observed: np.split(observed, 2))
    fit = SimpleNamespace(z=z, residuals=residuals, jacobian=jacobian,
                          cost=float(residuals @ residuals))
    return problem, fit, design, readings


def posterior_mean(design, readings, c=1.0):
    return np.linalg.solve(design.T @ design + c * np.diag(DEVIATION**-2), design.T @ readings)


BLOCK_OF_ROW = np.arange(ROWS // 2) * BLOCKS // (ROWS // 2)
BLOCK = np.tile(BLOCK_OF_ROW, 2)
"""Both channels have the same rows, and so the same blocks."""


@pytest.mark.parametrize('c', [1.0, 5.0])
def test_the_evidence_of_a_linear_problem_is_that_of_its_marginal_density(c):
    """Noise of variance c, prior as it is: y ~ N(0, A S A' + c I)."""
    problem, fit, design, readings = linear()
    if c != 1.0:
        z = posterior_mean(design, readings, c)
        fit.residuals[:ROWS], fit.z = readings - design @ z, z
        fit.residuals[ROWS:] = z / DEVIATION
        fit.cost = float(fit.residuals @ fit.residuals)
    found = score_of(problem, fit, BLOCK_OF_ROW).log_evidence(c)
    covariance = design @ np.diag(DEVIATION**2) @ design.T + c * np.eye(ROWS)
    marginal = multivariate_normal(np.zeros(ROWS), covariance).logpdf(readings)
    constant = -0.5 * ROWS * np.log(2.0 * np.pi * c)
    assert found == pytest.approx(marginal - constant, rel=1e-9)


def test_what_is_left_is_told_block_by_block_over_all_channels():
    problem, fit, *_ = linear()
    found = score_of(problem, fit, BLOCK_OF_ROW)
    for block, cost in enumerate(found.costs):
        assert cost == pytest.approx(np.sum(fit.residuals[:ROWS][block == BLOCK]**2))
    assert found.cost == pytest.approx(found.costs.sum())
    assert found.cost + found.prior == pytest.approx(fit.cost)
    assert found.observed == ROWS


def test_a_variable_at_its_bound_pays_nothing_and_does_not_move():
    problem, fit, *_ = linear()
    problem.bounds = lambda: (np.full(3, -np.inf), np.array([np.inf, fit.z[1], np.inf]))
    held = score_of(problem, fit, BLOCK_OF_ROW)
    assert held.information.shape == (2, 2)
    assert held.precision == pytest.approx(DEVIATION[[0, 2]]**-2)


def test_a_variable_that_explains_nothing_costs_evidence():
    """Where rows tell it well, the price is the share of its range that is left."""
    rng = np.random.default_rng(3)
    problem, fit, *_ = linear()
    idle = rng.standard_normal(ROWS)
    basis = np.linalg.qr(np.column_stack([fit.jacobian[:ROWS], fit.residuals[:ROWS]]))[0]
    idle -= basis @ (basis.T @ idle)  # nothing of what is left, nor of the others
    wider = SimpleNamespace(
        observed=ROWS, series=problem.series, first_rows=problem.first_rows,
        experiment=problem.experiment,
        sigma=np.append(DEVIATION, 10.0),
        freedoms=(*problem.freedoms, SimpleNamespace(prior_deviation=lambda z: 10.0)),
        bounds=lambda: (np.full(4, -np.inf), np.full(4, np.inf)))
    more = SimpleNamespace(z=np.append(fit.z, 0.0), residuals=np.append(fit.residuals, 0.0),
                           jacobian=np.zeros((ROWS + 4, 4)), cost=fit.cost)
    more.jacobian[:ROWS + 3, :3] = fit.jacobian
    more.jacobian[:ROWS, 3], more.jacobian[-1, 3] = idle, 0.1
    lost = (score_of(problem, fit, BLOCK_OF_ROW).log_evidence()
            - score_of(wider, more, BLOCK_OF_ROW).log_evidence())
    assert lost == pytest.approx(0.5 * np.log1p(100.0 * idle @ idle))


def white(seed, size=4000):
    return np.random.default_rng(seed).standard_normal(size)


def test_white_noise_of_the_right_level_is_not_tempered():
    found = [dispersion([white(2 * k), white(2 * k + 1)]) for k in range(20)]
    assert min(found) >= 1.0
    assert np.mean(found) < 1.15


@pytest.mark.parametrize('rho', [0.5, 0.8, 0.95])
def test_an_autoregressive_series_is_tempered_by_its_autocorrelation_time(rho):
    """It is (1 + rho) / (1 - rho) (G. Box and G. Jenkins, Time Series Analysis, 1970, 2.1)."""
    series = [lfilter([np.sqrt(1.0 - rho**2)], [1.0, -rho], white(k, 20_000)) for k in range(8)]
    assert np.mean([dispersion([one]) for one in series]) == pytest.approx(
        (1.0 + rho) / (1.0 - rho), rel=0.15)


def test_it_goes_with_the_square_of_what_is_left():
    values = white(4)
    assert dispersion([3.0 * values]) == pytest.approx(9.0, rel=0.2)
    assert dispersion([6.0 * values]) == pytest.approx(4.0 * dispersion([3.0 * values]))
    assert dispersion([1e-3 * values]) == 1.0  # less than noise is no reason to be surer


def test_channels_count_by_their_rows_and_short_ones_have_no_autocorrelation():
    assert dispersion([3.0 * np.ones(11), np.zeros(11)]) == pytest.approx(4.5)
    assert dispersion([np.array([]), np.zeros(50)]) == 1.0
    assert dispersion([]) == 1.0


def test_luck_is_what_next_to_no_change_does_to_a_cost_with_steps():
    problem, fit, *_ = linear()
    problem.residuals = lambda z: np.append(fit.residuals, 3.0 * np.ones(4) * (z[0] > fit.z[0]))
    assert score_of(problem, fit, BLOCK_OF_ROW).luck == 0.0  # nothing is left to chance
    problem.experiment.chance = {'chamber_pressure': object()}
    problem.bounds = lambda: (np.full(3, -np.inf), np.full(3, np.inf))
    step = 4.0 * 9.0 * np.log(2.0)  # where draws go over it, half of it is luck
    assert 0.25 * step < score_of(problem, fit, BLOCK_OF_ROW).luck < 0.5 * step


def test_a_burst_counts_by_its_logarithm_where_chance_is_at_work():
    problem, fit, *_ = linear()
    fit.residuals[:8] = 100.0
    sober = score_of(problem, fit, BLOCK_OF_ROW)
    problem.experiment.chance, problem.residuals = {'valve_position': object()}, lambda z: (
        fit.residuals)
    chancy = score_of(problem, fit, BLOCK_OF_ROW)
    assert sober.cost > 8e4
    assert chancy.cost == pytest.approx(
        np.sum(9.0 * np.log1p(fit.residuals[:ROWS]**2 / 9.0)), rel=1e-12)
    assert chancy.costs.sum() == pytest.approx(chancy.cost)
    assert chancy.prior == sober.prior
