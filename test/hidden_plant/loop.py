# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Cases in closed loop: a positioner of one of three firmwares holds the valve at set points.

A loop makes up for what goes on below it. So a size that is drawn is enlarged until the record
shows the effect as much as those of medium size show in open loop: against the same plant without
the effect, one of its channels differs by MEDIUM times its noise and what the positioner leaves to
chance there (RMS).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
import json
from pathlib import Path

import numpy as np

from .cases import rms
from .declared import declared_groups, drawn_valve
from .effects import CATALOGUED, Effect, put_in
from .plant import SAMPLE_TIME, Valve, run
from .positioner import INTEGRATING, KINDS, PIEZO, PROPORTIONAL, Positioner
from .sensors import POSITION_NOISE, PRESSURE_NOISE, Sensors, recorded, sensed

SECONDS = {'fit': 70.0, 'val': 40.0}
WARM_UP_SECONDS = 20.0
EVERY = 5  # samples from row to row of a record

FIRMWARES = {
    PROPORTIONAL: Positioner(PROPORTIONAL, gain=0.3, rate_time=0.03),
    INTEGRATING: Positioner(INTEGRATING, dead_zone=1.6e-5),
    PIEZO: Positioner(PIEZO, gain=0.005, rate_time=0.2, dead_zone=2e-5, shortest=2e-4),
}
MEDIUM = 10.0
ENLARGED = 1.5  # from one size that is tried to the next
SHARES = {'detuned', 'weak_coil'}
SMALLEST_ADC = 16e-3 / 2**14  # m: where a pulse ends hangs on as much as that
TUNED_WITHIN = 0.05  # of the declared gain, one standard deviation

EFFECTS: dict[str, Effect] = {
    'stem_friction': CATALOGUED['stem_friction'],
    'position_backlash': CATALOGUED['position_backlash'],
    'chamber_leak': CATALOGUED['chamber_leak'],
    'supply_droop': CATALOGUED['supply_droop'],
    'lever_slack': Effect(
        'position_controller', ('feedback_backlash',), {'positioner.slack': 1.0},
        (1e-4, 2e-4, 5e-4)),
    'wide_dead_zone': Effect(
        'position_controller', ('positioner_dead_zone',), {'positioner.widened': 1.0},
        (5e-5, 1e-4, 2e-4)),
    'slow_ramp': Effect(
        'position_controller', ('slew_limit',),
        {'positioner.rise_time': 1.0, 'positioner.fall_time': 1.6}, (2.0, 4.0, 8.0)),
    'detuned': Effect(
        'position_controller', ('positioner_tuning',), {'positioner.detuned': -1.0},
        (0.5, 0.7, 0.85)),
    'weak_coil': Effect(
        'ep_converter', ('ep_gain_loss',), {'converter.gain': -244.45e3 / 0.4524e-3},
        (0.12, 0.18, 0.25)),
    'stop_in_the_way': Effect(
        'stem', ('travel_limit',), {'stem.travel': -1.0}, (1.5e-3, 3e-3, 5e-3)),
}


@dataclass(frozen=True)
class LoopCase:
    """What is put into one valve with its positioner: (key of EFFECTS, size in SI units)."""

    name: str
    kind: int
    effects: tuple[tuple[str, float], ...] = ()
    seed: int = 0

    def plant(self) -> tuple[Valve, Sensors]:
        """Return the true plant: drawn parameters and all effects."""
        generator = np.random.default_rng([self.seed, 10])
        off = TUNED_WITHIN * float(np.clip(generator.standard_normal(), -2.0, 2.0))
        declared = FIRMWARES[self.kind]
        valve = drawn_valve(np.random.default_rng([self.seed, 0]), 'samples')._replace(
            positioner=declared._replace(gain=declared.gain * (1.0 + off)))
        sensors = Sensors()
        for key, size in self.effects:
            valve, sensors = put_in(EFFECTS[key], size, valve, sensors)
        return valve, sensors


def set_points(generator: np.random.Generator, seconds: float) -> np.ndarray:
    """Return set points, m, one a sample: large and small steps, ramps, a stroke to either end."""
    travel = Valve().stem.travel
    rows = round(seconds / SAMPLE_TIME / EVERY)
    level, pieces = float(generator.uniform(0.3, 0.7)), []
    strokes = {2: 0.02, 3: 0.98}
    while sum(map(len, pieces)) < rows:
        stands = round(generator.uniform(2.5, 6.0) / SAMPLE_TIME / EVERY)
        pieces.append(np.full(stands, level))
        before = level
        size = generator.choice([0.005, 0.02, 0.1, 0.3]) * generator.choice([-1.0, 1.0])
        level = strokes.get(len(pieces) // 2, level + size)
        level = min(max(level, 0.1), 0.9) if len(pieces) // 2 not in strokes else level
        if generator.random() < 0.3:
            lasts = round(generator.uniform(3.0, 8.0) / SAMPLE_TIME / EVERY)
            pieces.append(np.linspace(before, level, lasts))
    return travel * np.repeat(np.concatenate(pieces)[:rows], EVERY)


def play(case: LoopCase, part: str, shaken: float = 0.0) -> tuple[np.ndarray, ...]:
    """
    Return set points, and what noiseless sensors show of pressure and position: Pa and m.

    `part` is 'fit' or 'val'; set points are shaken by so much, m, from sample to sample.
    """
    number = list(SECONDS).index(part)
    asked = set_points(np.random.default_rng([case.seed, 11, number]), SECONDS[part])
    before = np.full(round(WARM_UP_SECONDS / SAMPLE_TIME), asked[0])
    before[:len(before) // 4] -= 0.05 * Valve().stem.travel
    course = np.concatenate([before, asked])
    draws = np.random.default_rng([case.seed, 13])
    valve, sensors = case.plant()
    rows = run(valve, course + shaken * draws.standard_normal(len(course)), -WARM_UP_SECONDS)
    return asked[::EVERY], *(channel[len(before)::EVERY] for channel in sensed(sensors, rows))


@dataclass(frozen=True)
class Unaffected:
    """What noiseless sensors show of a plant without its effects, and noise with chance (RMS)."""

    channels: tuple[np.ndarray, ...]
    noises: tuple[float, ...]

    @classmethod
    def of(cls, case: LoopCase) -> 'Unaffected':
        """Return what the fit record of a case is without its effects."""
        clean = replace(case, effects=())
        _, *still = play(clean, 'fit')
        _, *shaken = play(clean, 'fit', SMALLEST_ADC)
        return cls(tuple(still), tuple(
            float(np.hypot(noise, rms(moved - one))) for one, moved, noise in zip(
                still, shaken, (PRESSURE_NOISE, POSITION_NOISE), strict=True)))

    def visibility(self, case: LoopCase) -> float:
        """Return how much the fit record shows of the effects, in multiples of noise and chance."""
        _, *seen = play(case, 'fit')
        return max(rms(one - still) / noise for one, still, noise in zip(
            seen, self.channels, self.noises, strict=True))


def shown(case: LoopCase) -> LoopCase:
    """
    Return the case with its effects enlarged until the fit record shows them.

    Shares of what there is, as those of a gain, stay below one.
    """
    if not case.effects:
        return case
    unaffected = Unaffected.of(case)
    while unaffected.visibility(case) < MEDIUM:
        larger = tuple((key, size * ENLARGED) for key, size in case.effects)
        if any(key in SHARES and size >= 1.0 for key, size in larger):
            break
        case = replace(case, effects=larger)
    return case


def write_case(case: LoopCase, folder: Path) -> dict[str, object]:
    """Write the three files of a case and return its entry in key.json."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f'{case.name}.yaml').write_text(declared_yaml(case.kind))
    for number, part in enumerate(SECONDS):
        asked, *shown = play(case, part)
        draws = np.random.default_rng([case.seed, 12, number])
        pressure, position = recorded(*shown, draws)
        np.savetxt(
            folder / f'{case.name}_{part}.csv',
            np.column_stack([np.arange(len(position)) * EVERY * SAMPLE_TIME, asked,
                             pressure, position]),
            fmt=('%.2f', '%.7f', '%.0f', '%.6f'), delimiter=',', comments='',
            header='time,set_point,chamber_pressure,valve_position')
    effects = [EFFECTS[key] for key, _ in case.effects]
    return {
        'effect': dict(case.effects), 'kind': KINDS[case.kind],
        'names': list(effects[0].names) if effects else ['none'],
        'location': '+'.join(one.location for one in effects) or 'none',
        'noise': {'chamber_pressure': PRESSURE_NOISE, 'valve_position': POSITION_NOISE},
    }


def write_cases(cases: Sequence[LoopCase], folder: Path) -> Iterator[str]:
    """Write a folder of cases and its key.json; yield each name when its files are there."""
    key = {}
    for case in cases:
        key[case.name] = write_case(shown(case), folder)
        (folder / 'key.json').write_text(json.dumps(key, indent=1) + '\n')
        yield case.name


def drawn(seed: int) -> list[LoopCase]:
    """
    Return 30 cases: each firmware clean and with nine of EFFECTS, of drawn size, shuffled.

    Their sizes are those of open loop: see `shown`.
    """
    generator = np.random.default_rng([seed, 98])
    cases = []
    for kind in FIRMWARES:
        keys = [None, *generator.choice(list(EFFECTS), 9, replace=False)]
        for key in keys:
            effects = () if key is None else ((str(key), _drawn_size(str(key), generator)),)
            cases.append((kind, effects))
    order = generator.permutation(len(cases))
    return [LoopCase(f'{number:02d}_{KINDS[kind]}_{effects[0][0] if effects else "none"}',
                     kind, effects, 1000 * seed + number)
            for number, (kind, effects) in enumerate((cases[i] for i in order), start=1)]


def _drawn_size(key: str, generator: np.random.Generator) -> float:
    return EFFECTS[key].sizes[int(generator.integers(1, 3))] * float(generator.uniform(0.8, 1.2))


def declared_yaml(kind: int) -> str:
    """Return the declared parameters with those of the positioner, as a ROS 2 parameter file."""
    declared = FIRMWARES[kind]
    controller = {
        'enabled': True, 'output': 'pulses' if kind == PIEZO else 'continuous',
        'gain': declared.gain, 'integral_time': declared.reset_time if kind == INTEGRATING else 0.0,
        'derivative_time': declared.rate_time, 'bias': declared.middle,
        'current_limits': [0.0, declared.highest], 'dead_zone': declared.dead_zone,
        'period': declared.sample_time, 'pulse_slew': declared.slew,
        'least_pulse': declared.shortest,
    }
    lines = ["# declared parameters of this record's positioner, SI units, pressures gauge",
             '/**:', '  ros__parameters:']
    for group, values in {**declared_groups(), 'position_controller': controller}.items():
        lines.append(f'    {group}:')
        lines += [f'      {name}: {str(value).lower() if isinstance(value, bool) else value}'
                  for name, value in values.items()]
    return '\n'.join(lines) + '\n'
