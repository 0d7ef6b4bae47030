# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where the table of a term has its knots: dense where it bends, ends that fade."""

from made_task import P, RAMPS, RAMPS_TIME, seen, task_of
import numpy as np
import pytest

from booster_ros.diagnosis.estimation.fit import Fit
from booster_ros.diagnosis.estimation.parametrisation import Free
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.diagnosis.hypotheses.knots import (
    looking_closer, where_it_bends, with_gentle_ends)
from booster_ros.diagnosis.hypotheses.discrepancy import terms
from booster_ros.diagnosis.selection import terms as best
from booster_ros.diagnosis.selection.neighbours import refitted
from booster_ros.model.catalogue import Knob
from booster_ros.model.discrepancy import (
    CHAMBER, KNOTS, STEM, VALVE_POSITION, Discrepancy, covered, interpolate)

EVEN = np.linspace(-1e-3, 10e-3, KNOTS)
BUMPER = 1e-3 * np.r_[-1.0, 0.0, np.linspace(10.0, 11.4, 8), 16.0, 17.0]


def along(values, knots=EVEN):
    """Return a table over the valve position."""
    return Discrepancy(CHAMBER, VALVE_POSITION, tuple(knots), tuple(values))


def test_knots_gather_where_a_term_bends():
    kinked = np.maximum(EVEN - 6e-3, 0.0)
    knots = where_it_bends(along(kinked))
    assert np.diff(knots)[np.searchsorted(knots, 6e-3) - 1] < 0.4e-3
    assert np.diff(knots[1:-1]).max() < 3e-3  # some stay elsewhere
    assert (np.diff(knots) > 0.0).all()
    assert covered(along(kinked, knots)) == covered(along(kinked))
    assert (knots[0], knots[-1]) == (EVEN[0], EVEN[-1])


@pytest.mark.parametrize('values', [np.zeros(KNOTS), 3.0 * EVEN, (EVEN - 2e-3)**2])
def test_a_term_that_bends_nowhere_or_everywhere_keeps_its_even_knots(values):
    assert where_it_bends(along(values)) == pytest.approx(EVEN, abs=1e-9)


def test_a_closer_look_begins_with_the_term_as_it_was_fitted():
    fitted = along(np.r_[0.0, 1e-6 * np.array([0, 0, 1, 0, 0, 5, 0, 0, 0, 2.0]), 0.0])
    bare = P._replace(discrepancy=fitted._replace(values=(0.0,) * KNOTS))
    knob = Knob('discrepancy.values', 1e-6, -1.0, 1.0)
    free = tuple(Free(knob, 0.0, 1e-6, element=k) for k in range(1, KNOTS - 1))
    z = np.r_[np.array(fitted.values[1:-1]) / 1e-6, 0.7]  # and a start, which stays
    fit = Fit((), z, P._replace(discrepancy=fitted), None, 0.0, np.zeros(0), np.zeros((0, 0)))
    closer, begin = looking_closer(Problem(None, None, bare, free), fit)
    knots = closer.base.discrepancy.knots
    assert np.abs(np.subtract(knots, fitted.knots)).max() > 0.3e-3
    assert 1e-6 * begin[:-1] == pytest.approx(
        [interpolate(fitted, knot) for knot in knots[1:-1]], abs=1e-15)
    assert begin[-1] == 0.7


def test_a_bumper_that_few_even_knots_meet_is_met_by_knots_that_gather(monkeypatch):
    """Rubber that the stem touches for the last millimetre."""
    pushed = -1500.0 * (np.maximum(BUMPER - 10e-3, 0.0) / 1e-3)**2
    plant = P._replace(discrepancy=Discrepancy(
        STEM, VALVE_POSITION, tuple(BUMPER), tuple(pushed)))
    task = task_of(seen(plant, None, 1.7e5, RAMPS[::2], 4, RAMPS_TIME[::2]))
    root = refitted(task)
    monkeypatch.setattr(best, 'terms', lambda *valve: [
        one for one in terms(*valve) if one.label == 'stem over valve_position'])
    (closer,) = best.best_terms(task, root)
    monkeypatch.setattr(best, 'NOISE', np.inf)
    (even,) = best.best_terms(task, root)
    assert closer.reduced_chi2 < 1.3
    assert even.reduced_chi2 > 1.5 * closer.reduced_chi2


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
