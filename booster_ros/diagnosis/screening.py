# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Screening: a quick joint fit of every effect with the declared parameters.

Model: around a reference fit with residuals r(z) and Jacobian J of its variables z, an effect adds
variables e. Judging an effect by how alike its trace and the residual are misleads, because the
declared parameters can imitate part of it. So what they can imitate is projected off:

1. for each of a few sizes e of the effect, simulate once and form the residuals r(z, e);
2. let the reference variables react linearly: z ← z - J⁺ r, priors included; what remains is the
   cost this size can reach;
3. from the best size on, Gauss-Newton steps in (z, e) with the columns of e renewed and J kept.
"""

from dataclasses import dataclass
import itertools

import numpy as np
from scipy.signal import periodogram

from booster_ros.diagnosis.fit import DIFFERENCE, Fit, Free, Problem, effect_freedom
from booster_ros.model.catalogue import EFFECTS, Effect

Array = np.ndarray

SIZES = (0.25, 1.0, 3.0)
"""Multiples of the typical size that are tried; both signs where the effect has two."""

STEPS = 4
"""Gauss-Newton steps of a quick fit."""

_DAMPING = 1e-3


@dataclass(frozen=True)
class Screened:
    """An effect, the problem with it added, where the quick fit ended and its cost there."""

    effect: str
    problem: Problem
    z: Array
    cost: float


def with_effect(problem: Problem, effect: Effect) -> Problem:
    """Return the problem with the effect's parameters free, behind those it has."""
    present = {(f.knob.parameter, f.element) for f in problem.freedoms}
    added = tuple(f for f in effect_freedom(effect) if (f.knob.parameter, f.element) not in present)
    return Problem(problem.experiment, problem.rows, problem.base, problem.freedoms + added)


def _insert(problem: Problem, z: Array, e: Array) -> Array:
    """Return z with the effect's variables between parameters and the start's."""
    size = len(z) - problem.nuisances
    return np.concatenate([z[:size], e, z[size:]])


def _trials(free: tuple[Free, ...], frequencies: Array) -> list[Array]:
    """Return the sizes of the effect's variables to try: each alone, and the sizes together."""
    if any(f.knob.parameter == 'supply.ripple_frequency' for f in free):
        return _oscillations(free, frequencies)
    neutral = np.array([
        f.variable(f.knob.typical) if f.knob.shape else
        0.0 if f.knob.inverse else f.variable(f.knob.neutral) for f in free])
    sizes = [j for j, f in enumerate(free) if not f.knob.shape]
    steps = [size * sign for size in SIZES for sign in (1.0, -1.0)]
    moves = [{j: step} for j in sizes for step in steps]
    if len(sizes) > 1:
        moves += [dict(zip(sizes, pair)) for pair in itertools.product(SIZES, repeat=len(sizes))]
    trials = []
    for move in moves:
        e = neutral.copy()
        for j, step in move.items():
            e[j] += step
        if all(f.low <= value <= f.high for f, value in zip(free, e)):
            trials.append(e)
    return trials


def _oscillations(free: tuple[Free, ...], frequencies: Array) -> list[Array]:
    """Return trials of an oscillation: the residual's strongest frequencies, four phases."""
    names = [f.knob.parameter for f in free]
    trials = []
    for frequency in frequencies:
        for phase in (0.0, 1.571, 3.142, -1.571):
            e = np.zeros(len(free))
            e[names.index('supply.ripple')] = 0.5
            e[names.index('supply.ripple_frequency')] = free[
                names.index('supply.ripple_frequency')].variable(frequency)
            e[names.index('supply.ripple_phase')] = free[
                names.index('supply.ripple_phase')].variable(phase)
            trials.append(e)
    return trials


def strong_frequencies(problem: Problem, z: Array, count: int = 3) -> Array:
    """Return the strongest frequencies, Hz, in the residual of the first channel."""
    predicted = problem.predict(z)
    time = problem.experiment.time
    if predicted is None or len(time) < 32:
        return np.array([0.5])
    name = problem.experiment.channels[0]
    residual = np.nan_to_num(problem.experiment.measured[name] - predicted[name])
    frequency, power = periodogram(
        residual, fs=(len(time) - 1) / (time[-1] - time[0]), window='hann', detrend='linear')
    # a chamber that fills in seconds damps fast ripple: weigh the residual by its rate
    weighted = power * frequency**2
    weighted[(frequency < 0.02) | (frequency > 15.0)] = 0.0
    found = []
    for _ in range(count):
        k = int(np.argmax(weighted))
        found.append(frequency[k])
        weighted[max(k - 3, 0):k + 4] = 0.0
    return np.array(found)


@dataclass(frozen=True)
class _Reference:
    """A fit around which the declared parameters react linearly."""

    z: Array
    jacobian: Array
    solver: Array


def _reference(fit: Fit) -> _Reference:
    return _Reference(fit.z, fit.jacobian, np.linalg.pinv(fit.jacobian, rcond=1e-8))


def references(problem: Problem, fit: Fit) -> list[_Reference]:
    """
    Return what to screen around: the fit, and the parameters as given.

    A refit without the effect may have bent the declared parameters so far to imitate it that
    the true ones are out of linear reach; the given ones are near them.
    """
    return [_reference(fit), _reference(problem.at(problem.start()))]


def screen(problem: Problem, around: list[_Reference], name: str, frequencies: Array) -> Screened:
    """Return the quick joint fit of one effect on top of a fitted problem."""
    joint = with_effect(problem, EFFECTS[name])
    where = len(problem.freedoms)
    free = joint.freedoms[where:]
    low, high = joint.bounds()
    best = Screened(name, joint, joint.start(), float('inf'))
    jacobian = around[0].jacobian
    for reference in around:
        for e in _trials(free, frequencies):
            r = joint.residuals(_insert(problem, reference.z, e))
            step = -reference.solver @ r
            cost = float(np.sum((r + reference.jacobian @ step) ** 2))
            if cost < best.cost:
                z = np.clip(_insert(problem, reference.z + step, e), low, high)
                best = Screened(name, joint, z, cost)
                jacobian = reference.jacobian
    if not np.isfinite(best.cost):
        return best
    return _improve(joint, best, jacobian, where, low, high)


def _improve(joint: Problem, start: Screened, jacobian: Array, where: int, low: Array,
             high: Array) -> Screened:
    """Return the quick fit after a few Gauss-Newton steps; only the effect's columns are new."""
    added = len(joint.freedoms) - where
    z = start.z
    r = joint.residuals(z)
    cost = float(r @ r)
    for _ in range(STEPS):
        columns = []
        for j in range(where, where + added):
            moved = z.copy()
            step = DIFFERENCE if z[j] + DIFFERENCE <= high[j] else -DIFFERENCE
            moved[j] += step
            columns.append((joint.residuals(moved) - r) / step)
        full = np.concatenate(
            [jacobian[:, :where], np.array(columns).T, jacobian[:, where:]], axis=1)
        normal = full.T @ full
        move = np.linalg.solve(
            normal + _DAMPING * np.diag(np.diag(normal) + 1e-9), -full.T @ r)
        for share in (1.0, 0.4, 0.1):
            trial = np.clip(z + share * move, low, high)
            tried = joint.residuals(trial)
            if tried @ tried < cost:
                break
        if not tried @ tried < cost * (1.0 - 1e-3):
            break
        z, r, cost = trial, tried, float(tried @ tried)
    return Screened(start.effect, joint, z, cost)
