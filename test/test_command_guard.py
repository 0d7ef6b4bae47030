# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Commands are checked, refused or limited, and go stale."""

import math

import pytest

from booster_ros.nodes.command_guard import (
    ABOVE,
    BELOW,
    INFINITE,
    NOT_A_NUMBER,
    CommandGuard,
    CommandRules,
    Verdict,
    judge,
)
from booster_ros.nodes.throttle import Throttle

REFUSING = CommandRules(0.0, 2e-3, 'refuse', 0.0, 'hold')
LIMITING = REFUSING._replace(invalid_current='limit')
SECOND = 1_000_000_000


@pytest.mark.parametrize(('current', 'rules', 'verdict'), [
    (4.5e-4, REFUSING, Verdict(4.5e-4, None)),
    (0.0, REFUSING, Verdict(0.0, None)),
    (2e-3, REFUSING, Verdict(2e-3, None)),
    (0.45, REFUSING, Verdict(None, ABOVE)),
    (0.45, LIMITING, Verdict(2e-3, ABOVE)),
    (-1e-9, REFUSING, Verdict(None, BELOW)),
    (-1e-9, LIMITING, Verdict(0.0, BELOW)),
    (math.inf, LIMITING, Verdict(None, INFINITE)),
    (-math.inf, REFUSING, Verdict(None, INFINITE)),
])
def test_verdicts(current, rules, verdict):
    assert judge(current, rules) == verdict


@pytest.mark.parametrize('rules', [REFUSING, LIMITING])
def test_what_is_not_a_number_is_always_refused(rules):
    assert judge(math.nan, rules) == Verdict(None, NOT_A_NUMBER)


def test_a_refused_command_leaves_the_one_in_force_and_is_counted():
    guard = CommandGuard(REFUSING)
    guard.offer(3e-4)
    guard.offer(0.3)
    guard.offer(math.nan)
    assert guard.at_tick(0) == 3e-4
    assert (guard.accepted, guard.bad, guard.last_cause) == (1, 2, NOT_A_NUMBER)
    assert guard.refused[ABOVE] == guard.refused[NOT_A_NUMBER] == 1


def test_a_limited_command_is_in_force_and_is_counted():
    guard = CommandGuard(LIMITING)
    guard.offer(0.3)
    assert guard.at_tick(0) == 2e-3
    assert (guard.accepted, guard.limited[ABOVE], guard.refused[ABOVE]) == (1, 1, 0)


@pytest.mark.parametrize(('policy', 'left'), [('hold', 3e-4), ('vent', 0.0)])
def test_a_command_goes_stale_after_the_timeout_in_simulated_time(policy, left):
    guard = CommandGuard(REFUSING._replace(command_timeout=0.5, stale_command=policy))
    guard.offer(3e-4)
    assert guard.at_tick(7 * SECOND) == 3e-4
    assert guard.at_tick(7 * SECOND + SECOND // 2) == 3e-4
    assert not guard.stale
    assert guard.at_tick(7 * SECOND + SECOND // 2 + 1) == left
    assert guard.stale
    guard.offer(4e-4)
    assert guard.at_tick(8 * SECOND) == 4e-4
    assert not guard.stale


def test_a_refused_command_does_not_keep_the_last_one_fresh():
    guard = CommandGuard(REFUSING._replace(command_timeout=0.5, stale_command='vent'))
    guard.offer(3e-4)
    guard.at_tick(0)
    guard.offer(0.3)
    assert guard.at_tick(SECOND) == 0.0


@pytest.mark.parametrize('rules', [REFUSING, LIMITING])
@pytest.mark.parametrize(('low', 'high', 'left'), [
    (0.0, 1e-3, 1e-3), (1.95e-3, 2e-3, 1.95e-3), (0.0, 1.9e-3, 1.9e-3),
])
def test_new_limits_limit_the_current_in_force(rules, low, high, left):
    guard = CommandGuard(rules)
    guard.offer(1.9e-3)
    assert guard.at_tick(0) == 1.9e-3
    assert guard.follow(rules._replace(low=low, high=high)) is (left != 1.9e-3)
    assert guard.at_tick(SECOND) == guard.current == left
    assert not guard.follow(rules)
    assert (guard.at_tick(2 * SECOND), guard.bad) == (left, 0)


def test_a_stale_command_vents_below_the_lower_limit_too():
    guard = CommandGuard(
        REFUSING._replace(low=4e-4, command_timeout=0.5, stale_command='vent'), 4e-4)
    guard.offer(1e-3)
    guard.at_tick(0)
    assert guard.at_tick(SECOND) == 0.0
    assert not guard.follow(guard.rules._replace(low=5e-4, high=9e-4))
    assert guard.at_tick(SECOND) == 0.0


def test_before_the_first_command_nothing_is_stale():
    guard = CommandGuard(REFUSING._replace(command_timeout=0.5, stale_command='vent'), 1e-4)
    assert guard.waiting
    assert guard.at_tick(100 * SECOND) == 1e-4
    assert not guard.stale


def test_a_forced_current_ends_staleness_and_waiting_begins_again():
    guard = CommandGuard(REFUSING._replace(command_timeout=0.5))
    guard.offer(3e-4)
    guard.at_tick(0)
    guard.at_tick(SECOND)
    guard.force(1e-4)
    assert (guard.current, guard.stale, guard.waiting) == (1e-4, False, True)
    assert guard.at_tick(0) == 1e-4


def test_warnings_are_throttled_for_each_kind_by_itself():
    throttle = Throttle(10)
    assert throttle.passes('hot', 0)
    assert throttle.passes('cold', 1)
    assert not throttle.passes('hot', 9)
    assert throttle.passes('hot', 10)
    assert not throttle.passes('hot', 19)
