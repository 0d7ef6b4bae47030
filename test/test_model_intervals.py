# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What happens between two rows is simulated, however far apart the rows are."""

from itertools import pairwise

import numpy as np
from positioner_runs import PAPER_CURRENT, positioner, rows
import pytest

from booster_ros.model.simulation import simulate
from booster_ros.model.stream import Stream


@pytest.mark.parametrize('edges', [(0, 4), (0, 1, 2, 3, 4)], ids=['at once', 'row by row'])
@pytest.mark.parametrize('between', [1.1, 1.5])
def test_a_current_arrives_after_the_dead_time(between, edges):
    p = positioner({'ep_converter.dead_time': 0.3, 'ep_converter.hysteresis': 2e-6})
    dense = rows(20.0)
    whole = simulate(p, dense, np.where(dense < 0.995, 0.0, PAPER_CURRENT))
    time = np.array([0.0, 1.0, between, 20.0])
    current = np.where(time < 1.0, 0.0, PAPER_CURRENT)
    stream = Stream(p, 0.0, 0.0)
    parts = [stream.advance(time[a:b], current[a:b]) for a, b in pairwise(edges)]
    few = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    assert few['time'].tolist() == time.tolist()
    at = np.round(time / 0.01).astype(int)
    assert whole['chamber_pressure'][-1] > 260e3
    assert np.abs(few['chamber_pressure'] - whole['chamber_pressure'][at]).max() < 10.0
    assert np.abs(few['valve_position'] - whole['valve_position'][at]).max() < 1e-6


def test_a_given_pressure_runs_on_straight_where_a_current_arrives():
    time, pressure = np.array([0.0, 1.0, 3.0]), np.array([150e3, 160e3, 300e3])
    current = np.where(time < 1.0, 0.0, PAPER_CURRENT)
    late, declared = (
        simulate(positioner(values), time, current, pinned={'chamber_pressure': pressure})
        for values in ({'ep_converter.dead_time': 0.7}, None))
    assert late['chamber_pressure'].tolist() == pressure.tolist()
    assert late['valve_position'] == pytest.approx(declared['valve_position'], abs=1e-6)
