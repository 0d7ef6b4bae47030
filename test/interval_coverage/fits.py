# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a diagnosis says of a drawn valve whose effect it has named, and of its noise."""

from typing import NamedTuple

from hidden_plant.declared import declared_groups
from hidden_plant.effects import EFFECTS

from booster_ros.diagnosis.data.blocks import split, training_blocks
from booster_ros.diagnosis.estimation.final_fit import final_fit
from booster_ros.diagnosis.estimation.parametrisation import Free, label
from booster_ros.diagnosis.estimation.uncertainty import Interval, interval_of
from booster_ros.diagnosis.hypotheses.applicable import free_to_refit
from booster_ros.diagnosis.prepare.preparation import prepare
from booster_ros.diagnosis.selection.neighbours import neighbours, refitted
from booster_ros.diagnosis.selection.task import Task
from booster_ros.model.parameters import from_values
from booster_ros.model.system import PositionerParameters

from .valves import NOISE, SIZES, Drawn


class Held(NamedTuple):
    """Whether the interval of a parameter holds the truth."""

    parameter: str
    of_effect: bool
    held: bool


def intervals(drawn: Drawn) -> list[Held]:
    """Return for each parameter that is known whether its interval in the final fit holds it."""
    return judged(drawn, known_intervals(drawn))


def judged(drawn: Drawn, known: list[tuple[Free, Interval]]) -> list[Held]:
    """Return of each of these intervals whether it holds what was put in."""
    truth = drawn.truth()
    return [Held(label(free), free.knob.parameter in SIZES.get(drawn.effect, ()),
                 interval.low <= truth[free.knob.parameter, free.element]
                 and (interval.open_above
                      or truth[free.knob.parameter, free.element] <= interval.high))
            for free, interval in known]


def known_intervals(drawn: Drawn) -> list[tuple[Free, Interval]]:
    """Return the parameters that are known, with their intervals in the final fit."""
    declared = declared_parameters()
    experiment = prepare(drawn.record(), declared)
    segments = split(experiment.time, experiment.current)
    names = EFFECTS[drawn.effect].names[:1] if drawn.effect else ()
    task = Task(experiment, segments, declared, free_to_refit(declared, experiment), names)
    root = refitted(task)
    model = (neighbours(task, root, names).near or [root])[0] if names else root
    last = final_fit(model.problem, model.fit.z, training_blocks(segments, len(experiment.time)))
    truth = drawn.truth()
    return [(free, interval_of(last.problem, last.draws, last.fit, j))
            for j, free in enumerate(last.problem.freedoms)
            if (free.knob.parameter, free.element) in truth]


def levels(drawn: Drawn) -> tuple[float, float]:
    """Return how loud the noise of pressure and position is held to be, 1 for what it is."""
    noise = prepare(drawn.record(), declared_parameters()).noise
    pressure, position = (noise[name] / true.level for name, true in NOISE.items())
    return float(pressure), float(position)


def declared_parameters() -> PositionerParameters:
    """Return the name plate of the plant as the model's parameters."""
    return from_values({f'{group}.{name}': value for group, values in declared_groups().items()
                        for name, value in values.items()})
