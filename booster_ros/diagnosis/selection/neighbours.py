# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The neighbours of a model in a stepwise selection: the models with one effect more.

1. What all but noise explains already, as it is declared, may lack a small effect only: a score
   test on every row tells which promise enough, and these are fitted. Not where a loop leaves
   something to chance: over steps in the cost the slopes of that test lead astray.
2. Else, screen every effect on thinned rows, take the first steps of a fit from where screening
   leads, and fit those that get furthest to their end; where none of them leaves noise, the others
   as well.
3. Fit those not told apart from the best to every row, and score them there.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chdtri

from booster_ros.diagnosis.data.experiment import Array
from booster_ros.diagnosis.estimation.fit import (
    FIRST_STEPS, NOTICEABLE, Fit, carried, fit, fit_at, nominal)
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.diagnosis.estimation.uncertainty import LEVEL
from booster_ros.diagnosis.hypotheses.compose import redundant, with_effects
from booster_ros.diagnosis.hypotheses.friction import (
    begins_on_a_grid, friction_starts, over_minima)
from booster_ros.diagnosis.selection.decide import NOISE, TIE
from booster_ros.diagnosis.selection.screening import (
    BEST, SIZES, Screened, first_steps, reference_at, references, screen, strong_frequencies)
from booster_ros.diagnosis.selection.task import (
    Model, Task, by_observation, idealised, lacks_nothing, leaves_noise, near_best, seen_above,
    upstream_task)
from booster_ros.numerics.parallel import side_by_side

Tick = Callable[[], None]

BEGUN = 10
"""Number of screened effects that get first steps of a fit: the right one is among so many."""


@dataclass(frozen=True)
class Neighbours:
    """Models on every training row, which may be chosen, and others left at thinned rows."""

    near: list[Model]
    far: list[Model]


def fitted_to_every_row(task: Task, effects: tuple[str, ...], problem: Problem, *starts: Array
                        ) -> Model:
    """Return the model fitted to every training row; thinned ones tell a summary as well."""
    whole = problem if problem.observation.summary else task.on_every_row(problem)
    return task.scored(effects, whole, fit(whole, starts))


def refitted(task: Task, effects: tuple[str, ...] = (), *sources: Fit) -> Model:
    """
    Return the model with these effects, fitted to thinned, then to every row.

    It begins with the values in the sources, and with these and the declared parameters as given.
    """
    problem = task.problem(effects)
    starts = [problem.start()]
    if sources:
        warm = carried(problem, *sources)
        starts = [warm, nominal(problem, warm)]
    elif task.experiment.chance:
        starts += _drawn(problem)
    return fitted_to_every_row(task, effects, problem, fit(problem, starts).z)


def _drawn(problem: Problem) -> list[Array]:
    """Return places drawn from priors: over steps in the cost one descent in two gets lost."""
    rng = np.random.default_rng(1)
    several = rng.standard_normal((BEST, len(problem.freedoms)))
    return [np.clip(np.append(z, np.zeros(problem.nuisances)), *problem.bounds())
            for z in several]


def neighbours(task: Task, parent: Model, names: tuple[str, ...], tick: Tick = lambda: None
               ) -> Neighbours:
    """Return the models with one effect more than the parent, those near the best on every row."""
    wanted = [name for name in names
              if name not in parent.effects and not redundant(name, parent.effects)]
    # with steps in the cost, what is left around a refit tells little of what it has imitated
    rough = bool(task.experiment.chance)
    imitated = _far_off(parent) and (leaves_noise(parent) or rough)
    if leaves_noise(parent) and not imitated and not rough:
        begun = _small(task, parent, wanted)
        # what had imitated the effect may have gone far: they begin as given as well
        return Neighbours([
            fitted_to_every_row(task, (*parent.effects, name), problem, z, nominal(problem, z))
            for name, problem, z in begun], [])
    thin = _begun(task, parent, wanted, imitated, tick)
    # every row tells yet more than thinned ones
    near = [one for same in by_observation(thin) for best in [near_best(same, TIE)]
            for one in same if idealised(one, parent) or one in best]

    def whole(one: Model) -> Model:
        tick()
        return one if one.problem.observation.summary else fitted_to_every_row(
            task, one.effects, one.problem, one.fit.z)

    return Neighbours(side_by_side(whole, near), [one for one in thin if one not in near])


def _far_off(parent: Model) -> bool:
    """Tell whether declared parameters are further off, all together, than is known of them."""
    return parent.score.prior > float(chdtri(len(parent.problem.known), 1.0 - LEVEL))


def _seen_upstream(task: Task, parent: Model, joint: Problem) -> Array:
    """Return z with what is told above the stem, all else as given: it has imitated the effect."""
    begin = nominal(joint, carried(joint, parent.fit))
    above = upstream_task(task)
    if above is None:
        return begin
    _, seen = seen_above(above, parent.effects, parent.fit)
    return carried(joint, replace(parent.fit, z=nominal(parent.problem, parent.fit.z)), seen)


def _small(task: Task, parent: Model, names: list[str]) -> list[tuple[str, Problem, Array]]:
    """Return the effects whose score test promises that they are accepted, and where they lead."""
    problem, found = parent.problem, parent.fit
    around, frequencies = [reference_at(problem, found)], strong_frequencies(problem, found.z)
    screened = side_by_side(
        lambda name: screen(problem, around, name, frequencies, SIZES[:1]), names)
    least = found.cost - 2.0 * TIE * parent.score.dispersion
    hopeful = sorted((one for one in screened if one.cost < least), key=lambda one: one.cost)
    return [(one.effect, with_effects(one.problem, (*parent.effects, one.effect)), one.starts[0][1])
            for one in hopeful[:BEST]]


def _begun(task: Task, parent: Model, names: list[str], imitated: bool, tick: Tick
           ) -> list[Model]:
    """Return the models with the effects that get furthest on thinned rows, fitted to these."""
    problem = task.problem(parent.effects)
    found = fit_at(problem, parent.fit.z)
    smooth = [name for name in names if not begins_on_a_grid(name)]

    def begun(one: Screened) -> tuple[Screened, Fit]:
        tick()
        return one, first_steps(problem, one)

    steps = side_by_side(begun, _screened(problem, found, smooth, imitated, tick))
    order = _furthest(steps, found.cost - NOTICEABLE * parent.score.dispersion)

    def to_its_end(place: int) -> Model:
        tick()
        one, end = order[place]
        starts = [end.z]
        # what had imitated the effect may have gone far: the best begin as given as well
        if place < BEST // 2:
            starts.append(nominal(one.problem, end.z))
        if task.experiment.chance:  # over steps in the cost first steps may have lost their way
            starts += [nominal(one.problem, begin) for _, begin, _ in one.starts]
        return task.scored((*parent.effects, one.effect), one.problem, fit(one.problem, starts))

    places = range(len(order))
    ended = side_by_side(to_its_end, places[:BEST])
    # a grid takes long, and nothing calls for it where another effect leaves noise
    if not any(one.reduced_chi2 < NOISE for one in ended):
        for name in (name for name in names if begins_on_a_grid(name)):
            ended += _from_a_grid(task, parent, name)
            tick()
    # first steps say little where an effect bends what it acts on, as a limit of speed does
    met = lacks_nothing if task.experiment.smoothed else idealised
    if not any(leaves_noise(one) or met(one, parent) for one in ended):
        ended += side_by_side(to_its_end, places[BEST:])
    return ended


def _furthest(steps: list[tuple[Screened, Fit]], noticed: float) -> list[tuple[Screened, Fit]]:
    """
    Return screened effects and their first steps, those that got furthest first.

    Steps that lost their way end anywhere, and by last digits: of those that did not come below the
    cost from which on a gain is `noticed`, screening tells the order.
    """
    def reached(step: tuple[Screened, Fit]) -> tuple[bool, float]:
        one, end = step
        lost = end.cost > noticed
        return lost, one.cost if lost else end.cost

    return sorted(steps, key=reached)


def _screened(problem: Problem, found: Fit, names: list[str], imitated: bool, tick: Tick
              ) -> list[Screened]:
    """
    Return the effects that screening ranks first, with their starts.

    Around a fit that has imitated what is missing nothing is: then around what is declared alone.
    """
    smooth = not problem.observation.summary
    around = references(problem, found) if smooth else [reference_at(problem, found)]
    around = around[1:] if imitated and around[1:] else around
    frequencies = strong_frequencies(problem, found.z)

    def one(name: str) -> Screened:
        tick()
        return screen(problem, around, name, frequencies, SIZES if smooth else SIZES[1:2])

    return sorted((each for each in side_by_side(one, names) if each.starts),
                  key=lambda each: each.cost)[:BEGUN]


def _from_a_grid(task: Task, parent: Model, name: str) -> list[Model]:
    """Return the model with an effect begun on a grid, none if nothing speaks for it."""
    effects = (*parent.effects, name)
    joint = task.problem(effects)
    starts = friction_starts(joint, _seen_upstream(task, parent, joint))
    begun = fit(joint, starts, FIRST_STEPS)
    smooth = replace(task.problem(parent.effects), observation=joint.observation)
    if begun.cost > smooth.cost(parent.fit.z):
        return []
    found = task.scored(effects, joint, fit(joint, [begun.z]))
    return [found if leaves_noise(found) else task.scored(
        effects, joint, over_minima(joint, found.fit))]
