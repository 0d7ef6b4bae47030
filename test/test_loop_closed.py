# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Record a valve with fake_controller, close the loop, start the node with what it wrote."""

from __future__ import annotations

import json
from pathlib import Path

from controller_here import played
import numpy as np
import positioner_process
from positioner_process import with_parameters
from ros_process import RosProcess

from booster_ros.programs import close_loop
from booster_ros.records import Record, read_record
from booster_ros.records.csv_file import CsvWriter

DECLARED = Path(__file__).parent.parent / 'config' / 'positioner.yaml'
RATE, DWELL = 20.0, 3.0
NOISE = {'chamber_pressure': 150.0, 'valve_position': 8e-6}


def recorded(path: Path, levels: list[float]) -> Record:
    """Return what the positioner that runs does as levels are played to it."""
    assert played(levels=levels, dwell=DWELL, rate=RATE, lockstep=True, record_csv=path) == ''
    return read_record(path)


def started(*ros_arguments: str) -> RosProcess:
    """Start a positioner that computes coarsely: the shorter it takes."""
    return positioner_process.start(*ros_arguments, *with_parameters(
        publish_rate=RATE, integration_step=0.01, start_paused=True))


def with_sensor_noise(record: Record, path: Path) -> None:
    """Write the record as sensors of a plant would have given it."""
    rng = np.random.default_rng(7)
    columns = {name: record[name] + NOISE.get(name, 0.0) * rng.standard_normal(len(record))
               for name in record.columns}
    with CsvWriter(path, list(columns)) as out:
        out.write_rows(np.column_stack(list(columns.values())))


def test_a_node_started_from_the_result_does_what_the_valve_does(tmp_path):
    """The valve is a positioner whose long thin tube nobody declared."""
    valve = ['--params-file', str(DECLARED), *with_parameters(
        tubing__restriction_area=5e-7, tubing__outlet_volume=4e-5, supply__pressure=4.02e5)]
    levels = [3.6e-4, 4.3e-4, 3.9e-4, 4.5e-4, 3.3e-4, 4.0e-4, 3.8e-4, 4.4e-4]
    new = [3.4e-4, 4.6e-4, 4.1e-4]
    with started(*valve):
        seen = recorded(tmp_path / 'clean.csv', levels)
        truth = recorded(tmp_path / 'truth.csv', new)
    with_sensor_noise(seen, tmp_path / 'valve.csv')

    assert close_loop.main(['--record', str(tmp_path / 'valve.csv'), '--params', str(DECLARED),
                            '--only', 'tubing_restriction', 'supply_droop',
                            '--out', str(tmp_path / 'out')]) == 0
    report = json.loads((tmp_path / 'out' / 'report.json').read_text())
    assert [effect['name'] for effect in report['effects']] == ['tubing_restriction']

    with started('--params-file', str(tmp_path / 'out' / 'positioner.yaml')):
        model = recorded(tmp_path / 'model.csv', new)
    for name, noise in NOISE.items():
        apart = model[name] - truth[name]  # a busy machine may lose a message
        assert np.count_nonzero(np.isnan(apart)) < 0.01 * len(apart)
        distance = float(np.sqrt(np.nanmean(apart ** 2)))
        # what a noisy sensor on the valve would show beside the model
        assert np.hypot(distance, noise) <= 1.3 * noise
        assert report['held_out'][name]['before'] > 3.0 * noise
