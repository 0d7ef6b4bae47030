# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Stepwise selection: effects are added and deleted, by one comparison (`decide`).

1. Refit the declared model.
2. Ask the subsystem above the stem (fault isolation). Where it lacks nothing, only what belongs to
   the stem or a sensor is tried; where it calls for an effect, go on with that.
3. Add the effect with the best evidence among the neighbours, as long as the comparison accepts it;
   once, go on from one that it does not, and accept both together or none.
4. Of several effects, delete each that is not called for beside the others.
5. Where much is left, smooth terms without a name compete with what was found.

Every model that was compared is in the trace, with what the comparison said.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
import itertools

from booster_ros.diagnosis.hypotheses.friction import begins_on_a_grid
from booster_ros.diagnosis.hypotheses.subsystem import is_upstream
from booster_ros.diagnosis.selection.decide import (
    NEARLY_ALL, TIE, Comparison, TraceStep, compare, why_not)
from booster_ros.diagnosis.selection.neighbours import neighbours, refitted
from booster_ros.diagnosis.selection.task import (
    Model, Task, by_observation, explained, idealised, lacks_nothing, leaves_noise, near_best,
    upstream_task)
from booster_ros.diagnosis.selection.terms import best_terms
from booster_ros.model.catalogue import EFFECTS

Progress = Callable[[str, float], None]

MOST_EFFECTS = 3
"""Effects in all, at the most: each further one takes a round, and few valves have more."""

_BELOW = frozenset({'stem', 'sensor'})


@dataclass(frozen=True, eq=False)
class Selection:
    """
    The refitted declared model, the chosen one, all that were fitted, and the trace.

    `named` is the best model without a term, which the chosen one may have.
    """

    root: Model
    chosen: Model
    named: Model
    models: tuple[Model, ...]
    trace: tuple[TraceStep, ...]


class _Trace:
    """Models and steps so far: what is written down, and nothing that decides."""

    def __init__(self, root: Model):
        self.root, self.models, self.steps = root, [root], list[TraceStep]()

    def accepts(self, task: Task, one: Model, other: Model, rivals: list[Model],
                candidates: int) -> bool:
        """Tell whether the record calls for a model, one of so many candidates, beside another."""
        found = comparison(task, one, other, [*rivals, one, other])
        against = why_not(found, candidates)
        self.steps.append(TraceStep(
            one.effects, other.effects, one.reduced_chi2, found, against or 'accepted'))
        return not against


def comparison(task: Task, one: Model, other: Model, rivals: list[Model]) -> Comparison:
    """
    Return what the record says of one model against another.

    Both are observed by a summary where either is, else on as many rows as either. The best of the
    rivals that are observed so tells c.
    """
    leading = max((one, other), key=lambda each: (
        each.problem.observation.summary, each.score.observed))
    one, other = (each if _observed_alike(each, leading) else task.observed_as(each, leading)
                  for each in (one, other))
    alike = [each for each in rivals if _observed_alike(each, leading)]
    best = min([one, other, *alike], key=lambda each: each.score.cost / each.score.observed)
    return compare(one.score, other.score, best.score.dispersion)


def _observed_alike(one: Model, other: Model) -> bool:
    """Tell whether two models were fitted to the same observations of the same rows."""
    return (one.problem.observation is other.problem.observation
            and one.score.observed == other.score.observed)


def select(task: Task, tell: Progress) -> Selection:
    """Return which effects the record calls for; `tell` is called with a phrase and a share."""
    tell('refitting the declared parameters', 0.02)
    root = refitted(task)
    trace = _Trace(root)
    task, parent = _upstream_first(task, root, trace, tell)
    chosen = _added(task, root, parent, trace, tell)
    # where a summary counts, what lies above the stem was judged where readings do
    if len(chosen.effects) > 1 and not chosen.problem.observation.summary:
        tell('deleting effects', 0.65)
        chosen = _deleted(task, chosen, trace)
    named = chosen
    if not leaves_noise(chosen) and explained(chosen, root) < NEARLY_ALL:
        tell('looking for a discrepancy without a name', 0.75)
        unnamed = best_terms(task, root)
        trace.models += unnamed
        best = near_best(unnamed, TIE)[0] if unnamed else chosen
        if unnamed and trace.accepts(task, best, chosen, unnamed, len(unnamed)):
            chosen = best
    return Selection(root, chosen, named, tuple(trace.models), tuple(trace.steps))


def _upstream_first(task: Task, root: Model, trace: _Trace, tell: Progress) -> tuple[Task, Model]:
    """
    Return the task and the model to go on from, by what the upstream subsystem lacks.

    If it lacks nothing, the task is that of the stem and the sensors alone. If it calls for an
    effect, the model to go on from has it: whatever the stem lacks does not blur it there.
    """
    above = None if leaves_noise(root) else upstream_task(task)
    if above is None:
        return task, root
    tell('looking above the stem', 0.04)
    parent = refitted(above)
    if lacks_nothing(parent, root):
        return replace(task, places=task.places & _BELOW, names=tuple(
            name for name in task.names if EFFECTS[name].location in _BELOW)), root
    found = neighbours(above, parent, above.names)
    likely = [one for one in found.near
              if trace.accepts(above, one, parent, found.near, len(above.names))]
    whole = [refitted(task, one.effects, root.fit, one.fit) for one in likely]
    trace.models += whole
    return task, _best(task, root, whole) or root


def _added(task: Task, root: Model, parent: Model, trace: _Trace, tell: Progress) -> Model:
    """Return the model with effects added to a parent, one by one, while that is called for."""
    chosen = root
    if parent is not root and trace.accepts(task, parent, root, [], len(task.names)):
        chosen = parent
    for level in range(len(parent.effects), MOST_EFFECTS):
        # a law is never quite the valve's: what it leaves within the noise is no second effect
        if parent.effects and (leaves_noise(parent) or idealised(parent, root)):
            break
        done = itertools.count(1)

        def tick(level: int = level, done: Iterator[int] = done) -> None:
            share = min(next(done) / (len(task.names) + 12), 1.0)
            tell(f'trying effect {level + 1}', 0.05 + 0.2 * (level + share))

        found = neighbours(task, parent, _names(task, parent), tick)
        trace.models += [*found.near, *found.far]
        best = _best(task, parent, found.near)
        if best is not None and trace.accepts(task, best, chosen, found.near, len(task.names)):
            chosen = parent = best
        elif best is None or parent is not chosen:
            break
        else:
            parent = best
    return chosen


def _names(task: Task, parent: Model) -> tuple[str, ...]:
    """Return the effects to add: those below alone where the stem made a summary of the record."""
    if not parent.problem.observation.summary or upstream_task(task) is None:
        return task.names
    return tuple(name for name in task.names
                 if not is_upstream(name) and not begins_on_a_grid(name))


def _best(task: Task, parent: Model, found: list[Model]) -> Model | None:
    """
    Return the best of several neighbours of a model, None of none.

    Of those within TIE of the best one's evidence, the first in the catalogue, which lists common
    causes first; of idealised laws, the first. The best by a summary is compared by that with the
    best of the others.
    """
    order = list(EFFECTS)
    best = [min([one for one in same if idealised(one, parent)] or near_best(same, TIE),
                key=lambda one: order.index(one.effects[-1])) for same in by_observation(found)]
    if len(best) < 2:
        return best[0] if best else None
    first, second = sorted(best, key=lambda one: one.problem.observation.summary)
    return second if comparison(task, second, first, best).log_evidence > TIE else first


def _deleted(task: Task, chosen: Model, trace: _Trace) -> Model:
    """Return the model without the effects that are not called for beside the others."""
    for name in chosen.effects:
        if len(chosen.effects) < 2:
            break
        smaller = refitted(task, chosen.but(name), chosen.fit)
        trace.models.append(smaller)
        if not trace.accepts(task, chosen, smaller, [], len(task.names)):
            chosen = smaller
    return chosen
