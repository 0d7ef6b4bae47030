# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Screening: a quick joint fit of every effect with the declared parameters.

Around a reference fit with residuals r(z) and Jacobian J of its variables z, an effect adds
variables e. Judging an effect by how alike its trace and the residual are misleads, because the
declared parameters can imitate part of it. So what they can imitate is projected off:

1. for each of a few sizes e of the effect, simulate once and form the residuals r(z, e);
2. let the reference variables react linearly: z <- z - J+ r, priors included; what remains is its
   cost;
3. what remains runs nearly straight from size 0 to e, which tells the size at which it should be
   least: of the trials that promise most there, simulate four at that size;
4. linear reckoning fails where the variables react by much. So, for the effects that do best, the
   first steps of a fit follow from the best size around each reference, begun with J and the
   effect's own columns simulated there (`first_steps`). A joint fit begins where they end.

For one small size, on every row, this is the score test of an effect (C. R. Rao, Proc. Camb. Phil.
Soc. 44 (1948) 50).
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
import itertools

import numpy as np

from booster_ros.diagnosis.data.experiment import Array
from booster_ros.diagnosis.estimation.fit import FIRST_STEPS, Fit, fit, fit_at
from booster_ros.diagnosis.estimation.parametrisation import TOLD_AT_REST, Free
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.diagnosis.hypotheses.compose import with_effect
from booster_ros.diagnosis.hypotheses.friction import can_be
from booster_ros.diagnosis.selection.decide import TIE
from booster_ros.model.catalogue import EFFECTS
from booster_ros.numerics.least_squares import straight
from booster_ros.signals.periodogram import periodogram

SIZES = (0.25, 1.0, 3.0)
"""Multiples of the typical size that are tried; both signs where the effect has two."""

BEST = 4
"""Number of the best ones that go on: of trials, to be simulated at the size at which they should
leave least; of effects and terms, to be fitted to their end."""

LONGEST = 2.0
"""Largest multiple of a size that was tried up to which what it does is taken to run straight."""

ABOVE_NOISE = 15.0
"""Multiple of the median power above which a line stands out: of noise, 1 in 30000 does."""

PADDING = 8
"""
Number of parts of the frequency step that the record's length resolves, to which frequencies are
told. Half of that step off, an oscillation ends as far out of phase as can be, and a fit stops at
the wrong frequency.
"""


@dataclass(frozen=True)
class Screened:
    """An effect, its problem, and where to fit from, best first: cost, z, and reference."""

    effect: str
    problem: Problem
    starts: tuple[tuple[float, Array, 'Reference'], ...]

    @property
    def cost(self) -> float:
        """The least cost seen."""
        return self.starts[0][0] if self.starts else float('inf')


def _with_sizes(problem: Problem, z: Array, e: Array) -> Array:
    """Return z with the effect's variables between those of the parameters and of the start."""
    size = len(z) - problem.nuisances
    return np.concatenate([z[:size], e, z[size:]])


def _no_size(free: tuple[Free, ...]) -> Array:
    """Return the variables of an effect of no size, its shapes at their typical values."""
    return np.array([f.without_size for f in free])


def _sizes_to_try(free: tuple[Free, ...], frequencies: Iterable[float], multiples: tuple[float, ...]
                  ) -> list[Array]:
    """Return the sizes of the effect's variables to try: each alone, and the sizes together."""
    if any(f.knob.frequency for f in free):
        return _oscillations(free, frequencies)
    sizes = [j for j, f in enumerate(free) if not f.knob.shape]
    steps = [size * sign for size in multiples for sign in (1.0, -1.0)]
    moves = [{j: step} for j in sizes for step in steps]
    if len(multiples) > 1 and len(sizes) == 2:
        moves += [dict.fromkeys(sizes, size) for size in multiples]
        if all(free[j].knob.inverse for j in sizes):
            # two limits: where one is hard, the other shows only near its size
            moves += [dict(zip(sizes, both)) for both in itertools.permutations(multiples, 2)]
    possible = [move for move in moves if can_be(free, move)]
    trials = []
    for shaped, move in itertools.product(_shapes_to_try(free), possible):
        e = shaped.copy()
        for j, step in move.items():
            e[j] += step
        if all(f.low <= value <= f.high for f, value in zip(free, e)):
            trials.append(e)
    return trials


def _shapes_to_try(free: tuple[Free, ...]) -> list[Array]:
    """Return the effect's variables at no size, with each of the shapes that are to be tried."""
    values = [[f.variable(value) for value in f.knob.tried] or [none]
              for f, none in zip(free, _no_size(free))]
    return [np.array(shaped) for shaped in itertools.product(*values)]


def _oscillations(free: tuple[Free, ...], frequencies: Iterable[float]) -> list[Array]:
    """Return trials of an oscillation: the residual's strongest frequencies, four phases."""
    trials = []
    for frequency, phase in itertools.product(frequencies, (0.0, 1.571, 3.142, -1.571)):
        e = _no_size(free)
        for j, f in enumerate(free):
            if f.knob.frequency:
                e[j] = f.variable(frequency)
            elif f.knob.phase:
                e[j] = f.variable(phase)
            elif not f.knob.shape:
                e[j] += 0.5
        trials.append(e)
    return trials


def strong_frequencies(problem: Problem, z: Array) -> Array:
    """Return the strongest frequencies, Hz, four at most, in what the first channel leaves."""
    predicted = problem.predict(z)
    time = problem.experiment.time
    if predicted is None or len(time) < 32:
        return np.empty(0)
    name = problem.experiment.channels[0]
    residual = np.where(problem.rows, problem.experiment.measured[name] - predicted[name], 0.0)
    even = np.linspace(time[0], time[-1], len(time))  # thinned rows are dense where steps are
    residual = np.interp(even, time, np.nan_to_num(residual))
    frequency, power = periodogram(residual, even[1] - even[0], PADDING)
    lines = np.maximum(power - ABOVE_NOISE * float(np.median(power)), 0.0)
    lines[(frequency < 0.02) | (frequency > 15.0)] = 0.0
    # a chamber that fills in seconds damps fast ripple: weigh the residual by its rate
    weighted = lines * frequency**2
    found = []
    for ranking in (weighted, lines):
        ranking = ranking.copy()
        for _ in range(2):
            k = int(np.argmax(ranking))
            found.append(float(frequency[k]))
            ranking[max(k - 3 * PADDING, 0):k + 3 * PADDING + 1] = 0.0
    return np.array(sorted(set(found) - {0.0}))


@dataclass(frozen=True)
class Reference:
    """A fit around which the declared parameters react linearly."""

    z: Array
    jacobian: Array
    factors: tuple[Array, Array]
    room: tuple[Array, Array]
    residuals: Array
    left: Array

    def reaction(self, r: Array) -> Array:
        """Return the step of z that leaves least of residuals r, within the bounds."""
        return straight(*self.factors, r, self.room)


@dataclass(frozen=True)
class _Trial:
    """Variables at a tried size, their cost, and the size on that way that promises the least."""

    z: Array
    cost: float
    length: Array
    promised: float


def reference_at(problem: Problem, found: Fit) -> Reference:
    """Return the reference that a fit of the problem is."""
    low, high = problem.bounds()
    bare = Reference(found.z, found.jacobian, np.linalg.qr(found.jacobian),
                     (low - found.z, high - found.z), found.residuals, found.residuals)
    return replace(bare, left=found.residuals + found.jacobian @ bare.reaction(found.residuals))


def references(problem: Problem, found: Fit) -> list[Reference]:
    """
    Return what to screen around: the fit, and the same effects with what is told at rest fitted.

    A refit without the effect may have bent the declared parameters to imitate it, so that the true
    ones are out of linear reach; the given ones are near them. But a pressure that is off at every
    rest hides what those lack, unless the measured stem drives: then nothing else shifts the rests.
    What has to be further off than is known of it imitates what does: then also as given.
    """
    if not any(free.as_given for free in problem.freedoms):
        return [reference_at(problem, found)]
    given = problem.start()
    for j, free in enumerate(problem.freedoms):
        if not free.as_given:
            given[j] = found.z[j]
    at_rest = [j for j, free in enumerate(problem.freedoms)
               if free.knob.parameter in TOLD_AT_REST and np.isfinite(free.sigma)]
    places = [given]
    if at_rest and not problem.experiment.pinned_within:
        rested = _refitted(problem, given, at_rest)
        far = 0.5 * float(np.sum(rested[at_rest]**2)) > TIE
        places = [rested, given] if far else [rested]
    return [reference_at(problem, found),
            *(reference_at(problem, fit_at(problem, place)) for place in places)]


def _refitted(problem: Problem, z: Array, which: list[int]) -> Array:
    """Return z with these freedoms, and the start, fitted from there."""
    size = len(problem.freedoms)
    some = replace(problem, base=problem.parameters(z), freedoms=tuple(
        problem.freedoms[j] for j in which))
    free = np.r_[which, size:len(z)]
    found = z.copy()
    found[free] = fit(some, [z[free]]).z
    return found


def screen(problem: Problem, around: list[Reference], name: str, frequencies: Iterable[float] = (),
           multiples: tuple[float, ...] = SIZES) -> Screened:
    """Return the best of some sizes of an effect on top of a fitted problem, for each reference."""
    joint = with_effect(problem, EFFECTS[name])
    free = joint.freedoms[len(problem.freedoms):]
    found = []
    for reference in around:
        trials = [_tried(problem, joint, reference, e)
                  for e in _sizes_to_try(free, frequencies, multiples)]
        trials += [_tried(problem, joint, reference, trial.length) for trial in sorted(
            trials, key=lambda trial: trial.promised)[:BEST]]
        if trials:
            best = min(trials, key=lambda trial: trial.cost)
            found.append((best.cost, np.clip(best.z, *joint.bounds()), reference))
    return Screened(name, joint, tuple(sorted(found, key=lambda one: one[0])))


def first_steps(problem: Problem, quick: Screened) -> Fit:
    """Return where first steps lead from the starts of a screened effect: the best of these."""
    inner = range(len(problem.freedoms), len(quick.problem.freedoms))
    found = []
    for _, start, reference in quick.starts:
        slopes = np.insert(reference.jacobian, [inner.start] * len(inner), 0.0, axis=1)
        slopes[:, inner] = quick.problem.differences(
            start, quick.problem.residuals(start), inner,
            np.full(len(start), quick.problem.first_step))
        found.append(fit(quick.problem, [start], FIRST_STEPS, slopes=slopes))
    return min(found, key=lambda one: one.cost)


def _reach(problem: Problem, joint: Problem, reference: Reference, e: Array
           ) -> tuple[Array, Array]:
    """Return what remains of the residuals at sizes e when all else reacts, and z there."""
    r = joint.residuals(_with_sizes(problem, reference.z, e))
    step = reference.reaction(r)
    return r + reference.jacobian @ step, _with_sizes(problem, reference.z + step, e)


def _tried(problem: Problem, joint: Problem, reference: Reference, e: Array) -> _Trial:
    """Return what sizes e reach, and what is promised on the way from no size to e and beyond."""
    free = joint.freedoms[len(problem.freedoms):]
    left, z = _reach(problem, joint, reference, e)
    change = left - reference.left
    share = -float(reference.left @ change) / max(float(change @ change), 1e-300)
    share = min(max(share, 0.0), LONGEST)
    neutral = np.where([f.knob.shape for f in free], e, _no_size(free))
    length = np.clip(neutral + share * (e - neutral), [f.low for f in free], [f.high for f in free])
    promised = reference.left + share * change
    return _Trial(z, float(left @ left), length, float(promised @ promised))
