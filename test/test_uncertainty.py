# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How sure a fitted parameter is: the bootstrap of blocks, and intervals from its draws."""

from types import SimpleNamespace

from made_task import P, TIME, problem_of, seen
import numpy as np
import pytest

from booster_ros.diagnosis.data.experiment import Experiment, Initial
from booster_ros.diagnosis.estimation.fit import Fit, fit
from booster_ros.diagnosis.estimation.observation import WINDOWS
from booster_ros.diagnosis.estimation.parametrisation import effect_freedom, put
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.diagnosis.estimation.uncertainty import at_bound, block_bootstrap, interval_of
from booster_ros.model.catalogue import EFFECTS

RNG = np.random.default_rng(5)
BLOCKS, ROWS = 240, 5


def normal(*shape):
    """Return standard normal numbers, the same in each test."""
    return np.random.default_rng(7).standard_normal(shape)


def linear(noise, low=-np.inf, priors=(np.inf, np.inf)):
    """Return problem, fit and blocks of a line of two variables through noise, (blocks, rows)."""
    rng = np.random.default_rng(8)
    design = rng.standard_normal((BLOCKS * ROWS, 2)) @ np.array([[1.0, 0.6], [0.0, 0.8]])
    prior = np.diag([1.0 / sigma for sigma in priors])[np.isfinite(priors)]
    hessian = design.T @ design + prior.T @ prior
    z = np.maximum(np.linalg.solve(hessian, design.T @ noise.ravel()), low)
    rows = np.arange(BLOCKS * ROWS)
    free = tuple(SimpleNamespace(knob=SimpleNamespace(shape=False), sigma=one) for one in priors)
    problem = SimpleNamespace(freedoms=free, observed=len(rows), first_rows=(rows,),
                              bounds=lambda: (np.full(2, low), np.full(2, np.inf)))
    jacobian = np.vstack([-design, prior])
    residuals = np.concatenate([noise.ravel() - design @ z, prior @ z])
    made = SimpleNamespace(z=z, residuals=residuals, jacobian=jacobian, seen=np.ones(2, bool))
    return problem, made, rows // ROWS


def test_of_white_noise_the_bootstrap_has_the_covariance_of_least_squares():
    problem, made, blocks = linear(normal(BLOCKS, ROWS))
    draws = block_bootstrap(problem, made, blocks)
    expected = np.linalg.inv(made.jacobian.T @ made.jacobian)
    scale = np.sqrt(np.diag(expected))
    assert np.cov(draws.T) / np.outer(scale, scale) == pytest.approx(
        expected / np.outer(scale, scale), abs=0.3)
    assert np.mean(draws, axis=0) == pytest.approx(made.z, abs=0.3 * scale.max())


def test_of_noise_that_lasts_for_a_block_it_is_as_wide_as_blocks_are_apart():
    """Its covariance is H^-1 (sum of g g') H^-1 (H. White, Econometrica 48 (1980) 817)."""
    lasting = np.repeat(2.0 * normal(BLOCKS, 1), ROWS, axis=1)
    problem, made, blocks = linear(lasting + 0.1 * normal(BLOCKS, ROWS))
    gradients = np.array([made.jacobian[blocks == k].T @ made.residuals[blocks == k]
                          for k in range(BLOCKS)])
    inverse = np.linalg.inv(made.jacobian.T @ made.jacobian)
    expected = inverse @ (gradients.T @ gradients) @ inverse
    found = np.std(block_bootstrap(problem, made, blocks), axis=0)
    assert found == pytest.approx(np.sqrt(np.diag(expected)), rel=0.2)


def test_what_is_known_beforehand_is_drawn_as_well():
    """Where rows tell nothing of a parameter, it is as unsure as it was."""
    problem, made, blocks = linear(normal(BLOCKS, ROWS), priors=(np.inf, 2.0))
    made.jacobian[:BLOCKS * ROWS, 1] = 0.0
    made.z[1] = made.residuals[-1] = 0.0
    draws = block_bootstrap(problem, made, blocks)
    assert np.std(draws[:, 1]) == pytest.approx(2.0, rel=0.15)


def test_a_size_that_a_bound_holds_back_may_be_as_large_as_one_that_just_shows():
    """The rows would rather have less than none of the first, by three times what they tell."""
    problem, made, blocks = linear(normal(BLOCKS, ROWS))
    told = 1.0 / np.linalg.norm(made.jacobian[:, 0])
    made.jacobian = np.column_stack([made.jacobian[:, 0], np.zeros(len(made.jacobian))])
    made.z = np.zeros(2)
    made.residuals += (3.0 * told - made.jacobian[:, 0] @ made.residuals * told**2
                       ) * made.jacobian[:, 0]
    problem.bounds = lambda: (np.zeros(2), np.full(2, np.inf))
    draws = block_bootstrap(problem, made, blocks)
    assert abs(np.mean(draws[:, 0])) < 0.2 * np.std(draws[:, 0])
    assert np.std(draws[:, 0]) == pytest.approx(told, rel=0.3)


@pytest.fixture(scope='module')
def leaking():
    """Return problem and fit of a leak alone to a record of a valve that leaks."""
    problem = problem_of(seen(put(P, 'actuator.leak_area', 3e-8)), 'chamber_leak', freedoms=())
    begin = problem.start()
    begin[0] = 0.3
    return problem, fit(problem, [begin])


def test_the_interval_of_a_leak_holds_it(leaking):
    problem, found = leaking
    draws = block_bootstrap(problem, found, (TIME // 3.0).astype(int))
    interval = interval_of(problem, draws, found, 0)
    assert interval.low < interval.value < interval.high
    assert abs(interval.value - 3e-8) < interval.high - interval.low < 0.2 * 3e-8
    assert interval.unit == 'm^2'


def test_statistics_of_windows_are_resampled_by_the_blocks_they_begin_in(leaking):
    problem, found = leaking
    by_windows = Problem(problem.experiment, problem.rows, problem.base, problem.freedoms, WINDOWS)
    begin = found.z.copy()
    last = fit(by_windows, [begin])
    draws = block_bootstrap(by_windows, last, (TIME // 3.0).astype(int))
    interval = interval_of(by_windows, draws, last, 0)
    assert abs(interval.value - 3e-8) < interval.high - interval.low


def made_fit(effect, z, draws):
    """Return a problem with one effect and a fit that stands at z, with these draws."""
    free = tuple(effect_freedom(EFFECTS[effect]))
    experiment = Experiment(TIME, np.zeros_like(TIME), {'chamber_pressure': np.zeros_like(TIME)},
                            {'chamber_pressure': 1.0}, {}, Initial(0.0))
    problem = Problem(experiment, np.ones(len(TIME), dtype=bool), P, free)
    z = np.append(z, np.zeros(problem.nuisances))
    draws = np.hstack([draws, np.zeros((len(draws), problem.nuisances))])
    return problem, draws, Fit(free, z, P, Initial(0.0), 0.0, np.zeros(len(TIME)),
                               np.ones((len(TIME), len(z))))


@pytest.mark.parametrize(('share', 'said'), [
    (1.0, True), (0.995, True), (0.9, False), (0.0, False)])
def test_a_size_at_its_bound_is_told_from_one_that_is_none(share, said):
    (free,) = effect_freedom(EFFECTS['dead_time'])
    assert at_bound(free, share * free.high) is said


def test_the_interval_of_a_stiffness_that_may_be_rigid_holds_its_value():
    knob = next(k for k in EFFECTS['stem_friction'].knobs if k.inverse)
    softness = 1.0 / knob.typical  # z is softness in those of the typical stiffness
    z = (1.0 / 3.6e6) / softness
    free = effect_freedom(EFFECTS['stem_friction'])
    index = next(j for j, f in enumerate(free) if f.knob is knob)
    draws = np.zeros((400, len(free)))
    draws[:, index] = z + 2.0 * z * RNG.standard_normal(400)
    where = np.zeros(len(free))
    where[index] = z
    problem, draws, fit = made_fit('stem_friction', where, draws)
    found = interval_of(problem, draws, fit, index)
    assert found.value == pytest.approx(3.6e6)
    assert knob.low <= found.low < 1.5e6
    assert found.open_above
    assert not found.is_none


def test_the_interval_of_a_stiffness_that_was_found_rigid_says_from_where_it_may_be():
    """Not that it lies between rigid, which is 0, and that: what is softer is excluded."""
    free = effect_freedom(EFFECTS['stem_friction'])
    index = next(j for j, f in enumerate(free) if f.knob.inverse)
    draws = np.zeros((400, len(free)))
    draws[:, index] = np.abs(0.1 * RNG.standard_normal(400))
    problem, draws, fit = made_fit('stem_friction', np.zeros(len(free)), draws)
    found = interval_of(problem, draws, fit, index)
    assert found.value == 0.0
    assert found.is_none
    assert found.low == pytest.approx(free[index].knob.typical / 0.2, rel=0.1)
    assert found.holds_none(free[index].knob)


def test_skewed_draws_give_an_interval_that_is_as_long_on_either_side():
    free = effect_freedom(EFFECTS['chamber_leak'])
    draws = np.zeros((400, len(free)))
    draws[:, 0] = 2.0 + RNG.exponential(0.2, 400)
    problem, draws, fit = made_fit('chamber_leak', np.append(2.0, np.zeros(len(free) - 1)), draws)
    found = interval_of(problem, draws, fit, 0)
    assert found.value - found.low == pytest.approx(found.high - found.value)
    assert found.high == pytest.approx(free[0].value(2.0 + 0.2 * np.log(20.0)), rel=0.02)
