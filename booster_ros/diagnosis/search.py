# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The search for what the model lacks.

Model: the declared model with its parameters refitted within their priors, plus at most three
named effects. Numbered as carried out:

1. refit the declared parameters on the fit segments;
2. screen every effect in the catalogue by a quick joint fit (see screening) on a thinned record;
3. fit the most promising jointly with the declared parameters, on the fit segments;
4. score them on the select segments; the score is the sum of squared scaled residuals and of the
   departures that the priors of the declared parameters hold against a model;
5. keep the best few and go on from 2 for a second and a third effect while the score falls by
   more than one standard error (paired, over segments) and by a share that matters;
6. try to leave out every effect again (backward);
7. of models whose scores are not told apart, the one with the fewest effects is taken.
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
import os

import numpy as np

from booster_ros.diagnosis.experiment import Experiment
from booster_ros.diagnosis.fit import Fit, Free, Problem
from booster_ros.diagnosis.screening import (
    Screened, references, screen, strong_frequencies, with_effect)
from booster_ros.diagnosis.segments import Segment, rows_of
from booster_ros.model.catalogue import EFFECTS
from booster_ros.model.system import PositionerParameters

Array = np.ndarray

NEAR_NOISE = 1.1
"""Mean square misfit below which no further effect is looked for."""

EVALUATIONS = 10
"""Steps of one fit."""

MOST_EFFECTS = 3
FINALISTS = 4
"""Effects per round that are fitted in full."""

WORTH_ADDING = 0.05
"""An effect must lower the score by this share: less is below what noise and rounding hide."""

TOO_SIMILAR = 0.01
"""Models whose scores differ by less than this share are not told apart by a record."""

THINNING = 8
THINNING_FITS = 5
"""Screening uses every eighth row, fits every fifth (all rows where the drive jumps)."""

ENOUGH_ROWS = 1500
"""Records are not thinned to fewer rows: a short sweep is used whole."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """A model: its effects, its fit, and how it scores on the select segments."""

    effects: tuple[str, ...]
    problem: Problem
    fit: Fit
    by_segment: Array
    prior: float
    samples: int

    @property
    def score(self) -> float:
        """Sum of squares on the select segments plus the prior's share."""
        return float(self.by_segment.sum()) + self.prior

    @property
    def misfit(self) -> float:
        """Mean square of the scaled residuals on the select segments: 1 is noise."""
        return float(self.by_segment.sum()) / max(self.samples, 1)


def gain(worse: Candidate, better: Candidate) -> tuple[float, float]:
    """Return by how much the score falls, and the standard error of that, paired by segment."""
    difference = worse.by_segment - better.by_segment
    error = float(np.std(difference, ddof=1) * np.sqrt(len(difference))) if len(
        difference) > 1 else 0.0
    return worse.score - better.score, error


def clearly_better(better: Candidate, worse: Candidate, share: float = WORTH_ADDING) -> bool:
    """Tell whether the score falls by more than one standard error and by `share`."""
    fall, error = gain(worse, better)
    return fall > error and fall > share * worse.score


@dataclass(frozen=True, eq=False)
class Search:
    """The task: experiment, segments, declared parameters and their freedom."""

    experiment: Experiment
    segments: list[Segment]
    declared: PositionerParameters
    freedoms: tuple[Free, ...]
    names: tuple[str, ...] = tuple(EFFECTS)

    def rows_and_experiment(self, roles: tuple[str, ...], factor: int) -> tuple[Array, Experiment]:
        """Return the rows of these roles and the experiment, both thinned by `factor`."""
        size = len(self.experiment.time)
        rows = rows_of(self.segments, roles, size)
        factor = min(factor, size // ENOUGH_ROWS)
        if factor <= 1:
            return rows, self.experiment
        thin, kept = self.experiment.thinned(factor)
        return rows[kept], thin

    def on(self, problem: Problem, roles: tuple[str, ...], factor: int) -> Problem:
        """Return the same problem on segments of these roles, every `factor`-th row."""
        rows, experiment = self.rows_and_experiment(roles, factor)
        return replace(problem, experiment=experiment, rows=rows)

    def problem(self) -> Problem:
        """Return the refit of the declared parameters on the fit segments."""
        rows, experiment = self.rows_and_experiment(('fit',), THINNING_FITS)
        return Problem(experiment, rows, self.declared, self.freedoms)

    def rate(self, effects: tuple[str, ...], problem: Problem, fit: Fit) -> Candidate:
        """Return the fit as a candidate, scored on the select segments."""
        predicted = self.on(problem, ('select',), 1).predict(fit.z)
        sums, samples = [], 0
        for segment in self.segments:
            if segment.role != 'select':
                continue
            total = 0.0
            for name, measured in self.experiment.measured.items():
                part = slice(segment.first, segment.last)
                scaled = (measured[part] - predicted[name][part]) / self.experiment.noise[name] \
                    if predicted is not None else np.full(segment.last - segment.first, np.inf)
                scaled = scaled[np.isfinite(measured[part])]
                total += float(scaled @ scaled)
                samples += len(scaled)
            sums.append(total)
        prior = sum((z / free.sigma) ** 2 for z, free in zip(fit.z, fit.freedoms)
                    if np.isfinite(free.sigma))
        return Candidate(effects, problem, fit, np.array(sums), float(prior), samples)

    def refit(self) -> Candidate:
        """Return the declared model refitted."""
        problem = self.problem()
        return self.rate((), problem, problem.fit(evaluations=EVALUATIONS))

    def joint(self, problem: Problem, effects: tuple[str, ...]) -> Problem:
        """Return the problem with all these effects free."""
        for name in effects:
            problem = with_effect(problem, EFFECTS[name])
        return problem

    def carried(self, source: Candidate, target: Problem) -> Array:
        """Return z of `target` with the values that its parameters have in `source`."""
        known = {(f.knob.parameter, f.element): z
                 for f, z in zip(source.problem.freedoms, source.fit.z)}
        body = [known.get((f.knob.parameter, f.element), 0.0) for f in target.freedoms]
        return np.concatenate([body, source.fit.z[len(source.problem.freedoms):]])

    def thorough(self, problem: Problem, z: Array) -> Fit:
        """
        Return the better of two fits: from z, and from its effects with all else as given.

        The way from the refit without an effect can end in a corner of the declared parameters,
        where they imitated the effect; the way from the given ones does not begin there.
        """
        first = problem.fit(z, evaluations=EVALUATIONS)
        if first.cost < NEAR_NOISE * problem.rows_counted():
            return first
        fresh = first.z.copy()
        fresh[:len(self.freedoms)] = 0.0
        fresh[len(problem.freedoms):] = 0.0
        second = problem.fit(fresh, evaluations=EVALUATIONS)
        return min(first, second, key=lambda fit: fit.cost)

    def extend(self, parent: Candidate, tick: Callable[[], None]) -> list[Candidate]:
        """Return the best models with one effect more than `parent`, best first."""
        thin = self.on(parent.problem, ('fit',), THINNING)
        around = references(thin, thin.at(parent.fit.z))
        frequencies = strong_frequencies(thin, parent.fit.z)
        names = [name for name in self.names if name not in parent.effects and
                 not redundant(name, parent.effects)]

        def one(name: str) -> Screened:
            found = screen(thin, around, name, frequencies)
            tick()
            return found

        with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
            screened = sorted(pool.map(one, names), key=lambda s: s.cost)
        found = []
        for quick in screened[:FINALISTS]:
            joint = with_effect(parent.problem, EFFECTS[quick.effect])
            fit = self.thorough(joint, quick.z)
            found.append(self.rate((*parent.effects, quick.effect), joint, fit))
            tick()
        return preferred_first(found)


def preferred_first(candidates: list[Candidate]) -> list[Candidate]:
    """
    Return the candidates by score; of those not told apart from the best, the plainest first.

    Plainest: fewest parameters, then the order of the catalogue, which lists common causes first.
    """
    ranked = sorted(candidates, key=lambda c: c.score)
    if not ranked:
        return ranked
    ties = [c for c in ranked if not told_apart(c, ranked[0])]
    order = list(EFFECTS)

    def plainness(c: Candidate) -> tuple[int, int]:
        return len(c.problem.freedoms), sum(order.index(e) for e in c.effects)

    ties.sort(key=plainness)
    return ties + [c for c in ranked if c not in ties]


def told_apart(worse: Candidate, better: Candidate) -> bool:
    """Tell whether the record prefers one model: by a standard error and a share that matters."""
    fall, error = gain(worse, better)
    return fall > TOO_SIMILAR * better.score and fall > error


def redundant(name: str, present: tuple[str, ...]) -> bool:
    """Tell whether an effect has no parameter that the present ones do not have already."""
    have = {knob.parameter for other in present for knob in EFFECTS[other].knobs}
    return all(knob.parameter in have for knob in EFFECTS[name].knobs)
