# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The task of finding what a model lacks: fits of the declared model with effects, and their scores.

The course of the search is in selection; how a next effect is found, in next_effect.
"""

from dataclasses import dataclass, replace

import numpy as np

from booster_ros.diagnosis.experiment.experiment import Experiment
from booster_ros.diagnosis.experiment.segments import Segment, rows_of, segment_of_row
from booster_ros.diagnosis.fitting.descent import SETTLED
from booster_ros.diagnosis.fitting.fit import Fit, Problem
from booster_ros.diagnosis.fitting.freedom import BENCH, Free
from booster_ros.diagnosis.fitting.intervals import block_bootstrap, undetermined
from booster_ros.diagnosis.searching.candidate import Candidate
from booster_ros.diagnosis.searching.screening import with_effect
from booster_ros.model.actuator import has_dry_friction
from booster_ros.model.catalogue import EFFECTS
from booster_ros.model.system import PositionerParameters

Array = np.ndarray

PLACES = frozenset(effect.location for effect in EFFECTS.values())
"""All places where something can be missing."""

EVALUATIONS, LAST_EVALUATIONS = 10, 30
"""Steps of one fit, and of one that is to go to its very end."""

FAR_BEHIND = 10.0
"""Multiple of another model's mean square from which a model is no rival, and fitted no further."""

POLISHINGS = 4
WORTH_POLISHING, WORTH_A_LAST_POLISHING = 0.01, 0.001
"""
How many times a fit is given as many steps again, at the most, and the share by which that has to
lower its cost for it to go on; the second share is for a last fit.
"""

THINNING = 8
"""Fits use every eighth row, and all rows where the drive jumps."""

ENOUGH_ROWS = 1500
"""Records are not thinned to fewer rows: a short sweep is used whole."""


@dataclass(frozen=True, eq=False)
class Search:
    """
    The task: experiment, segments, declared parameters and their freedom.

    `names` are the effects to try, `places` where a term without a name is tried; a fit takes one
    of every `thinning` rows. What the methods return is scaled: residuals in standard deviations
    of the noise, costs in squares of that.
    """

    experiment: Experiment
    segments: list[Segment]
    declared: PositionerParameters
    freedoms: tuple[Free, ...]
    names: tuple[str, ...] = tuple(EFFECTS)
    places: frozenset[str] = PLACES
    thinning: int = THINNING

    def rows_and_experiment(self, roles: tuple[str, ...], factor: int) -> tuple[Array, Experiment]:
        """Return the rows of these roles and the experiment, both thinned by `factor`."""
        thin, kept = thinned(self.experiment, factor)
        return rows_of(self.segments, roles, len(self.experiment.time))[kept], thin

    def on(self, problem: Problem, roles: tuple[str, ...], factor: int) -> Problem:
        """Return the same problem on segments of these roles, every `factor`-th row."""
        rows, experiment = self.rows_and_experiment(roles, factor)
        return replace(problem, experiment=experiment, rows=rows)

    def problem(self) -> Problem:
        """Return the problem of refitting the declared parameters on the fit segments."""
        rows, experiment = self.rows_and_experiment(('fit',), self.thinning)
        return Problem(experiment, rows, self.declared, self.freedoms)

    def refitted(self, candidate: Candidate, fit: Fit) -> Candidate:
        """Return the model with another fit to the same rows; what is seen above the stem stays."""
        return replace(self.rate(candidate.effects, candidate.problem, fit),
                       confirmed=candidate.confirmed, lasting=candidate.lasting,
                       learnt=candidate.learnt)

    def rate(self, effects: tuple[str, ...], problem: Problem, fit: Fit) -> Candidate:
        """
        Return the fit as a candidate, scored on every row of the select segments.

        The score is infinite where the model cannot run.
        """
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
                # a run that was lost on the way has no values from there on
                scaled = np.where(np.isnan(scaled), np.inf, scaled)
                total += float(scaled @ scaled)
                samples += len(scaled)
            sums.append(total)
        prior = sum((z / free.sigma) ** 2 for z, free in zip(fit.z, fit.freedoms)
                    if np.isfinite(free.sigma))
        return Candidate(effects, problem, fit, np.array(sums), float(prior), samples)

    def values_held_back(self) -> Array:
        """Return how many values of each select segment are compared."""
        return np.array([
            sum(np.count_nonzero(np.isfinite(measured[segment.first:segment.last]))
                for measured in self.experiment.measured.values())
            for segment in self.segments if segment.role == 'select'])

    def refit(self) -> Candidate:
        """Return the declared model refitted."""
        problem = self.problem()
        return self.rate((), problem, problem.fit(evaluations=EVALUATIONS))

    def joint(self, problem: Problem, effects: tuple[str, ...]) -> Problem:
        """Return the problem with all these effects free; KeyError for one not in the catalogue."""
        for name in effects:
            problem = with_effect(problem, EFFECTS[name])
        return problem

    def without(self, chosen: Candidate, rest: tuple[str, ...]) -> Candidate:
        """
        Return the chosen model with only the effects `rest`, fitted from what they were.

        A second fit begins with all else as given, which may have moved to where only the other
        effects held it; not where the stem sticks, as that takes long. The better of the two is
        not carried to its end where it is far behind the chosen model.
        """
        problem = self.joint(self.problem(), rest)
        z = carried(problem, chosen.fit)
        begun = problem.fit(z, evaluations=EVALUATIONS)
        if not has_dry_friction(begun.parameters.actuator):
            again = problem.fit(as_given(problem, z), evaluations=EVALUATIONS)
            begun = min(begun, again, key=lambda fit: fit.cost)
        if problem.mean_square(begun) < FAR_BEHIND * chosen.fitted_misfit:
            begun = polished(problem, begun)
        return self.rate(rest, problem, begun)

    def on_every_row(self, candidate: Candidate) -> Candidate:
        """Return the model fitted to every row of the fit segments."""
        problem = self.on(candidate.problem, ('fit',), 1)
        return self.rate(candidate.effects, problem,
                         problem.fit(candidate.fit.z, evaluations=EVALUATIONS))

    def at_its_end(self, candidate: Candidate) -> Candidate:
        """
        Return the model fitted on until that no longer pays.

        Short of the end of a flat valley, a model misses what it was not fitted to, and seems to
        lack whatever only takes some steps more. Its last effect is judged anew there.
        """
        problem = candidate.problem
        fit = polished(problem, candidate.fit, WORTH_A_LAST_POLISHING)
        faults = self._faults(problem, fit, candidate.effects[-1:])
        return replace(self.refitted(candidate, fit), fault=''.join(faults.values()))

    def on_both(self, candidate: Candidate, factor: int) -> Candidate:
        """Return the model fitted to the fit and select segments, every `factor`-th row."""
        problem = self.on(candidate.problem, ('fit', 'select'), factor)
        begun = problem.fit(candidate.fit.z, evaluations=EVALUATIONS)
        fitted = self.rate(candidate.effects, problem, polished(problem, begun))
        return replace(fitted, learnt=True)

    def to_the_end(self, candidate: Candidate) -> Candidate:
        """Return the model fitted to every row of the fit and select segments, to its very end."""
        problem = self.on(candidate.problem, ('fit', 'select'), 1)
        fitted = self.rate(candidate.effects, problem, settled(problem, candidate.fit.z))
        return replace(fitted, learnt=True)

    def fault(self, problem: Problem, fit: Fit, effect: str) -> str:
        """Return why this record does not show a fitted effect, '' where it does."""
        return self._faults(problem, fit, (effect,)).get(effect, '')

    def faults(self, candidate: Candidate) -> dict[str, str]:
        """Return the effects that a model's rows do not show, by name, each with the reason."""
        return self._faults(candidate.problem, candidate.fit, candidate.effects)

    def judged(self, candidate: Candidate) -> Candidate:
        """Return the model with the reason why its rows do not show one of its effects, if any."""
        return replace(candidate, fault=next(iter(self.faults(candidate).values()), ''))

    def _faults(self, problem: Problem, fit: Fit, effects: tuple[str, ...]) -> dict[str, str]:
        if not effects:
            return {}
        of_row = segment_of_row(self.segments, len(self.experiment.time))
        rows = np.searchsorted(self.experiment.time, problem.experiment.time)
        draws = block_bootstrap(problem, fit, of_row[rows])
        faults = {name: undetermined(problem, draws, fit, name) for name in effects}
        return {name: why for name, why in faults.items() if why}


def thinned(experiment: Experiment, factor: int) -> tuple[Experiment, Array]:
    """Return fewer rows of an experiment, ENOUGH_ROWS at the least, and which rows those are."""
    size = len(experiment.time)
    factor = min(factor, size // ENOUGH_ROWS)
    return experiment.thinned(factor) if factor > 1 else (experiment, np.arange(size))


def carried(target: Problem, *sources: Fit) -> Array:
    """
    Return z of `target` with the values that its parameters have in the sources.

    Later sources count before earlier ones; the variables of the start are those of the first.
    """
    known = {(f.knob.parameter, f.element): z for fit in sources
             for f, z in zip(fit.freedoms, fit.z)}
    body = [known.get((f.knob.parameter, f.element), 0.0) for f in target.freedoms]
    return np.concatenate([body, sources[0].z[len(sources[0].freedoms):]])


def declared_as_given(problem: Problem, z: Array) -> Array:
    """Return z with only the effects kept: declared parameters and start as given."""
    fresh = z.copy()
    fresh[len(problem.freedoms):] = 0.0
    for j, free in enumerate(problem.freedoms):
        if np.isfinite(free.sigma) or free.knob.parameter in BENCH:
            fresh[j] = 0.0
    return fresh


def as_given(problem: Problem, z: Array) -> Array:
    """Return z with only the sizes of effects kept, their shapes typical, all else as given."""
    fresh = declared_as_given(problem, z)
    for j, free in enumerate(problem.freedoms):
        if free.knob.shape and not np.isfinite(free.sigma):
            fresh[j] = free.without_size
    return fresh


def settled(problem: Problem, z: Array) -> Fit:
    """
    Return the better of two fits: from z, and from its effects with all else as given.

    Before an effect was in the model, the declared parameters had imitated it. Those that a record
    hardly shows come back from there only in tiny steps, and they may show in another record. From
    the parameters as given, a fit does not go there, and is soon at its very end.
    """
    fits = [problem.fit(z, evaluations=EVALUATIONS), begun_as_given(problem, z)]
    return min(fits, key=lambda found: found.cost)


def begun_as_given(problem: Problem, z: Array) -> Fit:
    """Return a fit to the very end that begins with the effects at z, and all else as given."""
    return problem.fit(declared_as_given(problem, z), LAST_EVALUATIONS, SETTLED)


def polished(problem: Problem, fit: Fit, worth: float = WORTH_POLISHING) -> Fit:
    """Return the fit carried on until that no longer pays; where the stem sticks, once."""
    rounds = 1 if fit.sticks else POLISHINGS
    for _ in range(rounds):
        better = problem.fit(fit.z, evaluations=EVALUATIONS)
        fell = fit.cost - better.cost
        fit = min(fit, better, key=lambda f: f.cost)
        if fell < worth * fit.cost:
            break
    return fit
