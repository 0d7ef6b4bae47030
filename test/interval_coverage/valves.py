# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Valves of the hidden plant of which all parameters are known, and their records."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from hidden_plant import truth
from hidden_plant.cases import play
from hidden_plant.currents import KINDS, LEVELS
from hidden_plant.declared import drawn_valve
from hidden_plant.effects import EFFECTS, put_in
from hidden_plant.plant import SAMPLE_TIME, Valve
from hidden_plant.sensors import (
    POSITION_NOISE, POSITION_RESOLUTION, PRESSURE_NOISE, PRESSURE_RESOLUTION, Sensors)
import numpy as np

from booster_ros.signals.noise_autocorrelation import Noise
from booster_ros.records.record import Record

SECONDS = 100.0

HOLD = 0.5
"""Time between the steps of `hops`, s."""


def hops(generator: np.random.Generator, seconds: float) -> np.ndarray:
    """Return a current (A) that steps to another random level every HOLD seconds."""
    levels = generator.uniform(*LEVELS, round(seconds / HOLD))
    return np.repeat(levels, round(HOLD / SAMPLE_TIME))


CURRENTS = {**KINDS, 'hops': hops}

NOISE: Mapping[str, Noise] = {
    name: Noise(float(np.hypot(level, resolution / np.sqrt(12.0))), 0.0, resolution)
    for name, level, resolution in (
        ('chamber_pressure', PRESSURE_NOISE, PRESSURE_RESOLUTION),
        ('valve_position', POSITION_NOISE, POSITION_RESOLUTION))}
"""Noise of the plant's sensors, white: their own and that of rounding."""

SIZES: Mapping[str, tuple[str, ...]] = {
    effect: tuple(truth.SIZES[effect]) for effect in (
        'chamber_leak', 'ep_hysteresis', 'dead_time', 'booster_dead_band', 'supply_droop',
        'heat_transfer', 'bench_set_shift', 'position_backlash', 'pressure_sensor_lag',
        'stem_friction_coulomb')
}
"""Effects of the plant whose size is one that the model has as well, in the same unit."""


@dataclass(frozen=True)
class Drawn:
    """
    A valve drawn from the tolerances, with an effect of a size drawn between small and large.

    `carried` is how much of the noise carries over from row to row, `kind` that of the current.
    """

    effect: str
    carried: float
    seed: int
    kind: str = 'mixed'

    def valve(self) -> tuple[Valve, Sensors, float]:
        """Return the plant, its sensors and the size of its effect (0 without one)."""
        generator = np.random.default_rng([self.seed, 0])
        valve, sensors = drawn_valve(generator, 'tolerances'), Sensors()
        if not self.effect:
            return valve, sensors, 0.0
        small, _, large = EFFECTS[self.effect].sizes
        size = float(np.exp(generator.uniform(np.log(small), np.log(large))))
        return *put_in(EFFECTS[self.effect], size, valve, sensors), size

    def truth(self) -> dict[truth.Key, float]:
        """Return what was put in, by name and element of the model's parameters."""
        valve, _, size = self.valve()
        of_effect = truth.effect_truth(self.effect, size) if self.effect else {}
        return {**truth.declared_truth(valve), **{(name, None): v for name, v in of_effect.items()}}

    def record(self) -> Record:
        """Return what a recorder with this noise writes of it."""
        valve, sensors, _ = self.valve()
        current = CURRENTS[self.kind](np.random.default_rng([self.seed, 1]), SECONDS)
        pressure, position = play(valve, sensors, current)
        generator = np.random.default_rng([self.seed, 2, round(100 * self.carried)])
        rows = len(current)
        columns = {'time': SAMPLE_TIME * np.arange(rows), 'control_current': current}
        for (name, noise), signal in zip(NOISE.items(), (pressure, position)):
            columns[name] = replace(noise, correlation=self.carried).added_to(signal, generator)
        return Record(columns, f'{self.effect or "nothing"} {self.seed}', (), np.arange(rows) + 2)
