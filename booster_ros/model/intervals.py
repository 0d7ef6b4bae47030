# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""One interval of standing inputs: what happens in it, whatever commands the current."""

from .ahead import covers, go_along
from .memory import STANDING, STEP_AHEAD, TRIAL_STEP, measure, seen_current
from .solver import Workspace, advance
from .state import CHAMBER, POSITION
from .system import PositionerParameters, depends_on_time, follow_play, hold_inactive_states

LONGEST_STEP = 0.5
"""Longest step over several intervals, s, which is made only while the current stands."""


def interval(
    p: PositionerParameters, time: float, length: float, current: float, pinned, y, memory,
    active, count: int, tolerance: float, w: Workspace,
) -> float:
    """
    Take the positioner over `length` s with the current standing at `current` A.

    Return the current that the E/P converter acted on, A. `y` and `memory` change in place. The
    states in `pinned` are given in `y` and are not among the `active`.
    """
    middle = time + 0.5 * length  # what depends on time stands over an interval, as a current does
    seen = seen_current(p, memory, current)
    before = (y[CHAMBER], y[POSITION])
    stands = seen == memory[STANDING] and len(pinned) == 0
    if stands and covers(memory, length):
        go_along(y, memory, length, active, count, w)
    else:
        hold_inactive_states(p, middle, y, pinned)
        # a current that has stood over an interval is trusted to stand on
        longest_ahead = 0.0
        if stands and not depends_on_time(p):
            longest_ahead = LONGEST_STEP
        else:
            memory[STANDING] = seen
            memory[STEP_AHEAD] = 0.0
            memory[TRIAL_STEP] = min(memory[TRIAL_STEP], length)
        advance(
            p, middle, seen, length, y, memory, active, count, tolerance, w, longest_ahead)
    hold_inactive_states(p, time + length, y, pinned)
    follow_play(p, y)
    measure(p, memory, before, y, length)
    return seen
