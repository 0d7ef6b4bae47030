# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""When a node that cannot keep up thins out what it publishes."""

from booster_ros.nodes.thinning import HOLD, PATIENCE, Thinning


def test_what_is_caught_up_soon_thins_nothing_out():
    thinning = Thinning()
    thinning.note(100, 10.0)
    thinning.note(50, 10.0 + 0.9 * PATIENCE)
    thinning.note(0, 10.0 + 0.95 * PATIENCE)
    thinning.note(50, 10.0 + 1.1 * PATIENCE)
    assert not thinning.active(10.0 + 1.2 * PATIENCE)


def test_what_lasts_does_until_some_time_after_it_is_over():
    thinning = Thinning()
    for moment in (0.0, 0.5 * PATIENCE, PATIENCE):
        assert not thinning.active(moment)
        thinning.note(100, moment)
    assert thinning.active(PATIENCE)
    thinning.note(0, 2.0 * PATIENCE)
    assert thinning.active(PATIENCE + 0.9 * HOLD)
    thinning.note(1, PATIENCE + 0.9 * HOLD)
    assert thinning.active(PATIENCE + 1.8 * HOLD)
    assert not thinning.active(PATIENCE + 2.0 * HOLD)
