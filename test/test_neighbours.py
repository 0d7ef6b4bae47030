# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which screened effects are fitted to their end, by where their first steps led."""

from types import SimpleNamespace

from booster_ros.diagnosis.selection.neighbours import _furthest


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
