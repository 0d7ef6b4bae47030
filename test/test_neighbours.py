# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which screened effects are fitted to their end, and that they end where they should."""

from dataclasses import replace
from types import SimpleNamespace

from made_task import P, seen, task_of, z_of
import numpy as np
import pytest

from booster_ros.diagnosis.estimation.parametrisation import declared_freedom
import booster_ros.diagnosis.selection.neighbours as searched
from booster_ros.diagnosis.selection.neighbours import (
    _far_off, _furthest, neighbours, refitted)
from booster_ros.diagnosis.selection.screening import screen


def order(costs, noticed):
    """Return effects in order, of what screening reckoned and where first steps ended."""
    steps = [(SimpleNamespace(effect=name, cost=screened), SimpleNamespace(cost=end))
             for name, (screened, end) in costs.items()]
    return [one.effect for one, _ in _furthest(steps, noticed)]


def test_first_steps_that_gained_count_before_what_screening_reckoned():
    assert order({'a': (90.0, 60.0), 'b': (10.0, 70.0), 'c': (20.0, 50.0)}, 80.0) == [
        'c', 'a', 'b']


def test_of_steps_that_lost_their_way_screening_tells_the_order_wherever_they_ended():
    for far in (500.0, 101.0):
        assert order({'idle': (99.9, 99.9), 'right': (40.0, far), 'gained': (95.0, 75.0)},
                     80.0) == ['gained', 'right', 'idle']


def test_around_a_refit_that_has_imitated_what_is_missing_nothing_is(monkeypatch):
    plant = P._replace(ep_converter=P.ep_converter._replace(gain_loss=0.1))
    time = np.arange(0.0, 20.0, 0.05)
    current = 1e-4 * np.array([3.8, 4.3, 4.0, 4.4])[(time // 5.0).astype(int)]
    record = seen(plant, time=time, current=current)
    task = task_of(record, ('ep_gain_loss', 'chamber_leak'), declared_freedom(P, record)[:4])
    root = refitted(task)
    places = []
    monkeypatch.setattr(searched, 'screen', lambda problem, around, name, *rest: places.append(
        [np.array(one.z) for one in around]) or screen(problem, around, name, *rest))
    for imitated in (False, True):
        monkeypatch.setattr(searched, 'leaves_noise', lambda model, said=imitated: said)
        monkeypatch.setattr(searched, '_far_off', lambda model, said=imitated: said)
        near = neighbours(task, root, task.names).near
        assert 'ep_gain_loss' in [one.effects[-1] for one in near]
        by_refit = [any(np.array_equal(z, root.fit.z) for z in around) for around in places]
        assert by_refit == [not imitated] * 2
        places.clear()


@pytest.mark.parametrize(('prior', 'said'), [(5.0, False), (18.2, False), (18.4, True)])
def test_declared_parameters_are_far_off_beyond_what_is_known_of_all_of_them(prior, said):
    parent = SimpleNamespace(score=SimpleNamespace(prior=prior),
                             problem=SimpleNamespace(known=np.arange(10)))
    assert _far_off(parent) is said  # the 95 % quantile of chi-square is 18.31


@pytest.mark.parametrize(('leak', 'seed'), [(2e-8, 4), (4e-8, 1)])
def test_small_leaks_that_do_the_same_to_a_record_have_the_same_evidence(leak, seed):
    """What screening bends the declared parameters to must not decide between them."""
    time = np.arange(0.0, 20.0, 0.05)
    angles = 2.0 * np.pi * np.random.default_rng(seed).uniform(0.1, 0.9, (3, 1)) * time
    plant = P._replace(actuator=P.actuator._replace(leak_area=leak))
    record = seen(plant, None, 2.3e5, 0.433e-3 + 5e-6 * np.sin(angles).sum(axis=0), seed, time)
    task = task_of(record, ('chamber_leak', 'exhaust_seat_leak'))
    near = neighbours(task, refitted(task), task.names).near
    assert len(near) == 2
    assert abs(near[0].score.log_evidence() - near[1].score.log_evidence()) < 0.3


@pytest.mark.parametrize('noise', [True, False])
def test_other_minima_of_friction_are_sought_where_more_than_noise_is_left(monkeypatch, noise):
    plant = P._replace(actuator=P.actuator._replace(coulomb_friction=380.0, stiction=130.0))
    time = np.arange(0.0, 12.0, 0.02)
    record = seen(plant, time=time, current=np.interp(
        time, [0.0, 4.0, 8.0, 12.0], [4.0e-4, 4.3e-4, 4.1e-4, 4.4e-4]))
    task = task_of(record, ('stem_friction',), freedoms=())
    fitted = []

    def over(problem, found):
        fitted.append(found)
        return replace(found, cost=0.5 * found.cost)

    monkeypatch.setattr(searched, 'over_minima', over)
    monkeypatch.setattr(searched, 'leaves_noise', lambda model: noise)
    monkeypatch.setattr(searched, 'friction_starts', lambda problem, z: [z_of(problem, {
        'actuator.coulomb_friction': 380.0, 'actuator.stiction': 130.0})])
    found, = searched._from_a_grid(task, refitted(task), 'stem_friction')
    assert len(fitted) == (0 if noise else 1)
    assert found.fit.cost == pytest.approx(
        found.problem.cost(found.fit.z) * (1.0 if noise else 0.5))
