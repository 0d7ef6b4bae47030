# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Simulated time and clock time stay together, to the nanosecond."""

from hypothesis import given, settings, strategies as st

from booster_ros.nodes.tick_clock import NANOSECONDS, TickClock, nanoseconds

PERIOD = nanoseconds(0.01)
STEP = nanoseconds(0.001)
START = 5 * NANOSECONDS


def started(period=PERIOD, step=STEP, max_catch_up=60 * NANOSECONDS, piece=10):
    clock = TickClock(period, step, max_catch_up, piece)
    clock.start(START)
    return clock


def run_due(clock, now):
    """Run what is due at `now` and return the integration steps of each tick."""
    return [clock.run_tick() for _ in range(clock.due(now))]


def test_a_tick_is_due_one_period_after_the_start_and_not_before():
    clock = started()
    assert run_due(clock, START + PERIOD - 1) == []
    assert run_due(clock, START + PERIOD) == [10]
    assert run_due(clock, START + PERIOD) == []


def test_jitter_of_the_timer_changes_no_step_count():
    clock = started()
    jitter = [0, 900_000, 30_000, 2_000_000, 0]
    steps = [run_due(clock, START + (k + 1) * PERIOD + j) for k, j in enumerate(jitter)]
    assert steps == [[10]] * 5
    assert clock.late_ticks == 0
    assert clock.longest_delay == 2_000_000


def test_after_an_hour_of_jitter_not_a_nanosecond_is_lost():
    clock = started(period=nanoseconds(1 / 30))
    steps = 0
    hour = 3600 * NANOSECONDS
    now = START
    while now < START + hour:
        now += 7_654_321_012
        while due := clock.due(now):
            steps += sum(clock.run_tick() for _ in range(due))
    assert now - PERIOD * 4 < START + clock.simulated <= now
    assert steps == clock.simulated // STEP


@given(
    period=st.integers(1_000, 10**8), step=st.integers(1_000, 10**7),
    ticks=st.integers(0, 500))
@settings(max_examples=200, deadline=None)
def test_the_remainder_of_a_period_is_carried(period, step, ticks):
    clock = started(period, step, max_catch_up=10**12, piece=10**6)
    steps = run_due(clock, START + ticks * period)
    assert len(steps) == ticks
    assert sum(steps) == ticks * period // step


def test_late_ticks_are_caught_up_and_counted():
    clock = started()
    assert run_due(clock, START + 4 * PERIOD + 5) == [10] * 4
    assert clock.late_ticks == 3
    assert clock.longest_delay == 3 * PERIOD + 5
    assert run_due(clock, START + 5 * PERIOD) == [10]
    assert clock.late_ticks == 3


def test_a_long_delay_is_caught_up_in_pieces_and_nothing_is_lost():
    clock = started(piece=10)
    now = START + 1000 * PERIOD
    pieces = [len(run_due(clock, now)) for _ in range(100)]
    assert pieces == [10] * 100
    assert clock.backlog == 0
    assert clock.simulated == 1000 * PERIOD
    assert clock.late_ticks == 999


def test_a_jump_forwards_is_not_simulated_but_reported():
    clock = started(max_catch_up=60 * NANOSECONDS)
    run_due(clock, START + PERIOD)
    far = START + 10**9 * NANOSECONDS
    assert len(run_due(clock, far)) == 1
    assert clock.jump == clock.skipped == far - START - 2 * PERIOD
    assert clock.simulated == 2 * PERIOD
    assert run_due(clock, far + PERIOD) == [10]
    assert clock.jump == 0


def test_after_a_jump_backwards_ticks_go_on_from_there():
    clock = started()
    run_due(clock, START + 3 * PERIOD)
    assert run_due(clock, 100) == []
    assert clock.jump == 100 - START - 3 * PERIOD
    assert clock.backward_jumps == 1
    assert run_due(clock, 100 + PERIOD) == [10]
    assert clock.simulated == 4 * PERIOD


def test_a_reset_counts_simulated_time_from_zero_and_keeps_the_grid():
    clock = started()
    run_due(clock, START + 3 * PERIOD)
    clock.reset()
    assert clock.simulated == 0
    assert run_due(clock, START + 4 * PERIOD) == [10]
    assert (clock.simulated, clock.total_ticks) == (PERIOD, 4)


def test_time_before_a_start_is_not_owed():
    clock = started()
    clock.start(START + 500 * PERIOD)
    assert run_due(clock, START + 500 * PERIOD) == []
    assert run_due(clock, START + 501 * PERIOD) == [10]
    assert clock.late_ticks == 0
