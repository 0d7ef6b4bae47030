# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How the table of a term ends."""

from made_task import P
import numpy as np
import pytest

from booster_ros.diagnosis.estimation.fit import Fit
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.diagnosis.hypotheses.discrepancy import with_gentle_ends
from booster_ros.model.discrepancy import (
    CHAMBER, KNOTS, VALVE_POSITION, Discrepancy, covered, interpolate)


@pytest.mark.parametrize(('inner', 'below', 'above'), [
    (np.linspace(0.0, 9.0, 10), 1.0, 9.0),  # as it rose: nine steps back to zero
    (np.r_[4.0, 3.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, -1.0, -3.0], 2.0, 1.5),
    (np.full(10, 5.0), 9.0, 9.0),  # no further than the record went
    (np.zeros(10), 1.0, 1.0),
])
def test_a_table_fades_no_more_steeply_than_it_runs(inner, below, above):
    table = Discrepancy(
        CHAMBER, VALVE_POSITION, tuple(np.linspace(-1e-3, 10e-3, 12)),
        (0.0, *1e-6 * inner, 0.0))
    p = P._replace(discrepancy=table)
    bare = p._replace(discrepancy=table._replace(values=(0.0,) * KNOTS))
    fit = Fit((), np.zeros(0), p, None, 0.0, np.zeros(0), np.zeros((0, 0)))
    gentle = with_gentle_ends(Problem(None, None, bare, ()), fit).base.discrepancy
    ends = -1e-3 * below, 9e-3 + 1e-3 * above
    assert (gentle.knots[0], gentle.knots[-1]) == pytest.approx(ends)
    assert covered(gentle) == pytest.approx((0.0, 9e-3))
    filled = gentle._replace(values=table.values)
    for position in np.linspace(0.0, 9e-3, 50):
        assert interpolate(filled, position) == pytest.approx(
            interpolate(table, position), abs=1e-12)
