# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Which effects an experiment can show at all, and which declared parameters.

A measured channel that drives the model cuts off everything upstream of it, a sensor that was not
recorded has no error, and a sweep without a clock knows no delays: in it a lag looks like friction.
"""

import numpy as np

from booster_ros.diagnosis.data.experiment import COMMANDS, DriveNoise, Experiment
from booster_ros.diagnosis.estimation.parametrisation import OF_THE_CHAMBER, Free, declared_freedom
from booster_ros.model.actuator import VESSEL
from booster_ros.model.booster import NO_BOOSTER
from booster_ros.model.catalogue import EFFECTS, Effect, has_part
from booster_ros.model.gas import ISO_6358
from booster_ros.model.system import PositionerParameters

NEAR_BENCH_SET = 0.25
"""Share of the bench set's range below it within which a shifted spring might let the stem go."""

TOLD_SLOWLY = frozenset((
    'slew_limit', 'positioner_dead_zone', 'positioner_tuning', 'position_backlash',
    'position_sensor_lag', 'position_sensor_bias', 'travel_limit'))
"""Effects that rows of seconds tell of a valve behind a controller."""


def applicable(experiment: Experiment, declared: PositionerParameters) -> tuple[str, ...]:
    """Return the names of the effects that can change what is compared in this experiment."""
    resting = _stem_rests(experiment, declared)
    return tuple(name for name, effect in EFFECTS.items()
                 if has_part(declared, effect) and _shows(effect, experiment)
                 and (name in TOLD_SLOWLY or not experiment.is_slow)
                 and not (resting and effect.location == 'stem')
                 and effect.orifice_law in (None, declared.booster.orifice_law))


def _stem_rests(experiment: Experiment, declared: PositionerParameters) -> bool:
    """Tell whether no position was seen and the pressure seen never comes near the bench set."""
    pressure = experiment.measured.get('chamber_pressure')
    if pressure is None or 'valve_position' in experiment.measured:
        return False
    low, high = declared.actuator.bench_set
    highest = float(np.max(pressure[np.isfinite(pressure)], initial=-np.inf))
    return highest < low - NEAR_BENCH_SET * (high - low)


def _shows(effect: Effect, experiment: Experiment) -> bool:
    if experiment.quasi_static and effect.needs_clock:
        return False
    noise = experiment.drive_noise.get(effect.driven_by, DriveNoise(0.0)).level
    if effect.driven_by and np.var(experiment.pinned.get(effect.driven_by, 0.0)) <= 2.0 * noise**2:
        return False
    compared, pinned = {*experiment.channels}, experiment.pinned
    chamber_follows = 'chamber_pressure' not in pinned
    commanded = not {*COMMANDS}.isdisjoint(experiment.drives)
    flows = chamber_follows or 'mass_flow' in compared
    at_booster = flows and (commanded or 'back_pressure' in pinned)
    return {
        'sensor': effect.reading in compared,
        'stem': not compared.isdisjoint(('valve_position', 'chamber_pressure')) or (
            chamber_follows and 'mass_flow' in compared),
        'chamber': chamber_follows,
        'position_controller': experiment.in_loop,
        'ep_converter': commanded,
        'supply': at_booster and 'supply_pressure' not in pinned,
    }.get(effect.location, at_booster)


def free_to_refit(declared: PositionerParameters, experiment: Experiment) -> tuple[Free, ...]:
    """Return the declared parameters that a refit to this experiment may turn."""
    return tuple(free for free in declared_freedom(declared, experiment)
                 if matters(free.knob.parameter, experiment)
                 and _acts(free.knob.parameter, declared))


def _acts(parameter: str, declared: PositionerParameters) -> bool:
    """Tell whether the rig has what the parameter is of, and its law of flow knows it."""
    component = parameter.split('.')[0]
    if component == 'booster' and declared.booster.kind == NO_BOOSTER:
        return False
    if component == 'actuator' and declared.actuator.kind == VESSEL:
        return parameter in OF_THE_CHAMBER
    known_to_one_law = parameter == 'booster.critical_pressure_ratio'
    return not known_to_one_law or declared.booster.orifice_law == ISO_6358


def matters(parameter: str, experiment: Experiment) -> bool:
    """Tell whether a declared parameter, by its dotted name, can change what is compared."""
    component, pinned = parameter.split('.')[0], experiment.pinned
    if experiment.is_slow:
        return False
    if 'chamber_pressure' in pinned and not experiment.is_flow_bench:
        return component == 'actuator' and parameter not in OF_THE_CHAMBER
    return not {
        'position_controller': not experiment.in_loop, 'actuator': experiment.is_flow_bench,
        'supply': 'supply_pressure' in pinned, 'ep_converter': 'back_pressure' in pinned,
    }.get(component, False)
