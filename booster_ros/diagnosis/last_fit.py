# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The models of a verdict fitted to all but the locked part, and what those rows still show of them.

What was chosen on the select segments is now fitted to these as well, and has to stand: a term
without a name has to explain what matters of all rows fitted, and these rows have to tell an
effect from none.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from booster_ros.diagnosis.experiment.segments import USED, segment_of_row
from booster_ros.diagnosis.fitting.descent import SETTLED
from booster_ros.diagnosis.fitting.fit import Fit, Problem
from booster_ros.diagnosis.fitting.friction_start import each_damping
from booster_ros.diagnosis.fitting.friction_trials import (
    NARROW, WIDE, Trials, friction_trials)
from booster_ros.diagnosis.fitting.in_step import cost_in_step, follows_slips
from booster_ros.diagnosis.fitting.intervals import (
    block_bootstrap, block_bootstrap_of_means, left_of, undetermined)
from booster_ros.diagnosis.fitting.one_by_one import more_in_step
from booster_ros.diagnosis.fitting.slip_by_slip import fit_slip_by_slip
from booster_ros.diagnosis.fitting.valley import at_the_bottom
from booster_ros.diagnosis.searching.candidate import (
    NEAR_NOISE, Candidate, best_of_each, clearly_better, explains)
from booster_ros.diagnosis.searching.cascade import as_seen_above, declared_as_seen_above
from booster_ros.diagnosis.searching.knots import with_gentle_ends
from booster_ros.diagnosis.searching.nameless import over_time, preferable, term_alone
from booster_ros.diagnosis.searching.search import (
    EVALUATIONS, LAST_EVALUATIONS, Search, as_given, begun_as_given, declared_as_given, settled)
from booster_ros.diagnosis.searching.selection import Tried
from booster_ros.diagnosis.searching.unknown import UNNAMED
from booster_ros.model.actuator import is_rigid

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class LastFit:
    """
    A problem on all but the locked rows, its fit, and draws of z by a bootstrap of its segments.

    Draws have the shape (draws, variables); there are none where no effect is to be told from none.
    `trials` are the trials of friction around the fit of a stem that sticks and slips. The fit is
    the best of them, or keeps step with more slips than they do.
    """

    problem: Problem
    fit: Fit
    draws: Array = field(default_factory=lambda: np.empty((0, 0)))
    trials: Trials | None = None


def verdict_of(search: Search, tried: Tried, unnamed: list[Candidate], before: LastFit
               ) -> tuple[str, Tried, LastFit]:
    """
    Return the verdict (none, effect, unknown), the models tried, and the fit that goes with it.

    The chosen one of the models tried is left without the effects that did not stand.
    """
    if unnamed and not unnamed[0].fault and preferable(unnamed[0], tried):
        last = _term(search, unnamed[0], before)
        if explains(last.fit, before.fit, last.problem.rows_counted()):
            return 'unknown', tried, last
        unnamed = []
    if not tried.chosen.effects:
        return 'none', tried, before
    last = last_fit(search, tried.chosen)
    draws = draws_of(search, last)
    for name in tried.chosen.effects:
        fault = undetermined(last.problem, draws, last.fit, name)
        if fault:
            return verdict_of(search, _without(tried, name, fault), unnamed, before)
    return 'effect', tried, replace(last, draws=draws)


def draws_of(search: Search, last: LastFit) -> Array:
    """Return draws of z, shape (draws, variables), spread as far as the record leaves z open."""
    bootstrap = block_bootstrap_of_means if last.fit.sticks else block_bootstrap
    draws = bootstrap(
        last.problem, last.fit, segment_of_row(search.segments, len(search.experiment.time)))
    return last.trials.instead_of(draws) if last.trials else draws


def last_fit(search: Search, candidate: Candidate) -> LastFit:
    """
    Return the candidate fitted to all but the locked part, without sizes that show nowhere.

    A model whose stem sticks is fitted through slips, any other one to its very end.
    """
    problem = search.on(candidate.problem, USED, 1)
    if candidate.fit.sticks:
        return _through_slips(search, problem, candidate)
    fit = _without_slips(problem, candidate)
    if not _unnamed(candidate):  # a term is fitted again with gentle ends, and has no intervals
        fit = at_the_bottom(problem, fit)
    return LastFit(problem, problem.without_unseen(fit))


def _without_slips(problem: Problem, candidate: Candidate) -> Fit:
    """
    Return the fit to its end; where it leaves more than noise, the better of it and a second one.

    The second one begins with typical shapes. A table has none to begin with, and one over the
    stem's velocity can swing on the way from nothing, which takes minutes a fit.
    """
    if not candidate.effects or _unnamed(candidate):
        return problem.fit(candidate.fit.z, LAST_EVALUATIONS, SETTLED)
    fit = settled(problem, candidate.fit.z)
    if problem.mean_square(fit) < NEAR_NOISE:
        return fit
    again = problem.fit(as_given(problem, fit.z), evaluations=EVALUATIONS)
    return min(fit, again, key=lambda found: found.cost)


def _through_slips(search: Search, problem: Problem, candidate: Candidate) -> LastFit:
    """
    Return the best of the fit from the end of the search and of fits that begin elsewhere.

    The search may have ended where the declared parameters imitate what was missing. Where all that
    is left could be noise, one other fit begins with the effects alone and the declared parameters
    as given. Else, a fit that follows the stem from slip to slip is sought, and friction is tried
    around it, by the cost in step: slopes would tell friction far closer than it is. Where there is
    none, fits through slips begin with what is seen above the stem, then with the effects alone. If
    the best of these has a packing that yields, and follows the slips, it is made to keep step with
    more of them; trials by the cost through slips tell how sure it is, as chance leads to one of
    several places that keep step. Else, friction is tried around it, and both kinds of fits begin
    once more from the best trial; around one that is better, friction is tried again. There, the
    cost through slips decides: when single slips come is chance.
    """
    fit = problem.fit(candidate.fit.z, evaluations=EVALUATIONS)
    if not candidate.effects or _unnamed(candidate):
        return LastFit(problem, problem.without_unseen(fit))
    if problem.mean_square(fit) < NEAR_NOISE:
        fit = min(fit, begun_as_given(problem, fit.z), key=lambda found: found.cost)
        return LastFit(problem, problem.without_unseen(fit))
    followed = _slip_by_slip(search, problem, candidate, fit)
    if followed is not None:
        fit, trials = _tried_around(problem, followed, NARROW, cost_in_step)
        return LastFit(problem, problem.without_unseen(fit), trials=trials)
    fit = _better(problem, fit, [as_seen_above(search, candidate, fit.z, USED)])
    fit = _better(problem, fit, each_damping(problem, declared_as_given(problem, fit.z)))
    if not is_rigid(fit.parameters.actuator) and follows_slips(problem, fit.z):
        fit = problem.at(more_in_step(problem, fit.z))
        trials = friction_trials(problem, fit.z)
        return LastFit(problem, problem.without_unseen(fit), trials=trials)
    fit, trials = _tried_around(problem, fit)
    further = _better(problem, fit, [as_seen_above(search, candidate, fit.z, USED)])
    further = _better(problem, further, [declared_as_given(problem, further.z)])
    if further is not fit:
        fit, trials = _tried_around(problem, further)
    return LastFit(problem, problem.without_unseen(fit), trials=trials)


def _slip_by_slip(search: Search, problem: Problem, candidate: Candidate, fit: Fit) -> Fit | None:
    """
    Return the fit that follows the slips of a packing that does not yield, if one does.

    It has to keep step better than this one.
    """
    if not is_rigid(fit.parameters.actuator):
        return None
    followed = fit_slip_by_slip(problem, declared_as_seen_above(search, candidate, fit.z, USED))
    if followed is None or cost_in_step(problem, followed.z) >= cost_in_step(problem, fit.z):
        return None
    return followed


def _tried_around(problem: Problem, fit: Fit, share: float = WIDE,
                  cost: Callable[[Problem, Array], float] = Problem.cost_through_slips
                  ) -> tuple[Fit, Trials]:
    """Return the best of the trials of friction around a fit, which may be the fit, and them."""
    trials = friction_trials(problem, fit.z, share, cost)
    return (problem.at(trials.best) if np.argmin(trials.cost) else fit), trials


def _better(problem: Problem, fit: Fit, starts: list[Array]) -> Fit:
    """Return the fit or, if better through slips, the best fit through slips from these starts."""
    fits = [fit, *(problem.fit_through_slips(z, EVALUATIONS) for z in starts)]
    return min(fits, key=lambda found: problem.cost_through_slips(found.z))


def _unnamed(candidate: Candidate) -> bool:
    return bool(candidate.effects) and candidate.effects[0].startswith(UNNAMED)


def _term(search: Search, candidate: Candidate, before: LastFit) -> LastFit:
    if over_time(candidate):
        return LastFit(*term_alone(search, candidate, before.fit))
    last = last_fit(search, candidate)
    gentle = with_gentle_ends(last.problem, last.fit)
    return LastFit(gentle, gentle.fit(last.fit.z, evaluations=EVALUATIONS))


def _without(tried: Tried, name: str, fault: str) -> Tried:
    """
    Return the models tried with the best of those chosen that do without this effect.

    It has what is `left_of` the effects at most. A model with more effects is chosen only where the
    segments held back call for it, as in the search.
    """
    rest = set(left_of(tried.chosen.effects, name))
    left = [one for one in tried.all if set(one.effects) <= rest and not one.fault]
    held_back = best_of_each(left) | best_of_each(one for one in left if not one.learnt)
    chosen = tried.refit
    for one in sorted(held_back.values(), key=lambda c: (len(c.effects), c.score)):
        if clearly_better(one, chosen):
            chosen = one
    reasons = {**tried.reasons, frozenset(tried.chosen.effects):
               f'fitted to all but the locked part: {name}: {fault}'}
    if chosen.effects:
        reasons[frozenset(chosen.effects)] = 'chosen'
    return replace(tried, chosen=chosen, reasons=reasons)
