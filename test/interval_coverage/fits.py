# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a diagnosis says of a drawn valve whose effect it has named, and of its noise."""

from typing import NamedTuple

from hidden_plant.declared import declared_groups
from hidden_plant.effects import EFFECTS

from booster_ros.diagnosis.data.blocks import split
from booster_ros.diagnosis.hypotheses.applicable import free_to_refit
from booster_ros.diagnosis.estimation.parametrisation import label
from booster_ros.diagnosis.estimation.uncertainty import interval_of
from booster_ros.diagnosis.last_fit import draws_of, last_fit
from booster_ros.diagnosis.prepare.preparation import prepare
from booster_ros.diagnosis.searching.next_effect import extend
from booster_ros.diagnosis.searching.search import Search
from booster_ros.model.parameters import from_values
from booster_ros.model.system import PositionerParameters

from .valves import NOISE, SIZES, Drawn


class Held(NamedTuple):
    """Whether the interval of a parameter holds the truth."""

    parameter: str
    of_effect: bool
    held: bool


def intervals(drawn: Drawn) -> list[Held]:
    """Return for each parameter that is known whether its interval in the last fit holds it."""
    declared = declared_parameters()
    experiment = prepare(drawn.record(), declared)
    segments = split(experiment.time, experiment.current)
    names = EFFECTS[drawn.effect].names[:1] if drawn.effect else ()
    search = Search(experiment, segments, declared, free_to_refit(declared, experiment), names)
    refit = search.refit()
    candidate = extend(search, refit, tick=lambda: None)[0] if names else refit
    last = last_fit(search, candidate)
    draws = draws_of(search, last)
    truth = drawn.truth()
    found = []
    for j, free in enumerate(last.problem.freedoms):
        known = truth.get((free.knob.parameter, free.element))
        if known is None:
            continue
        interval = interval_of(last.problem, draws, last.fit, j,
                               last.trials.ends(j) if last.trials else None)
        found.append(Held(
            label(free), free.knob.parameter in SIZES.get(drawn.effect, ()),
            interval.low <= known and (interval.open_above or known <= interval.high)))
    return found


def levels(drawn: Drawn) -> tuple[float, float]:
    """Return how loud the noise of pressure and position is held to be, 1 for what it is."""
    noise = prepare(drawn.record(), declared_parameters()).noise
    pressure, position = (noise[name] / true.level for name, true in NOISE.items())
    return float(pressure), float(position)


def declared_parameters() -> PositionerParameters:
    """Return the name plate of the plant as the model's parameters."""
    return from_values({f'{group}.{name}': value for group, values in declared_groups().items()
                        for name, value in values.items()})
