# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A term without a name in the lag of the E/P converter: slower one way, or far from the end."""

import numpy as np
from positioner_runs import current_for, positioner, rows, settled_at
import pytest

from booster_ros.model.term_course import followed
from booster_ros.model.ep_converter import QUICKEST, SLOWEST
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


@pytest.mark.parametrize('compiled', [False, True])
@pytest.mark.parametrize(('value', 'end'), [
    (-100.0, QUICKEST), (-1e308, QUICKEST), (1e3, SLOWEST), (1e308, SLOWEST)])
def test_no_table_makes_a_converter_quicker_or_slower_than_can_be_reckoned(value, end, compiled):
    _, run = stepped(value, value, compiled=compiled)
    _, at_end = stepped(end, end, compiled=compiled)
    assert run['back_pressure'] == pytest.approx(at_end['back_pressure'], rel=1e-9)
    assert np.isfinite(run['valve_position']).all()


def test_plain_and_compiled_give_the_same_bits():
    _, plain = stepped(1.0, 0.3, compiled=False)
    _, compiled = stepped(1.0, 0.3)
    for name, column in plain.columns.items():
        assert np.array_equal(column, compiled[name]), name


def test_behind_dead_time_and_hysteresis_a_settled_back_pressure_has_no_way_to_go():
    p = positioner({'ep_converter.hysteresis': 2e-5, 'ep_converter.dead_time': 0.1})
    p = p._replace(discrepancy=stepped(0.0, 0.0)[0].discrepancy)
    current = np.where((TIME > 0.5) & (TIME < 1.5), current_for(240e3), current_for(180e3))
    run = simulate(p, TIME, current, settled_at(180e3))
    ahead = followed(p, run['time'], run.columns)
    settled = np.abs(np.diff(run['back_pressure'], append=np.nan)) < 1.0
    assert np.count_nonzero(settled) > 150
    assert np.abs(ahead[settled]).max() < 20.0
    moving = np.flatnonzero(np.abs(ahead) > 5e3) * 0.01
    assert moving.min() == pytest.approx(0.6, abs=0.021)


def test_the_variable_of_the_term_is_how_far_the_back_pressure_still_has_to_go():
    p, run = stepped(1.0, 0.0)
    ahead = followed(p, run['time'], run.columns)
    ep = p.ep_converter
    assert ahead == pytest.approx(
        ep.gain * run['control_current'] + ep.offset - run['back_pressure'], abs=1e-6)
    assert ahead.max() > 5e3
    assert ahead.min() < -5e3
