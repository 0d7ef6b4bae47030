# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where fits of dry friction begin, and how they get from one minimum to the next."""

from types import SimpleNamespace

from made_effect import add_effect
from made_task import P, RAMPS, RAMPS_TIME, place_of, problem_of, seen, z_of
import numpy as np
import pytest

from booster_ros.diagnosis.estimation.fit import fit, fit_at
from booster_ros.diagnosis.estimation.profile import bounded_cost, profiled
from booster_ros.diagnosis.hypotheses.friction import friction_starts, over_minima
from booster_ros.model.catalogue import Knob

TIME, CURRENT = RAMPS_TIME[:900], RAMPS[:900]


def rubbing(sliding, stiction, effect='stem_friction', **others):
    """Return the problem of friction alone in a record of a valve with this friction."""
    plant = P._replace(actuator=P.actuator._replace(
        coulomb_friction=sliding, stiction=stiction, **others))
    return problem_of(seen(plant, current=CURRENT, time=TIME), effect, freedoms=())


@pytest.mark.parametrize(('sliding', 'values', 'damping'), [
    (380.0, {'stiction': 130.0}, {0.0}),
    (380.0, {'stiction': 130.0, 'presliding_stiffness': 2e7, 'presliding_damping': 0.4},
     {0.3, 0.6}),
    (900.0, {'stiction': 0.0}, {0.0})], ids=['sticks', 'yields', 'no stiction'])
def test_a_start_is_near_the_friction_that_was_put_in(sliding, values, damping):
    """Whether a packing yields is told by the first start."""
    problem = rubbing(sliding, **values)
    far = z_of(problem, {'actuator.coulomb_friction': 120.0})
    starts = friction_starts(problem, far)
    slides = [problem.parameters(z).actuator.coulomb_friction for z in starts]
    assert min(abs(one / sliding - 1.0) for one in slides) < 0.15
    assert min(map(problem.cost, starts)) < 0.3 * problem.cost(far)
    first = problem.parameters(starts[0]).actuator
    yielding = round(first.presliding_damping, 6) if first.presliding_stiffness else 0.0
    assert yielding in damping


def test_one_slip_in_another_window_counts_for_little_beside_all_others():
    many = np.full(100, 2.0)
    slip = np.append(many[1:], -300.0)
    assert bounded_cost(slip) < 2.0 * bounded_cost(many) < 0.1 * slip[-1]**2
    # what is further off still counts for more, and what is noise for what it is
    assert bounded_cost(1.1 * slip) > bounded_cost(slip)
    assert bounded_cost(0.1 * many) == pytest.approx(np.sum((0.1 * many)**2), rel=0.01)


def test_all_but_friction_stays_as_it_is_and_the_start_as_given():
    problem = rubbing(400.0, 0.0, 'position_dependent_friction', friction_gradient=300.0)
    z = problem.start()
    gradient = place_of(problem, 'actuator.friction_gradient')
    z[gradient], z[len(problem.freedoms):] = 0.4, 0.5
    for start in friction_starts(problem, z):
        assert start[gradient] == 0.4
        assert not start[len(problem.freedoms):].any()
        low, high = problem.bounds()
        assert ((low <= start) & (start <= high)).all()


def test_a_profile_moves_all_but_what_is_held_to_where_least_is_left():
    rng = np.random.default_rng(3)
    slopes, there = rng.standard_normal((60, 3)), np.array([0.5, -0.2, 0.8])
    problem = SimpleNamespace(bounds=lambda: (np.full(3, -2.0), np.array([2.0, 2.0, 0.6])))
    slip = np.zeros(60)

    def gone_along(z):
        return profiled(problem, z, slopes @ (z - there) + slip, slopes, held=0)

    begin = np.array([0.5, 0.0, 0.0])
    least, z = gone_along(begin)
    assert z[:2] == pytest.approx([0.5, -0.2], abs=0.2)
    assert z[2] == 0.6  # its bound is in the way
    held = np.array([0.3, 0.0, 0.0])
    assert gone_along(held)[1][0] == 0.3
    slip[7] = 400.0  # as a slip in another window
    more, beside = gone_along(begin)
    assert beside == pytest.approx(z, abs=0.1)
    assert more - least == pytest.approx(bounded_cost(slip), rel=0.1)


def test_another_minimum_is_reached_from_the_one_beside_it():
    """A fit by slopes ends where it began, a slip or two to a stroke away."""
    problem = rubbing(380.0, 130.0)
    begin = z_of(problem, {'actuator.coulomb_friction': 372.0, 'actuator.stiction': 150.0,
                           'actuator.presliding_stiffness': 0.0})
    beside = fit(problem, [begin])
    assert abs(beside.parameters.actuator.stiction - 130.0) > 10.0
    found = over_minima(problem, beside)
    assert found.cost < 0.1 * beside.cost
    assert found.parameters.actuator.stiction == pytest.approx(130.0, rel=0.02)
    assert found.parameters.actuator.coulomb_friction == pytest.approx(380.0, rel=0.01)


def test_without_stiction_there_is_one_minimum():
    problem = rubbing(380.0, 0.0, 'position_dependent_friction')
    found = fit_at(problem, problem.start())
    assert over_minima(problem, found) is found


def test_new_friction_is_begun_as_the_other_kind_is(monkeypatch):
    """By what its row in the catalogue says: that it rubs."""
    add_effect(monkeypatch, 'dry_packing', 'stem',
               Knob('actuator.coulomb_friction', 300.0, 0.0, 6e3, rubs=True))
    problem = rubbing(380.0, 130.0, 'dry_packing')
    found = [problem.parameters(z).actuator for z in friction_starts(problem, problem.start())]
    assert min(abs(one.coulomb_friction - 380.0) for one in found) < 150.0


def test_where_no_friction_is_free_nothing_is_tried():
    problem = rubbing(380.0, 130.0, 'chamber_leak')
    z = problem.start() + 0.1
    (alone,) = friction_starts(problem, z)
    assert alone is z
