# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a diagnosis says of a drawn valve whose effect it has named, and of its noise."""

from typing import NamedTuple

from hidden_plant.declared import BENCH_SET
from hidden_plant.plant import Valve
from hidden_plant.sensors import (
    POSITION_NOISE, POSITION_RESOLUTION, PRESSURE_NOISE, PRESSURE_RESOLUTION)
import numpy as np

from booster_ros.diagnosis.experiment.segments import split
from booster_ros.diagnosis.fitting.applicable import free_to_refit
from booster_ros.diagnosis.fitting.intervals import interval_of
from booster_ros.diagnosis.last_fit import draws_of, last_fit
from booster_ros.diagnosis.preparing.preparation import prepare
from booster_ros.diagnosis.searching.search import Search, settled
from booster_ros.model.parameters import from_values
from booster_ros.model.system import PositionerParameters

from .valves import SIZES, Drawn


class Held(NamedTuple):
    """Whether the interval of a parameter holds the truth, and its width beside the truth."""

    parameter: str
    of_effect: bool
    held: bool
    width: float


def intervals(drawn: Drawn) -> list[Held]:
    """Return for each parameter that is known whether its interval in the last fit holds it."""
    declared = declared_parameters()
    experiment = prepare(drawn.record(), declared)
    segments = split(experiment.time, experiment.current)
    names = (drawn.effect,) if drawn.effect in SIZES else ()
    names = tuple('stem_friction' if name.startswith('stem_friction') else name for name in names)
    search = Search(experiment, segments, declared, free_to_refit(declared, experiment), names)
    problem = search.joint(search.problem(), names)
    z = problem.start()
    for j, free in enumerate(problem.freedoms):
        if not np.isfinite(free.sigma):
            z[j] = free.variable(free.knob.typical)
    candidate = search.rate(names, problem, settled(problem, z))
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
        element = '' if free.element is None else f'[{free.element}]'
        found.append(Held(
            free.knob.parameter + element, free.knob.parameter in SIZES.get(drawn.effect, ()),
            interval.low <= known and (interval.open_above or known <= interval.high),
            (interval.high - interval.low) / max(abs(known), 1e-30)))
    return found


def levels(drawn: Drawn) -> tuple[float, float]:
    """Return how loud the noise of pressure and position is held to be, 1 for what it is."""
    noise = prepare(drawn.record(), declared_parameters()).noise
    true = {'chamber_pressure': np.hypot(PRESSURE_NOISE, PRESSURE_RESOLUTION / np.sqrt(12.0)),
            'valve_position': np.hypot(POSITION_NOISE, POSITION_RESOLUTION / np.sqrt(12.0))}
    pressure, position = (noise[name] / level for name, level in true.items())
    return float(pressure), float(position)


def declared_parameters() -> PositionerParameters:
    """Return the name plate of the plant as the model's parameters."""
    valve = Valve()
    return from_values({
        'ep_converter.gain': valve.converter.gain,
        'ep_converter.offset': valve.converter.offset,
        'ep_converter.time_constant': valve.converter.time_constant,
        'booster.s1': valve.booster.s1,
        'booster.s2': valve.booster.s2,
        'booster.s3': valve.booster.s3,
        'booster.opening_gain': valve.booster.opening_gain,
        'booster.max_area': valve.booster.max_area,
        'booster.critical_pressure_ratio': valve.booster.critical_ratio,
        'supply.pressure': valve.supply.pressure,
        'supply.temperature': valve.supply.temperature,
        'actuator.effective_area': valve.chamber.area,
        'actuator.dead_volume': valve.chamber.dead_volume,
        'actuator.polytropic_index': 1.0,
        'actuator.moving_mass': valve.stem.mass,
        'actuator.bench_set': list(BENCH_SET),
        'actuator.travel': valve.stem.travel,
        'actuator.viscous_friction': valve.stem.viscous_friction,
    })
