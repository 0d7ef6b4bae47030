# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which effects could explain Table III: what is known to be in a triple is found in it."""

import numpy as np
import pytest

from booster_ros.model.system import PositionerParameters
from booster_ros.paper import table_three
from booster_ros.paper.printed import table_3

THROTTLED = 3e-6


@pytest.fixture(scope='module')
def ranked():
    """Return a ranking for indices that a throttling tube made."""
    declared = PositionerParameters()
    throttled = declared._replace(
        tubing=declared.tubing._replace(restriction_area=THROTTLED))
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(table_three, 'ROW', 0.01)  # what is wanted is of such rows as well
        wanted = np.log(table_three.played(throttled)) - np.log(table_three.played(declared))
        return table_three.rank(wanted, (
            'chamber_leak', 'position_sensor_lag', 'pressure_sensor_lag', 'tubing_restriction'))


def test_the_hidden_effect_reproduces_its_indices(ranked):
    best = ranked[0]
    assert best.name == 'tubing_restriction'
    assert best.mismatch < 1e-3
    assert best.sizes['tubing.restriction_area'] == pytest.approx(THROTTLED, rel=0.05)
    assert best.cosine > 0.99


def test_others_do_worse_and_come_later(ranked):
    mismatches = [one.mismatch for one in ranked]
    assert mismatches == sorted(mismatches)
    assert mismatches[1] > 10.0 * mismatches[0]


def test_what_the_pressure_does_not_show_is_left_out(ranked):
    assert {one.name for one in ranked} == {
        'chamber_leak', 'pressure_sensor_lag', 'tubing_restriction'}


def test_the_played_step_is_the_papers():
    indices = table_three.played(PositionerParameters())._asdict()
    for name, printed in table_3().items():
        assert indices[name] == pytest.approx(printed.simulated, rel=0.01), name


@pytest.mark.campaign
def test_a_leak_points_away_from_the_measured_column_and_a_tube_towards_it():
    wanted = table_three.measured_change(table_3())
    nothing = float(np.sqrt(np.mean(wanted[1:] ** 2)))
    leak = table_three.suspect(wanted, 'chamber_leak')
    tube = table_three.suspect(wanted, 'tubing_restriction')
    assert leak.cosine == pytest.approx(0.0, abs=1e-6)
    assert leak.mismatch == pytest.approx(nothing, rel=1e-3)
    assert tube.cosine > 0.9
    assert tube.mismatch < 0.5 * nothing
    # the final pressure did not differ and must not
    assert tube.indices.final_pressure == pytest.approx(270.3, abs=0.1)
