# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The search for what the model lacks.

Model: the declared model with its parameters refitted within their priors, plus at most three
named effects, two where the stem sticks. Numbered as carried out:

1. refit the declared parameters on the fit segments;
2. screen every effect in the catalogue with the declared parameters reacting (see screening);
3. fit the most promising jointly with the declared parameters, on the fit segments, thinned, a
   few steps from both starts that screening found, then the cheapest to their end;
4. leave out those whose size is not told from none, or which run into their bounds (see
   intervals), and score the others on the select segments; the score is the sum of squared scaled
   residuals and of the departures that the priors of the declared parameters hold against a model;
5. keep the best and go on from 2 for a second and a third effect while the score falls by more
   than one standard error (paired, over segments), by a share that matters, and by a third of
   what noise does not explain; where the stem sticks, what lies above it is sought with the stem
   driven as measured (see cascade). Where noise could be all from the start, an effect must lower
   the cost of the fit clearly as well. What an effect leaves on thinned rows must be left on every
   row before a next one is looked for;
6. try every other effect in the place of each of several, then leave each out again; not where a
   term without a name leaves far less than all of them together (see nameless);
7. models near the choice are fitted to every row and compared once more (see rematch).
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
import os

import numpy as np

from booster_ros.diagnosis import cascade
from booster_ros.diagnosis.experiment import Experiment
from booster_ros.diagnosis.fit import BENCH, Fit, Free, Problem
from booster_ros.diagnosis.intervals import block_bootstrap, undetermined
from booster_ros.diagnosis.screening import (
    Screened, references, screen, strong_frequencies, with_effect)
from booster_ros.diagnosis.segments import Segment, rows_of, segment_of_row
from booster_ros.model.actuator import has_dry_friction
from booster_ros.model.catalogue import EFFECTS
from booster_ros.model.system import PositionerParameters

Array = np.ndarray

NEAR_NOISE = 1.15
"""Mean square misfit below which no further effect is looked for."""

EVALUATIONS = 10
"""Steps of one fit."""

MOST_EFFECTS = 3
MOST_BESIDE_STICKING = 2
"""Effects in all: where the stem sticks, which slip comes when hides a third, and costs minutes."""

PROMISING = 6
FIRST_EVALUATIONS = 4
"""Effects per round that are fitted for so many steps from each of their starts."""

FINALISTS = 6
HOPELESS = 6.0
"""Fits per round that are carried to their end, unless they cost so much more than the best."""

OTHER_START = 2.0
"""A fit from an effect's other start is given up when it costs so much more than the first."""

FAR_BEHIND = 10.0
"""A model that costs so much more than another one is no rival of it: no more fitting."""

CLOSE = 3.0
POLISHINGS = 4
WORTH_POLISHING = 0.01
"""Fits that cost up to so much more than the best are given as many steps again, so many times at
the most, while that lowers their cost by this share."""

AS_GOOD_ABOVE = 1.1
"""
Above a stem that sticks, an effect that costs so much more than the best is not tried in the whole:
up there nothing blurs which it is.
"""

FEWEST = 3
"""
So many are fitted even if their screening looks hopeless beside the best; not the slow ones, of a
stem that sticks, once one has reached the noise.
"""

WORTH_ADDING = 0.05
"""An effect must lower the score by this share: less is below what noise and rounding hide."""

WORTH_EXPLAINING = 0.3
"""And it must explain this share of what noise does not."""

NEGLIGIBLE = 2e-3
"""Of the declared model's excess over noise, this share may be what idealising an effect leaves."""

TOO_SIMILAR = 0.05
"""Models whose scores differ by less than this share are not told apart by a record."""

UNLIKELY = 9.0
"""A model that costs so much more than another, fitted to all the same rows, is unlikely."""

THINNING = 8
"""Fits use every eighth row, and all rows where the drive jumps."""

ENOUGH_ROWS = 1500
"""Records are not thinned to fewer rows: a short sweep is used whole."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """
    A model: its effects, its fit, and how it scores on the select segments.

    `confirmed` says that its last effect explains enough of what is seen above the stem, where
    the stem's friction blurs the whole; `fault` why its last effect is none that this record shows.
    """

    effects: tuple[str, ...]
    problem: Problem
    fit: Fit
    by_segment: Array
    prior: float
    samples: int
    confirmed: bool = False
    fault: str = ''

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


def clearly_better(better: Candidate, worse: Candidate) -> bool:
    """Tell whether the score falls by more than one standard error and by what matters."""
    fall, error = gain(worse, better)
    excess = max(worse.score - worse.samples, 0.0)
    enough = better.confirmed or fall > WORTH_EXPLAINING * excess
    return enough and fall > error and fall > WORTH_ADDING * worse.score


@dataclass(frozen=True, eq=False)
class _Begun:
    """An effect with the first steps of a fit; `confirmed` as in a candidate."""

    effect: str
    problem: Problem
    fit: Fit
    confirmed: bool = False


@dataclass(frozen=True, eq=False)
class Search:
    """
    The task: experiment, segments, declared parameters and their freedom.

    `names` are the effects to try, `thinning` how many rows a fit takes one of. What the methods
    return is scaled: residuals in standard deviations of the noise, costs in squares of that.
    """

    experiment: Experiment
    segments: list[Segment]
    declared: PositionerParameters
    freedoms: tuple[Free, ...]
    names: tuple[str, ...] = tuple(EFFECTS)
    thinning: int = THINNING

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
        rows, experiment = self.rows_and_experiment(('fit',), self.thinning)
        return Problem(experiment, rows, self.declared, self.freedoms)

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
        """Return the problem with all these effects free; KeyError for one not in the catalogue."""
        for name in effects:
            problem = with_effect(problem, EFFECTS[name])
        return problem

    def carried(self, target: Problem, *sources: 'Candidate | _Begun') -> Array:
        """
        Return z of `target` with the values that its parameters have in the sources.

        Later sources count before earlier ones; the start is that of the first.
        """
        known = {(f.knob.parameter, f.element): z for source in sources
                 for f, z in zip(source.problem.freedoms, source.fit.z)}
        body = [known.get((f.knob.parameter, f.element), 0.0) for f in target.freedoms]
        first = sources[0]
        return np.concatenate([body, first.fit.z[len(first.problem.freedoms):]])

    def without(self, chosen: Candidate, rest: tuple[str, ...]) -> Candidate:
        """
        Return the model with these of the chosen effects only, fitted from what they were.

        Also with all else as given: it may have moved to where only the others held it. Not where
        the stem sticks, as that takes long. Not to the end where it is far behind the chosen.
        """
        problem = self.joint(self.problem(), rest)
        z = self.carried(problem, chosen)
        begun = problem.fit(z, evaluations=EVALUATIONS)
        if not has_dry_friction(begun.parameters.actuator):
            again = problem.fit(as_given(problem, z), evaluations=EVALUATIONS)
            begun = min(begun, again, key=lambda fit: fit.cost)
        if begun.cost < FAR_BEHIND * chosen.fit.cost:
            begun = polished(problem, begun)
        return self.rate(rest, problem, begun)

    def on_every_row(self, candidate: Candidate) -> Candidate:
        """Return the model fitted to every row of the fit segments."""
        problem = self.on(candidate.problem, ('fit',), 1)
        return self.rate(candidate.effects, problem,
                         problem.fit(candidate.fit.z, evaluations=EVALUATIONS))

    def seen_from_above(self, candidate: Candidate) -> Candidate:
        """Return the model of a stem that sticks, fitted on from what is seen above the stem."""
        problem = candidate.problem
        start = self.as_seen_above(candidate, candidate.fit.z, ('fit',))
        fit = problem.fit(start, evaluations=EVALUATIONS)
        if fit.cost >= candidate.fit.cost:
            return candidate
        better = self.rate(candidate.effects, problem, fit)
        return replace(better, confirmed=candidate.confirmed)

    def on_both(self, candidate: Candidate, factor: int) -> Candidate:
        """Return the model fitted to the fit and select segments, every `factor`-th row."""
        problem = self.on(candidate.problem, ('fit', 'select'), factor)
        begun = problem.fit(candidate.fit.z, evaluations=EVALUATIONS)
        return self.rate(candidate.effects, problem, polished(problem, begun))

    def extend(self, parent: Candidate, tick: Callable[[], None],
               leave_out: tuple[str, ...] = (), worth: float = np.inf) -> list[Candidate]:
        """
        Return the best models with one effect more than `parent`, best first.

        Effects that screening does not see below the cost `worth` are not fitted, nor those further
        that the first steps do not take below it.
        """
        names = [name for name in self.names if name not in (*parent.effects, *leave_out) and
                 not redundant(name, parent.effects)]
        above = self._above(parent.fit)
        if above is None:
            begun = self._begun(parent.problem, parent.fit, names, tick, worth)
        else:
            begun = self._begun_in_parts(parent, names, above, tick, worth)
        begun.sort(key=lambda b: b.fit.cost)
        ended: dict[str, _Begun] = {}
        hopeless = HOPELESS if above is None else CLOSE  # fits of a stem that sticks are slow
        for one in begun[:FINALISTS]:
            first = ended.get(one.effect)
            if first is not None and one.fit.cost > OTHER_START * first.fit.cost:
                continue
            if one.fit.cost < min(hopeless * begun[0].fit.cost, worth):
                one = replace(one, fit=one.problem.fit(one.fit.z, evaluations=EVALUATIONS))
            if one.effect not in ended or one.fit.cost < ended[one.effect].fit.cost:
                ended[one.effect] = one
            tick()
        least = min((one.fit.cost for one in ended.values()), default=0.0)
        for name, one in ended.items():
            if least < one.fit.cost < CLOSE * least:  # on equal terms with the best
                ended[name] = replace(one, fit=polished(one.problem, one.fit))
        return preferred_first([
            replace(self.rate((*parent.effects, one.effect), one.problem, one.fit),
                    confirmed=one.confirmed, fault=self.fault(one.problem, one.fit, one.effect))
            for one in ended.values()])

    def fault(self, problem: Problem, fit: Fit, effect: str) -> str:
        """Return why a fitted effect is none that this record shows, '' where it is one."""
        of_row = segment_of_row(self.segments, len(self.experiment.time))
        rows = np.searchsorted(self.experiment.time, problem.experiment.time)
        return undetermined(problem, block_bootstrap(problem, fit, of_row[rows]), fit, effect)

    def _begun(self, thin: Problem, fitted: Fit, names: list[str], tick: Callable[[], None],
               worth: float = np.inf, few: bool = False) -> 'list[_Begun]':
        """Return the promising effects on top of a fit, each with the first steps of its own."""
        around = references(thin, thin.at(fitted.z))
        frequencies = strong_frequencies(thin, fitted.z)

        def one(name: str) -> Screened:
            found = screen(thin, around, name, frequencies, few)
            tick()
            return found

        with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
            screened = sorted(pool.map(one, names), key=lambda s: s.cost)
        begun: list[_Begun] = []
        count = 0
        for quick in screened[:PROMISING]:
            hopeful = quick.cost < HOPELESS * screened[0].cost
            if quick.cost < worth and (hopeful or (count < FEWEST and not _waste(quick, begun))):
                begun += self._from_each_start(quick)
                count += 1
            tick()
        return begun

    def _from_each_start(self, quick: Screened) -> 'list[_Begun]':
        """Return the first steps from the starts, unless one promises far less than is had."""
        begun: list[_Begun] = []
        for z, cost in zip(quick.starts, quick.costs):
            if not begun or cost < HOPELESS * begun[0].fit.cost:
                begun.append(_Begun(quick.effect, quick.problem,
                                    quick.problem.fit(z, evaluations=FIRST_EVALUATIONS)))
        return begun

    def as_seen_above(self, candidate: Candidate, z: Array, roles: tuple[str, ...]) -> Array:
        """
        Return z with what lies above a stem that sticks as the measured stem tells it.

        What was fitted before friction was in the model had imitated it, and a fit of all at once
        stays there: which slip comes when makes its cost rough. Above the stem nothing is rough.
        """
        above = self._above(candidate.fit)
        if above is None:
            return z
        effects = tuple(e for e in candidate.effects if cascade.shows_above_the_stem(e))
        upper = above.on(above.joint(above.problem(), effects), roles, above.thinning)
        fitted = upper.fit(as_given(upper, self.carried(upper, candidate)))
        part = _Begun('', upper, fitted)
        body = self.carried(candidate.problem, candidate, part)[:len(candidate.problem.freedoms)]
        return np.concatenate([body, z[len(body):]])

    def _above(self, fit: Fit) -> 'Search | None':
        """Return the search above the stem where friction rules the stem, else None."""
        if not has_dry_friction(fit.parameters.actuator):
            return None
        above = cascade.above_the_stem(self.experiment)
        return None if above is None else replace(
            self, experiment=above, freedoms=cascade.free_above_the_stem(self.freedoms),
            thinning=cascade.THINNING)

    def _begun_in_parts(self, parent: Candidate, names: list[str], above: 'Search',
                        tick: Callable[[], None], worth: float) -> 'list[_Begun]':
        """
        Return the promising effects where the stem sticks and slips.

        Those above it are fitted there first. Those of the stem are screened in a few sizes, for
        simulations are slow, and fitted if that already is worth adding.
        """
        present = tuple(e for e in parent.effects if cascade.shows_above_the_stem(e))
        problem = above.joint(above.problem(), present)
        fitted = problem.fit(self.carried(problem, parent), evaluations=EVALUATIONS)
        worth_above = worth * fitted.cost / parent.fit.cost
        upper = above._begun(problem, fitted, [n for n in names if cascade.shows_above_the_stem(n)],
                             tick, worth_above)
        upper.sort(key=lambda b: b.fit.cost)
        excess = max(fitted.cost - problem.rows_counted(), 0.0)
        parts: list[_Begun] = []
        for name in list(dict.fromkeys(b.effect for b in upper))[:FEWEST]:
            part = next(b for b in upper if b.effect == name)
            part = replace(part, fit=part.problem.fit(part.fit.z, evaluations=EVALUATIONS))
            fall = fitted.cost - part.fit.cost
            if fall > WORTH_ADDING * fitted.cost and part.fit.cost < worth_above:
                parts.append(replace(part, confirmed=fall > WORTH_EXPLAINING * excess))
        least = min((part.fit.cost for part in parts), default=0.0)
        begun: list[_Begun] = []
        for part in parts:
            if part.fit.cost < AS_GOOD_ABOVE * least:
                joint = self.joint(parent.problem, (part.effect,))
                start = self.carried(joint, parent, part)
                begun.append(_Begun(part.effect, joint, joint.fit(
                    start, evaluations=FIRST_EVALUATIONS), part.confirmed))
            tick()
        lower = [n for n in names if not cascade.shows_above_the_stem(n)]
        worth = min(worth, (1.0 - WORTH_ADDING) * parent.fit.cost)
        return begun + self._begun(parent.problem, parent.fit, lower, tick, worth, few=True)


def _waste(quick: Screened, begun: 'list[_Begun]') -> bool:
    """Tell whether a hopeless effect is slow to fit and another one has reached the noise."""
    reached = any(one.fit.cost < NEAR_NOISE * one.problem.rows_counted() for one in begun)
    return reached and any(
        has_dry_friction(quick.problem.parameters(z).actuator) for z in quick.starts)


def as_given(problem: Problem, z: Array) -> Array:
    """Return z with the sizes of the effects alone: declared parameters and start as given."""
    fresh = z.copy()
    fresh[len(problem.freedoms):] = 0.0
    for j, free in enumerate(problem.freedoms):
        if np.isfinite(free.sigma) or free.knob.parameter in BENCH:
            fresh[j] = 0.0
        elif free.knob.shape:
            fresh[j] = free.without_size
    return fresh


def polished(problem: Problem, fit: Fit) -> Fit:
    """Return the fit carried on until that no longer pays; where the stem sticks, once."""
    rounds = 1 if has_dry_friction(fit.parameters.actuator) else POLISHINGS
    for _ in range(rounds):
        better = problem.fit(fit.z, evaluations=EVALUATIONS)
        fell = fit.cost - better.cost
        fit = min(fit, better, key=lambda f: f.cost)
        if fell < WORTH_POLISHING * fit.cost:
            break
    return fit


def preferred_first(candidates: list[Candidate]) -> list[Candidate]:
    """
    Return the candidates by score; of those not told apart from the best, the plainest first.

    Those with a fault come last.
    """
    ranked = sorted(candidates, key=lambda c: (bool(c.fault), c.score))
    if not ranked:
        return ranked
    ties = [c for c in ranked if c.fault == ranked[0].fault and not told_apart(c, ranked[0])]
    ties.sort(key=lambda c: plainness(c, 0.0))
    return ties + [c for c in ranked if c not in ties]


def plainness(candidate: Candidate, behind: float) -> tuple[bool, int, int]:
    """
    Return what models that a record does not tell apart are ranked by, the plainest first.

    Those that the data make unlikely, `behind` the best by too much cost, come last; then fewest
    sizes; then the order of the catalogue, which lists common causes first.
    """
    order = list(EFFECTS)
    return (behind > UNLIKELY, _sizes_shown(candidate),
            sum(order.index(e) for e in candidate.effects))


def _sizes_shown(candidate: Candidate) -> int:
    """Return how many sizes of effects move the record by more than its noise."""
    return sum(not free.knob.shape and not np.isfinite(free.sigma) and bool(seen)
               for free, seen in zip(candidate.problem.freedoms, candidate.fit.seen))


def told_apart(worse: Candidate, better: Candidate) -> bool:
    """Tell whether the record prefers one model: by a standard error and a share that matters."""
    fall, error = gain(worse, better)
    return fall > TOO_SIMILAR * better.score and fall > error


def redundant(name: str, present: tuple[str, ...]) -> bool:
    """Tell whether an effect has no parameter that the present ones do not have already."""
    have = {knob.parameter for other in present for knob in EFFECTS[other].knobs}
    return all(knob.parameter in have for knob in EFFECTS[name].knobs)
