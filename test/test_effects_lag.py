# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A term without a name in the lag of the E/P converter: slower one way, or far from the end."""

import numpy as np
from positioner_runs import current_for, positioner, rows, settled_at
import pytest

from booster_ros.diagnosis.searching.course import followed
from booster_ros.model.ep_converter import QUICKEST
from booster_ros.model.simulation import simulate

LAG = positioner().ep_converter.time_constant
TIME = rows(3.0)
KNOTS = [*np.linspace(-250e3, -1.0, 6), *np.linspace(1.0, 250e3, 6)]


def stepped(falling, rising, low=180e3, high=240e3, compiled=True):
    """Return a run up and down again; `falling` and `rising` are what the table holds."""
    p = positioner({
        'discrepancy.location': 'ep_converter_lag', 'discrepancy.variable': 'back_pressure_error',
        'discrepancy.knots': KNOTS, 'discrepancy.values': [falling] * 6 + [rising] * 6})
    current = np.where((TIME > 0.5) & (TIME < 1.5), current_for(high), current_for(low))
    return p, simulate(p, TIME, current, settled_at(low), compiled=compiled)


def time_constants(run):
    """Return how long, s, the back pressure takes for 63 % of its way, up and down."""
    back = run['back_pressure']
    for first in (np.searchsorted(TIME, 0.5, 'right'), np.searchsorted(TIME, 1.5)):
        way = (back[first:first + 100] - back[first]) / (back[first + 99] - back[first])
        yield float(np.interp(1.0 - np.exp(-1.0), way, TIME[:100]))


@pytest.mark.parametrize(('falling', 'rising'), [(0.0, 0.0), (3.0, 1.0), (1.0, 3.0), (4.0, 2.0)])
def test_back_pressure_goes_each_way_as_many_times_as_slowly_as_its_table_says(falling, rising):
    slower = np.log(np.maximum([falling, rising], 1.0))
    _, run = stepped(*slower)
    up, down = time_constants(run)
    assert up == pytest.approx(np.exp(slower[1]) * LAG, rel=0.05)
    assert down == pytest.approx(np.exp(slower[0]) * LAG, rel=0.05)


def test_where_the_back_pressure_settles_stays():
    _, run = stepped(np.log(3.0), np.log(2.0))
    _, declared = stepped(0.0, 0.0)
    for row in (140, -1):
        assert run['back_pressure'][row] == pytest.approx(declared['back_pressure'][row], rel=1e-3)


def test_no_table_makes_a_converter_quicker_than_a_solver_can_follow():
    _, run = stepped(-100.0, -100.0)
    _, least = stepped(QUICKEST, QUICKEST)
    assert run['back_pressure'] == pytest.approx(least['back_pressure'], rel=1e-9)
    assert np.isfinite(run['valve_position']).all()


def test_plain_and_compiled_give_the_same_bits():
    _, plain = stepped(1.0, 0.3, compiled=False)
    _, compiled = stepped(1.0, 0.3)
    for name, column in plain.columns.items():
        assert np.array_equal(column, compiled[name]), name


def test_the_variable_of_the_term_is_how_far_the_back_pressure_still_has_to_go():
    p, run = stepped(1.0, 0.0)
    ahead = followed(p, run['time'], run.columns)
    ep = p.ep_converter
    assert ahead == pytest.approx(
        ep.gain * run['control_current'] + ep.offset - run['back_pressure'], abs=1e-6)
    assert ahead.max() > 5e3
    assert ahead.min() < -5e3
