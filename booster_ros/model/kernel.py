# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The loop over intervals of standing inputs, for one command and for a whole record."""

from .closed_loop import arriving_current, follow_stem, present_current, recall, sample
from .control_law import NEARLY
from .intervals import interval
from .memory import EP_PLAY
from .outputs import observe
from .position_controller import PositionController
from .solver import Workspace
from .state import STATES
from .supply import longest_hold
from .system import PositionerParameters, hold_inactive_states

OBSERVED = 15
"""Number of columns that `run` writes: the fields of `Outputs`."""


def controlled_interval(
    p: PositionerParameters, c: PositionController, time: float, length: float,
    set_point: float, pinned, y, memory, active, count: int, tolerance: float, w: Workspace,
) -> float:
    """
    Take the positioner over `length` s with the set point standing at `set_point` m.

    The interval is divided where the controller samples. Return and the rest as in `interval`.
    """
    seen, passed = memory[EP_PLAY], 0.0
    while passed < length:
        sample(c, p.actuator.travel, set_point, memory)
        due, rest = recall(memory).due, length - passed
        part = rest if due >= rest - NEARLY * c.period else due
        since = c.period - due
        current = arriving_current(
            c, p.ep_converter.dead_time, since, since + part, memory)
        seen = interval(
            p, time + passed, part, current, pinned, y, memory, active, count, tolerance, w)
        follow_stem(c, y, part, memory)
        passed = length if part == rest else passed + part
    return seen


def parts_of(p: PositionerParameters, length: float, longest: float) -> int:
    """Return how many intervals `length` s makes, none over `longest` or what a ripple allows."""
    return max(1, int(length / min(longest, longest_hold(p.supply)) + 0.999))


def run(
    p: PositionerParameters, c: PositionController, times, commands, delayed, pinned, pins, y,
    memory, active, count: int, tolerance: float, longest: float, w: Workspace, out,
) -> None:
    """
    Simulate a record: row k of `out` is what is seen at times[k].

    `commands[k]` (a current, A) and `delayed[k]` (after the dead time) stand from times[k] to
    times[k + 1]; of rows with the same stamp the last one counts. With the controller `c` enabled
    a command is a set point, m, and `delayed` is of no account. The states in `pinned` follow
    their column of `pins` instead of the equations. Intervals longer than `longest` s, or than a
    ripple may be held, are divided.
    """
    seen = memory[EP_PLAY] if c.enabled else delayed[0]
    for k in range(len(times)):
        for s in pinned:
            y[s] = pins[k, s]
        hold_inactive_states(p, times[k], y, pinned)
        current = commands[k]
        if c.enabled:
            if k + 1 < len(times) and times[k + 1] > times[k]:
                sample(c, p.actuator.travel, commands[k], memory)
            current = present_current(c, p.actuator.travel, commands[k], memory)
        row = observe(p, times[k], current, seen, y, memory)
        for j in range(OBSERVED):
            out[k, j] = row[j]
        if k + 1 == len(times):
            break
        length = times[k + 1] - times[k]
        if length <= 0.0:
            continue
        parts = parts_of(p, length, longest)
        for part in range(parts):
            for s in pinned:
                share = (part + 0.5) / parts
                y[s] = pins[k, s] * (1.0 - share) + pins[k + 1, s] * share
            start = times[k] + part * length / parts
            if c.enabled:
                seen = controlled_interval(
                    p, c, start, length / parts, commands[k], pinned, y, memory, active, count,
                    tolerance, w)
            else:
                seen = interval(
                    p, start, length / parts, delayed[k], pinned, y, memory, active, count,
                    tolerance, w)


__all__ = ['OBSERVED', 'STATES', 'controlled_interval', 'interval', 'run']
