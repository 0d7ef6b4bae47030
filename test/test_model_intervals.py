# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What happens between two rows is simulated, however far apart the rows are."""

from itertools import pairwise

import numpy as np
from positioner_runs import PAPER_CURRENT, current_for, positioner, rows, settled_at
import pytest

from booster_ros.model.kernel import parts_of
from booster_ros.model.simulation import Plant, simulate
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


RIPPLE = {'supply.ripple': 20e3, 'supply.ripple_frequency': 50.0}
"""Its top comes with every row of 20 ms where the phase is a quarter turn."""


@pytest.mark.parametrize('phase', [0.0, 0.5 * np.pi])
def test_a_ripple_is_none_whose_top_comes_with_every_row(phase):
    p = positioner({**RIPPLE, 'supply.ripple_phase': phase})
    ends = []
    for dt in (0.02, 1e-3):
        time = rows(3.0, dt)
        run = simulate(p, time, np.full_like(time, current_for(220e3)), settled_at(220e3))
        ends.append(run['chamber_pressure'][-1])
    assert ends[1] - 220e3 > 500.0  # a chamber that fills sooner than it empties
    assert ends[0] == pytest.approx(ends[1], abs=10.0)


def test_a_plant_in_long_steps_follows_a_ripple():
    ends = []
    for step in (0.1, 1e-3):
        plant = Plant(positioner({**RIPPLE, 'supply.ripple_phase': 0.5 * np.pi}), step)
        plant.reset(220e3, None, float(current_for(220e3)))
        plant.advance(float(current_for(220e3)), round(1.0 / step))
        ends.append(plant.outputs().chamber_pressure)
    assert ends[0] == pytest.approx(ends[1], abs=10.0)


@pytest.mark.parametrize(('values', 'parts'), [
    ({}, 1), ({'supply.ripple_frequency': 100.0}, 1),
    ({'supply.ripple': 2e3, 'supply.ripple_frequency': 0.0}, 1),
    ({'supply.ripple': 2e3, 'supply.ripple_frequency': 5.0}, 1),
    ({'supply.ripple': 2e3, 'supply.ripple_frequency': 20.0}, 4),
])
def test_rows_are_divided_no_more_than_a_ripple_asks_for(values, parts):
    assert parts_of(positioner(values), 0.01, 0.02) == parts


SWINGS = {'discrepancy.location': 'ep_converter', 'discrepancy.variable': 'time',
          'discrepancy.knots': list(np.linspace(0.0, 4.0, 12)),
          'discrepancy.values': [1e3 * (k % 2) for k in range(12)]}


@pytest.mark.parametrize(('values', 'pascals'), [
    ({'supply.ripple': 20e3, 'supply.ripple_frequency': 2.0, 'supply.droop': 1e7}, 10.0),
    ({'ep_converter.drift': 20e3, 'ep_converter.drift_time_constant': 1.0}, 2.0),
    (SWINGS, 1.0),
], ids=['ripple behind a regulator', 'drift', 'term over time'])
def test_what_goes_by_time_comes_no_half_row_late(values, pascals):
    ends = []
    for dt in (0.02, 1e-3):
        time = rows(3.0, dt)
        current = np.where(time < 1.9999, current_for(220e3), current_for(250e3))
        run = simulate(positioner(values), time, current, settled_at(220e3))
        ends.append(run['chamber_pressure'][::round(0.02 / dt)])
    assert np.abs(ends[0] - ends[1]).max() < pascals
