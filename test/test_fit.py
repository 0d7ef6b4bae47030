# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""One way to estimate: the best of several starts, how many agree, and warm starts."""

from types import SimpleNamespace

from made_task import P, place_of, problem_of, seen
import numpy as np
import pytest

from booster_ros.diagnosis.data.experiment import Initial
from booster_ros.diagnosis.estimation.fit import carried, fit, fit_at, nominal
from booster_ros.diagnosis.hypotheses.compose import with_effects


class TwoWells:
    """A cost with a least of 0 at z = 1, and another one of about 4 at z = -1."""

    freedoms = (SimpleNamespace(sigma=np.inf),)
    observed = 2

    def __init__(self):
        self.runs = 0

    def residuals(self, z):
        self.runs += 1
        return np.array([10.0 * (z[0]**2 - 1.0), z[0] - 1.0])

    def jacobian(self, z, here, before=None):
        return np.array([[20.0 * z[0]], [1.0]])

    def bounds(self):
        return np.array([-5.0]), np.array([5.0])

    def start(self):
        return np.array([-1.3])

    def parameters(self, z):
        return P

    def initial(self, z, p):
        return Initial(0.0)


def at(*places):
    return [np.array([place]) for place in places]


@pytest.mark.parametrize(('starts', 'end'), [
    (at(-1.2), -1.0), (at(0.9), 1.0), (at(-1.2, 0.9, 1.3), 1.0), (at(0.9, -1.2), 1.0)])
def test_the_best_end_of_several_starts_is_taken(starts, end):
    found = fit(TwoWells(), starts)
    assert found.z == pytest.approx([end], abs=0.02)
    assert found.cost == pytest.approx(found.residuals @ found.residuals)


def test_without_starts_a_fit_begins_with_what_is_given():
    assert fit(TwoWells()).z == pytest.approx([-1.0], abs=0.02)
    assert fit(TwoWells(), []).z == fit(TwoWells()).z


def test_first_steps_end_before_the_fit_does():
    problem = TwoWells()
    found = fit(problem, [np.array([4.0])], 2)
    assert problem.runs <= 4
    assert found.cost > fit(TwoWells(), at(4.0)).cost + 1.0


def test_a_start_beyond_the_bounds_is_taken_within():
    assert fit(TwoWells(), at(40.0)).z == pytest.approx([1.0], abs=0.02)


@pytest.fixture(scope='module')
def declared():
    return problem_of(seen(P))


def test_a_warm_start_has_what_its_sources_have(declared):
    joint = with_effects(declared, ('chamber_leak',))
    first = fit_at(declared, np.linspace(-0.1, 0.1, len(declared.start())), np.zeros((1, 1)))
    leak = place_of(joint, 'actuator.leak_area')
    second = fit_at(joint, np.full(len(joint.start()), 0.3), np.zeros((1, 1)))
    assert carried(joint, first)[:leak] == pytest.approx(first.z[:leak])
    assert carried(joint, first)[leak] == 0.0
    assert carried(joint, first)[leak + 1:] == pytest.approx(first.z[leak:])
    both = carried(joint, first, second)  # the later counts, but the start is the first's
    assert both[:leak + 1] == pytest.approx(0.3)
    assert both[leak + 1:] == pytest.approx(first.z[leak:])


def test_of_a_nominal_start_only_effects_are_not_as_given(declared):
    joint = with_effects(declared, ('chamber_leak',))
    fresh = nominal(joint, np.full(len(joint.start()), 0.3))
    assert [joint.freedoms[j].knob.parameter for j in np.flatnonzero(fresh)] == [
        'actuator.leak_area']
