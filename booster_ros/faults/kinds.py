# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The faults that a valve can be given, by name.

They are the effects of the catalogue, the loss of the supply, and what sensors do that no effect
is: each sensor with each of `SENSOR_KINDS`. The names of the DAMADICS benchmark are aliases.
"""

from collections.abc import Mapping
from dataclasses import dataclass
import difflib

from ..model.catalogue import EFFECTS, Knob
from ..model.parameters import ParameterError

SUPPLY_LOSS = 'supply_loss'

STUCK, NOISE, RESOLUTION, DROPOUT, SPIKE, DEAD = SENSOR_KINDS = (
    'stuck', 'noise', 'resolution', 'dropout', 'spike', 'dead')

PRESSURE, POSITION = SENSORS = ('pressure', 'position')

STRENGTHS: Mapping[str, float] = {'small': 1.0, 'medium': 2.0, 'big': 4.0}
"""Words for strengths; those of DAMADICS are in the same proportion, 0.25 to 0.5 to 1."""

SUPPLY_SHARE = 0.25
"""Share of the supply pressure that a `supply_loss` of strength 1 takes away."""

SIZES: Mapping[tuple[str, str], float] = {
    (PRESSURE, NOISE): 500.0, (POSITION, NOISE): 2e-5,
    (PRESSURE, RESOLUTION): 1e3, (POSITION, RESOLUTION): 1e-4,
    (PRESSURE, SPIKE): 20e3, (POSITION, SPIKE): 1e-3,
}
"""What strength 1 is, Pa or m: standard deviation, smallest step, height of a spike."""

CHANCES: Mapping[str, float] = {DROPOUT: 0.1, SPIKE: 0.01}
"""Probability for each sample: of a dropout at strength 1, of a spike at any strength."""


@dataclass(frozen=True)
class Fault:
    """
    A fault by name. `strength` is what it has unless told otherwise.

    `knobs` are the sizes of the effect that it is (none for the others), `sensor` and `kind` say
    which reading it falsifies and how.
    """

    name: str
    meaning: str
    strength: float = 1.0
    knobs: tuple[Knob, ...] = ()
    sensor: str = ''
    kind: str = ''


_KIND_MEANINGS = {
    STUCK: 'reading stands still where it is',
    NOISE: 'reading has white noise',
    RESOLUTION: 'reading comes in steps',
    DROPOUT: 'reading now and then stays that of the sample before',
    SPIKE: 'reading now and then is far off for one sample',
    DEAD: 'reading is zero',
}


def _faults() -> dict[str, Fault]:
    found = [
        Fault(effect.name, effect.meaning,
              knobs=tuple(knob for knob in effect.knobs if not knob.shape))
        for effect in EFFECTS.values()]
    found.append(Fault(
        SUPPLY_LOSS, 'the supply pressure falls, to nothing at strength 4',
        strength=STRENGTHS['big']))
    found += [
        Fault(f'{sensor}_sensor_{kind}', f'the {sensor} {_KIND_MEANINGS[kind]}',
              sensor=sensor, kind=kind)
        for sensor in SENSORS for kind in SENSOR_KINDS]
    return {fault.name: fault for fault in found}


FAULTS: Mapping[str, Fault] = _faults()
"""Every fault by name."""

_DAMADICS = {
    'f1': ('travel_limit',),
    'f4': ('stem_friction',),
    'f8': ('position_dependent_friction',),
    'f9': ('chamber_leak',),
    'f10': ('chamber_leak',),
    'f11': ('spring_rate_change', 'bench_set_shift'),
    'f12': ('ep_gain_loss', 'ep_nonlinearity'),
    'f13': ('position_sensor_bias',),
    'f14': ('pressure_sensor_bias',),
    'f15': ('position_backlash',),
    'f16': (SUPPLY_LOSS,),
    'f17': ('flow_force',),
}
"""For each name the faults that fit, the best first: the catalogue may not have it."""

ALIASES: Mapping[str, str] = {
    alias: next(name for name in names if name in FAULTS)
    for alias, names in _DAMADICS.items() if any(name in FAULTS for name in names)}
"""
Names of M. Bartys et al., Control Eng. Practice 14 (2006) 577, and the faults they stand for.

The others are of the process, of which the model knows nothing: sedimentation, erosion, leakage
and evaporation of the medium (f2, f3, f5 to f7), the bypass (f18) and the flow sensor (f19).
"""


def fault_named(name: str) -> Fault:
    """Return the fault of this name or alias; ParameterError, with the nearest, for no such."""
    known = ALIASES.get(name, name)
    if known not in FAULTS:
        near = difflib.get_close_matches(name, [*FAULTS, *ALIASES], 1, 0.6)
        hint = f'; did you mean {near[0]}?' if near else ''
        raise ParameterError(f'there is no fault {name}{hint}')
    return FAULTS[known]
