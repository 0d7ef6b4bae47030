# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The identification task: an experiment, its blocks, what is declared, and what may be lacking."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from booster_ros.diagnosis.data.blocks import Segment, rows_of, training_blocks
from booster_ros.diagnosis.data.experiment import Array, Experiment
from booster_ros.diagnosis.estimation.fit import Fit, carried, fit, fit_at, nominal
from booster_ros.diagnosis.estimation.parametrisation import Free
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.diagnosis.hypotheses.compose import with_effects
from booster_ros.diagnosis.hypotheses.subsystem import APART, free_upstream, is_upstream, upstream
from booster_ros.diagnosis.selection.decide import ISOLATED, NEARLY_ALL, NOISE, SMOOTHED
from booster_ros.diagnosis.selection.score import Score, score_of
from booster_ros.model.catalogue import EFFECTS
from booster_ros.model.system import PositionerParameters

PLACES = frozenset(effect.location for effect in EFFECTS.values())
"""All places where something can be missing."""

THINNING = 8
"""The search for where to fit from takes every eighth row, and all rows where the drive jumps."""

ENOUGH_ROWS = 1500
"""Records are not thinned to fewer rows: a short sweep is used whole."""


@dataclass(frozen=True, eq=False)
class Model:
    """
    A model with some effects: its problem, its fit, and its score.

    `reduced_chi2` is the mean square of what it leaves of the readings, whatever is observed of
    them, in squares of the noise.
    """

    effects: tuple[str, ...]
    problem: Problem
    fit: Fit
    score: Score = field(repr=False)
    reduced_chi2: float

    def but(self, name: str) -> tuple[str, ...]:
        """Return its effects without this one."""
        return tuple(effect for effect in self.effects if effect != name)


@dataclass(frozen=True, eq=False)
class Task:
    """
    What is to be explained, by what.

    `names` are the effects, `places` those of terms without a name; the search takes one of every
    `thinning` rows.
    """

    experiment: Experiment
    segments: list[Segment]
    declared: PositionerParameters
    freedoms: tuple[Free, ...]
    names: tuple[str, ...] = tuple(EFFECTS)
    places: frozenset[str] = PLACES
    thinning: int = THINNING

    @cached_property
    def _thin(self) -> tuple[Experiment, Array]:
        return thinned(self.experiment, self.thinning)

    def problem(self, effects: tuple[str, ...] = ()) -> Problem:
        """Return the problem of the model with these effects on thinned training rows."""
        thin, kept = self._thin
        rows = rows_of(self.segments, 'train', len(self.experiment.time))[kept]
        return with_effects(Problem(thin, rows, self.declared, self.freedoms), effects)

    def on_every_row(self, problem: Problem) -> Problem:
        """Return the same problem on every training row."""
        rows = rows_of(self.segments, 'train', len(self.experiment.time))
        return replace(problem, experiment=self.experiment, rows=rows)

    def scored(self, effects: tuple[str, ...], problem: Problem, fit: Fit) -> Model:
        """Return a fit as a model with its score."""
        block = training_blocks(self.segments, len(self.experiment.time))
        rows = np.searchsorted(self.experiment.time, problem.experiment.time)
        readings = np.concatenate(problem.scaled(fit.z))
        return Model(effects, problem, fit, score_of(problem, fit, block[rows]),
                     float(np.mean(readings**2)) if len(readings) else 0.0)

    def observed_as(self, model: Model, other: Model) -> Model:
        """Return the model scored on the rows and by the observation of another, at the same z."""
        problem = replace(model.problem, observation=other.problem.observation,
                          experiment=other.problem.experiment, rows=other.problem.rows)
        return self.scored(model.effects, problem, fit_at(problem, model.fit.z))


def by_observation(models: Sequence[Model]) -> list[list[Model]]:
    """Return the models in groups, each of which is observed alike."""
    return [[one for one in models if one.problem.observation is observation]
            for observation in dict.fromkeys(one.problem.observation for one in models)]


def near_best(models: Sequence[Model], behind: float) -> list[Model]:
    """Return the models, observed alike, whose log evidence is less than so far behind the best."""
    c = min(models, key=lambda one: one.score.cost).score.dispersion
    top = max(one.score.log_evidence(c) for one in models)
    return [one for one in models if one.score.log_evidence(c) > top - behind]


def explained(chosen: Model, root: Model) -> float:
    """Return the share of what the declared model leaves beyond noise that the other explains."""
    missing = root.reduced_chi2 - 1.0
    return (root.reduced_chi2 - chosen.reduced_chi2) / missing if missing > 0.0 else 0.0


def leaves_noise(model: Model) -> bool:
    """Tell whether what a model leaves of what is observed may be noise."""
    return model.reduced_chi2 < NOISE or model.score.cost < NOISE * model.score.observed


def idealised(model: Model, root: Model) -> bool:
    """Tell whether no more is left of a summary than idealising laws leave."""
    return model.problem.observation.summary and explained(model, root) > NEARLY_ALL


def lacks_nothing(above: Model, whole: Model) -> bool:
    """Tell whether an upstream subsystem leaves what its smoothed stem may, of all that is left."""
    left = above.reduced_chi2
    return left < SMOOTHED and left - 1.0 < ISOLATED * (whole.reduced_chi2 - 1.0)


def thinned(experiment: Experiment, factor: int) -> tuple[Experiment, Array]:
    """Return fewer rows of an experiment, ENOUGH_ROWS at the least, and which rows those are."""
    size = len(experiment.time)
    factor = min(factor, size // ENOUGH_ROWS)
    return experiment.thinned(factor) if factor > 1 else (experiment, np.arange(size))


def upstream_task(task: Task) -> Task | None:
    """Return the task of the subsystem above the stem, None where the record does not show it."""
    above = upstream(task.experiment)
    return None if above is None else replace(
        task, experiment=above, freedoms=free_upstream(task.freedoms),
        thinning=max(round(APART / float(np.median(np.diff(above.time)))), 1),
        names=tuple(filter(is_upstream, task.names)))


def seen_above(above: Task, effects: tuple[str, ...], imitated: Fit) -> tuple[Problem, Fit]:
    """Return the fit above the stem of those of the effects that are there, declared as given."""
    problem = above.problem(tuple(filter(is_upstream, effects)))
    return problem, fit(problem, [nominal(problem, carried(problem, imitated))])
