# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The score of a fitted model: its evidence, and what it leaves of each block.

With the residuals r of the observations and their Jacobian J at the estimate z, the precision P of
what is known of z beforehand, and the over-dispersion c,

    log Z = -1/2 (|r|²/c + z'Pz) + 1/2 log det P - 1/2 log det(J'J/c + P)

is Laplace's approximation to the evidence (D. MacKay, Neural Computation 4 (1992) 415).

What no candidate explains is an error of all of them: real valves differ from every model, and
what is left is neither white nor of the size of the noise. So likelihoods are tempered by c, the
over-dispersion and autocorrelation of what the best candidate leaves (quasi-likelihood: P.
McCullagh and J. Nelder, Generalized Linear Models, 1989, 4.5; J. Miller and D. Dunson, JASA 114
(2019) 1113). With a perfect model c is 1.
"""

from dataclasses import dataclass, field

import numpy as np

from booster_ros.diagnosis.data.experiment import FEWEST, Array
from booster_ros.diagnosis.estimation.fit import Fit
from booster_ros.diagnosis.estimation.problem import DIFFERENCE, Problem
from booster_ros.numerics.parallel import side_by_side
from booster_ros.signals.dispersion import dispersion

LARGE = 9.0
"""Square of a residual, or mean of these, in squares of the noise, from which on it is large."""


@dataclass(frozen=True, eq=False)
class Score:
    """
    What the evidence of a fitted model needs, for any c, and what it leaves by block.

    `cost` and `prior` are the sums of squares of observations and of what is known beforehand,
    `costs`, shape (blocks,), those of the observations of each block; `information` is J'J over the
    k variables that do not stand at a bound, shape (k, k), `precision` (k,) that of their priors.
    `dispersion` is c of this model alone. `luck` is by how much half the cost differs where the
    same model runs otherwise by chance: that much of a difference of likelihoods means nothing.
    """

    cost: float
    prior: float
    observed: int
    dispersion: float
    costs: Array = field(repr=False)
    information: Array = field(repr=False)
    precision: Array = field(repr=False)
    luck: float = 0.0

    def log_evidence(self, c: float = 1.0) -> float:
        """Return log Z, tempered by c."""
        posterior = self.information / c + np.diag(self.precision)
        _, logarithm = np.linalg.slogdet(posterior)
        return float(-0.5 * (self.cost / c + self.prior)
                     + 0.5 * np.sum(np.log(self.precision)) - 0.5 * logarithm)


def score_of(problem: Problem, fit: Fit, block_of_row: Array) -> Score:
    """Return the score of a fit; `block_of_row` says of each row in which block it is."""
    data = problem.observed
    residuals, jacobian = _bursts_bounded(problem, fit.residuals[:data]), fit.jacobian[:data]
    low, high = problem.bounds()
    inside = (fit.z - low > 1e-9) & (high - fit.z > 1e-9)
    jacobian = jacobian[:, inside]
    deviation = np.array([free.prior_deviation(one) for free, one in zip(problem.freedoms, fit.z)]
                         + [*problem.sigma[len(problem.freedoms):]])[inside]
    label = np.concatenate([block_of_row[rows] for rows in problem.first_rows])
    costs = np.bincount(label, residuals**2)
    return Score(float(residuals @ residuals), float(np.sum(fit.residuals[data:]**2)), data,
                 dispersion(problem.series(residuals)), costs, jacobian.T @ jacobian,
                 1.0 / deviation**2, _luck_of(problem, fit))


def _bursts_bounded(problem: Problem, residuals: Array) -> Array:
    """
    Return residuals whose squares grow by their logarithm from LARGE on, where chance is at work.

    One pulse more or less before a move is a burst of large residuals in it, and no evidence
    (Cauchy's loss).
    """
    if not problem.experiment.chance:
        return residuals
    return np.asarray(np.sign(residuals) * np.sqrt(LARGE * np.log1p(residuals**2 / LARGE)))


def _luck_of(problem: Problem, fit: Fit) -> float:
    """Return the root mean square of what next to no change of z changes of half the cost."""
    if not problem.experiment.chance:
        return 0.0

    def cost(residuals: Array) -> float:
        return float(np.sum(_bursts_bounded(problem, residuals)**2))

    near = fit.z + DIFFERENCE * np.random.default_rng(1).standard_normal((FEWEST, len(fit.z)))
    here = cost(fit.residuals)
    costs = side_by_side(lambda z: cost(problem.residuals(z)), np.clip(near, *problem.bounds()))
    return 0.5 * float(np.sqrt(np.mean((np.array(costs) - here)**2)))
