# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Cases: a plant drawn at random about its declared parameters, with effects, recorded twice."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
import json
from pathlib import Path

import numpy as np

from .currents import KINDS
from .declared import declared_yaml, drawn_valve
from .effects import EFFECTS, put_in
from .plant import SAMPLE_TIME, Valve, run
from .sensors import POSITION_NOISE, PRESSURE_NOISE, Sensors, recorded, sensed
from .truth import true_parameters

FIT_SECONDS, VALIDATION_SECONDS = 150.0, 90.0
WARM_UP_SECONDS = 40.0


@dataclass(frozen=True)
class Case:
    """
    What is put into one record; effects are (key of EFFECTS, signed size in SI units).

    `noise` multiplies the noise of both sensors, `resolution` the steps in which they are recorded.
    """

    name: str
    effects: tuple[tuple[str, float], ...] = ()
    kind: str = 'mixed'
    validation_kind: str = 'mixed'
    spread: str = 'samples'
    seed: int = 0
    noise: float = 1.0
    resolution: float = 1.0

    def plant(self) -> tuple[Valve, Sensors]:
        """Return the true plant: drawn parameters and all effects."""
        valve, sensors = self.clean_valve(), Sensors()
        for key, size in self.effects:
            valve, sensors = put_in(EFFECTS[key], size, valve, sensors)
        return valve, sensors

    def clean_valve(self) -> Valve:
        """Return the same plant without its effects."""
        return drawn_valve(np.random.default_rng([self.seed, 0]), self.spread)

    def currents(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the control currents (A) of the fit and the validation record."""
        return (
            KINDS[self.kind](np.random.default_rng([self.seed, 1]), FIT_SECONDS),
            KINDS[self.validation_kind](np.random.default_rng([self.seed, 2]), VALIDATION_SECONDS),
        )


def play(valve: Valve, sensors: Sensors, current: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """
    Return what noiseless sensors show (Pa, m) of a plant that has settled before the record.

    It settles after an excursion to a lower current, so that whatever has play or friction is
    loaded from one side, as after any operation.
    """
    return _played(valve, sensors, current.tobytes(), WARM_UP_SECONDS)


@lru_cache(maxsize=256)
def _played(
    valve: Valve, sensors: Sensors, current: bytes, warm_up: float
) -> tuple[np.ndarray, np.ndarray]:
    """Play a plant; whoever draws, shows and records it, at several noises, needs that once."""
    currents = np.frombuffer(current)
    samples = round(warm_up / SAMPLE_TIME)
    before = np.full(samples, currents[0])
    before[: samples // 8] -= 10e-6
    rows = run(valve, np.concatenate([before, currents]), -warm_up)
    pressure, position = (channel[samples:] for channel in sensed(sensors, rows))
    pressure.flags.writeable = position.flags.writeable = False
    return pressure, position


def visibility(case: Case) -> tuple[float, float]:
    """Return the RMS change (Pa, m) that the effects make in the fit record, without noise."""
    current, _ = case.currents()
    clean = play(case.clean_valve(), Sensors(), current)
    pressure, position = play(*case.plant(), current)
    return rms(pressure - clean[0]), rms(position - clean[1])


def write_case(case: Case, folder: Path) -> dict[str, object]:
    """Write the three files of a case and return its entry in key.json."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f'{case.name}.yaml').write_text(declared_yaml())
    plant = case.plant()
    for part, (label, current) in enumerate(zip(('fit', 'val'), case.currents(), strict=True)):
        draws = np.random.default_rng([case.seed, 3, part])
        shown = recorded(*play(*plant, current), draws, case.noise, case.resolution)
        _write_record(folder / f'{case.name}_{label}.csv', current, *shown,
                      fine=case.resolution != 1.0)
    pressure, position = visibility(case) if case.effects else (0.0, 0.0)
    return {
        'effect': _settings(case),
        'names': _names(case),
        'location': _location(case),
        'kind': case.kind,
        'noise': {'chamber_pressure': case.noise * PRESSURE_NOISE,
                  'valve_position': case.noise * POSITION_NOISE},
        'parameters': true_parameters(case.clean_valve(), case.effects, case.spread),
        'rms_p': float(np.hypot(pressure, case.noise * PRESSURE_NOISE)),
        'rms_x': float(np.hypot(position, case.noise * POSITION_NOISE)),
    }


def write_cases(cases: Sequence[Case], folder: Path) -> Iterator[str]:
    """Write a folder of cases and its key.json; yield each name when its files are there."""
    key = {}
    for case in cases:
        key[case.name] = write_case(case, folder)
        (folder / 'key.json').write_text(json.dumps(key, indent=1) + '\n')
        yield case.name


def _write_record(
    path: Path, current: np.ndarray, pressure: np.ndarray, position: np.ndarray, *, fine: bool
) -> None:
    time = np.arange(current.size) * SAMPLE_TIME
    np.savetxt(
        path,
        np.column_stack([time, current, pressure, position]),
        fmt=('%.2f', '%.12f', *(('%.6f', '%.12f') if fine else ('%.0f', '%.6f'))),
        delimiter=',',
        header='time,control_current,chamber_pressure,valve_position',
        comments='',
    )


def _settings(case: Case) -> dict[str, float]:
    settings: dict[str, float] = {}
    for key, size in case.effects:
        effect = EFFECTS[key]
        settings |= {path: weight * size for path, weight in effect.weights.items()}
        settings |= effect.fixed
    return settings


def _names(case: Case) -> list[str]:
    if not case.effects:
        return ['none']
    if len(case.effects) == 1:
        return list(EFFECTS[case.effects[0][0]].names)
    return ['+'.join(EFFECTS[key].names[0] for key, _ in case.effects)]


def _location(case: Case) -> str:
    return '+'.join(EFFECTS[key].location for key, _ in case.effects) or 'none'


def rms(values: np.ndarray) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(values**2)))
