# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Write docs/examples/fv_211.csv: what a plant exports of a valve behind a positioner.

The valve of config/closed_loop.yaml with friction of the stem that the file does not declare, as a
data logger sees it at 10 Hz: per cent, bar, noise, and steps of its resolution.
"""

import csv
from pathlib import Path
import sys

import numpy as np
from ros_process import ROOT

from booster_ros.model.parameters import from_values
from booster_ros.model.simulation import simulate
from booster_ros.parameters.file import read_parameter_file

FRICTION, STICTION = 250.0, 75.0
PERIOD, START = 0.1, 8
PRESSURE_NOISE, POSITION_NOISE = 150.0, 8e-6


def set_points() -> np.ndarray:
    """Return the set point in %, row by row: small steps, large ones, a ramp up and down."""
    small = [50.0, *(50.0 + 0.25 * np.array([1, 2, 3, 4, 3, 2, 1, 0, -1]))]
    large = [50.0, 60.0, 50.0, 40.0, 50.0]
    ramp = np.concatenate([np.linspace(50.0, 60.0, 400), np.linspace(60.0, 50.0, 400)])
    return np.concatenate([np.repeat(small, 80), np.repeat(large, 150), ramp, np.full(100, 50.0)])


def write(path: Path) -> None:
    """Write the export."""
    given = read_parameter_file(ROOT / 'config' / 'closed_loop.yaml').physical
    parameters = from_values({
        **given, 'actuator.coulomb_friction': FRICTION, 'actuator.stiction': STICTION})
    travel = parameters.actuator.travel
    opening = set_points()
    time = PERIOD * np.arange(len(opening))
    run = simulate(parameters, time, travel * opening / 100.0,
                   {'chamber_pressure': 225e3, 'valve_position': 0.5 * travel})
    random = np.random.default_rng(211)
    position = run['measured_valve_position'] + POSITION_NOISE * random.standard_normal(len(time))
    pressure = run['measured_chamber_pressure'] + PRESSURE_NOISE * random.standard_normal(len(time))
    with path.open('w', encoding='utf-8', newline='') as stream:
        rows = csv.writer(stream, lineterminator='\n')
        rows.writerow(['Time', 'FV-211 SP [%]', 'FV-211 POS [%]', 'FV-211 PA [bar]'])
        for t, r, x, p in zip(time, opening, 100.0 * position / travel, pressure / 1e5,
                              strict=True):
            stamp = np.datetime64('2026-03-09T08:00:00.0') + np.timedelta64(round(1e3 * t), 'ms')
            rows.writerow([str(stamp)[:21].replace('T', ' '), f'{r:.3f}', f'{x:.2f}', f'{p:.4f}'])


if __name__ == '__main__':
    write(Path(sys.argv[1]))
