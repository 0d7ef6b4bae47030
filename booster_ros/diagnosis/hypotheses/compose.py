# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The declared model with effects: what each adds to what is free, and which of them are alike."""

from dataclasses import replace

from booster_ros.diagnosis.estimation.observation import ROWS, WINDOWS
from booster_ros.diagnosis.estimation.parametrisation import about, effect_freedom, loosened, put
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.model.actuator import has_dry_friction
from booster_ros.model.catalogue import EFFECTS, Effect
from booster_ros.model.parameters import DESCRIPTIONS
from booster_ros.model.scaling import proportion


def with_effect(problem: Problem, effect: Effect) -> Problem:
    """Return the problem with what it can show of the effect free, behind what was free before."""
    present = {(f.knob.parameter, f.element) for f in problem.freedoms}
    added = tuple(f for f in effect_freedom(effect, problem.base)
                  if (f.knob.parameter, f.element) not in present
                  and not (f.knob.clocked and problem.experiment.quasi_static))
    kept = tuple(loosened(f, effect) for f in problem.freedoms) if added else problem.freedoms
    base = problem.base
    for name, value in effect.sets:
        value *= proportion(base, name.split('.')[0], DESCRIPTIONS[name].unit)
        kept = tuple(about(f, value) if f.knob.parameter == name else f for f in kept)
        base = put(base, name, value)
    return replace(problem, base=base, freedoms=kept + added)


def with_effects(problem: Problem, effects: tuple[str, ...]) -> Problem:
    """Return the problem with all these effects free; KeyError for one not in the catalogue."""
    for name in effects:
        problem = with_effect(problem, EFFECTS[name])
    slips = has_dry_friction(problem.base.actuator) or any(EFFECTS[name].rubs for name in effects)
    return replace(problem, observation=(
        WINDOWS if slips and not problem.experiment.quasi_static else ROWS))


def redundant(name: str, present: tuple[str, ...]) -> bool:
    """Tell whether an effect has no parameter that the present ones do not have already."""
    have = {knob.parameter for other in present for knob in EFFECTS[other].knobs}
    return all(knob.parameter in have for knob in EFFECTS[name].knobs)
