# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How sure a fitted parameter is, when residuals are coloured."""

import numpy as np

from booster_ros.diagnosis.fit import Fit, Problem
from booster_ros.diagnosis.segments import Segment

Array = np.ndarray

DRAWS = 400


def block_bootstrap(problem: Problem, fit: Fit, segments: list[Segment], seed: int = 1) -> Array:
    """
    Return draws of z, shape (DRAWS, variables), by a block bootstrap of whole segments.

    Each draw weighs the segments by how often they were drawn and makes one Gauss-Newton step from
    the fit. Residuals may be as coloured as they like within a segment.
    """
    residual = problem.residuals(fit.z)
    jacobian = fit.jacobian
    labels = []
    for measured in problem.experiment.measured.values():
        of_row = np.full(len(measured), -1)
        for k, segment in enumerate(segments):
            of_row[segment.first:segment.last] = k
        labels.append(of_row[problem.rows & np.isfinite(measured)])
    label = np.concatenate(labels)
    data = len(label)
    blocks = np.unique(label)
    size = len(fit.z)
    gradients = np.zeros((len(blocks), size))
    hessians = np.zeros((len(blocks), size, size))
    for b, k in enumerate(blocks):
        mask = np.flatnonzero(label == k)
        gradients[b] = jacobian[mask].T @ residual[mask]
        hessians[b] = jacobian[mask].T @ jacobian[mask]
    prior_gradient = jacobian[data:].T @ residual[data:]
    prior_hessian = jacobian[data:].T @ jacobian[data:]
    rng = np.random.default_rng(seed)
    draws = np.empty((DRAWS, size))
    ridge = 1e-9 * np.eye(size)
    for d in range(DRAWS):
        counts = np.bincount(rng.integers(len(blocks), size=len(blocks)), minlength=len(blocks))
        gradient = counts @ gradients + prior_gradient
        hessian = np.tensordot(counts, hessians, 1) + prior_hessian + ridge
        draws[d] = fit.z - np.linalg.solve(hessian, gradient)
    return draws


def interval_of(problem: Problem, draws: Array, fit: Fit, index: int) -> tuple[float, float, float]:
    """Return (value, low, high) of a variable as the parameter's value, 95 %, within bounds."""
    free = problem.freedoms[index]
    low, high = np.quantile(draws[:, index], [0.025, 0.975])
    # the draws centre on a step away from the fit where it stopped early: hold both
    ends = [free.value(float(np.clip(z, free.low, free.high)))
            for z in (min(low, fit.z[index]), max(high, fit.z[index]))]
    return free.value(fit.z[index]), min(ends), max(ends)
