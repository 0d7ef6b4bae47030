# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Write docs/examples/fv_304.csv: what a control system's trend shows of a valve in operation.

The valve of config/closed_loop.yaml, whose positioner follows no faster than at 8 %/s up and 3 %/s
down, and whose position is read with 0.8 % of the travel of lost motion. A flow controller moves
its set point every second; rows are 1 s apart, in per cent with one decimal.
"""

import csv
from pathlib import Path
import sys

import numpy as np
from ros_process import ROOT

from booster_ros.model.parameters import from_values
from booster_ros.model.simulation import simulate
from booster_ros.parameters.file import read_parameter_file

ROWS = 600
UP, DOWN, BACKLASH = 0.08, 0.03, 0.008  # of the travel, the first two per second


def set_points() -> np.ndarray:
    """Return the set point in %, row by row: it wanders, and jumps now and then."""
    random = np.random.default_rng(304)
    wandering = np.empty(ROWS)
    level, target = 55.0, 55.0
    for row in range(ROWS):
        if random.random() < 0.08:
            target = random.uniform(35.0, 75.0)
        level += 0.4 * (target - level) + 1.5 * random.standard_normal()
        wandering[row] = level
    return np.round(wandering, 1)


def write(path: Path) -> None:
    """Write the trend."""
    given = read_parameter_file(ROOT / 'config' / 'closed_loop.yaml').physical
    travel = from_values(given).actuator.travel
    parameters = from_values({
        **given, 'position_controller.rate_limit_up': UP * travel,
        'position_controller.rate_limit_down': DOWN * travel,
        'sensors.position_backlash': BACKLASH * travel})
    time, opening = np.arange(float(ROWS)), set_points()
    start = {'chamber_pressure': 150e3 * (1.0 + opening[0] / 100.0),
             'valve_position': travel * opening[0] / 100.0}
    run = simulate(parameters, time, travel * opening / 100.0, start)
    noise = 0.05 * np.random.default_rng(305).standard_normal(ROWS)
    position = 100.0 * run['measured_valve_position'] / travel + noise
    with path.open('w', encoding='utf-8', newline='') as stream:
        rows = csv.writer(stream, lineterminator='\n')
        rows.writerow(['Time', 'FV-304 SP [%]', 'FV-304 POS [%]'])
        for t, r, x in zip(time, opening, position, strict=True):
            stamp = np.datetime64('2026-03-09T08:00:00') + np.timedelta64(round(t), 's')
            rows.writerow([str(stamp).replace('T', ' '), f'{r:.1f}', f'{x:.1f}'])


if __name__ == '__main__':
    write(Path(sys.argv[1]))
