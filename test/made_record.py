# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Records of a valve as it is declared, for tests of what is prepared from them."""

from dataclasses import replace

from made_diagnosis import DECLARED, record_of as cleaned
import numpy as np

from booster_ros.diagnosis.estimation.parametrisation import put
from booster_ros.diagnosis.prepare.preparation import prepare
from booster_ros.model.simulation import simulate

ROWS = 400
RAMP = np.linspace(20e3, 320e3, ROWS)
TIME = {'time': 0.1 * np.arange(ROWS)}
POSITION = {'valve_position': np.linspace(0.0, 0.016, ROWS)}
CHAMBER = {'chamber_pressure': RAMP}
BACK = {'back_pressure': 180e3 + 0.2 * RAMP}
SUPPLY = {'supply_pressure': np.full(ROWS, 400e3)}
FLOW = {'mass_flow': np.linspace(0.0, 1e-3, ROWS)}


def record_of(**columns):
    """Return the cleaned record of a copy of these columns."""
    return cleaned({name: np.array(values, dtype=float) for name, values in columns.items()})


def step_test(seed=1):
    """Return time, current, chamber pressure and position of a noisy step from mid travel."""
    time = 0.1 * np.arange(ROWS)
    current = np.where(time < 10.0, 0.43e-3, 0.45e-3)
    run = simulate(DECLARED, time, current, {'chamber_pressure': 215e3})
    rng = np.random.default_rng(seed)
    return {
        'time': time, 'control_current': current,
        'chamber_pressure': run['chamber_pressure'] + 150.0 * rng.standard_normal(ROWS),
        'valve_position': run['valve_position'] + 8e-6 * rng.standard_normal(ROWS),
    }


def misses(experiment):
    """Return by channel what the declared model leaves, in that of noise."""
    predicted = experiment.predict(DECLARED)
    return {name: np.sqrt(np.nanmean((values - predicted[name])**2)) / experiment.noise[name]
            for name, values in experiment.measured.items()}


def misfits(columns):
    """Return the mean square of what the true model misses, in squares of the noise found."""
    return {name: miss**2 for name, miss in misses(prepare(record_of(**columns), DECLARED)).items()}


def flow_bench(gain, preload):
    """Return a flow bench's experiment: flow over back pressure at two supply pressures."""
    back = np.tile(np.linspace(60e3, 125e3, 27), 2)
    columns = {'back_pressure': back, 'supply_pressure': np.repeat([150e3, 200e3], 27),
               'chamber_pressure': np.zeros(54), 'mass_flow': np.linspace(0.0, 1e-3, 54)}
    experiment = prepare(cleaned(columns), DECLARED)
    plant = put(put(DECLARED, 'booster.opening_gain', gain), 'booster.intake_preload', preload)
    flow = experiment.predict(plant)['mass_flow']
    return replace(experiment, measured={'mass_flow': flow}, noise={'mass_flow': 1e-6})
