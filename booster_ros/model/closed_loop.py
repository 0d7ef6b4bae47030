# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The loop closed: the controller's part of the memory, and the current that it sends.

The memory of a positioner with a controller goes on, from `CONTROLLER` on, with the fields of
`ControllerState`, and from `HISTORY` on with current, slope and width of the samples before the
last one, newest first, as far back as the dead time asks for.
"""

import math

from .control_law import at_rest, is_due, linkage_followed, mean_current, sampled
from .memory import MEMORIES
from .position_controller import ControllerState, PositionController
from .state import POSITION
from .system import PositionerParameters

CONTROLLER = MEMORIES
HISTORY = CONTROLLER + len(ControllerState._fields)
PULSE = 3
"""Numbers that tell what the current does from one sample to the next: itself, slope, width."""


def size_of_memory(p: PositionerParameters) -> int:
    """Return how many numbers a positioner with these parameters remembers."""
    c = p.position_controller
    if not c.enabled:
        return MEMORIES
    samples = math.ceil(p.ep_converter.dead_time / c.period) + 1
    return HISTORY + PULSE * (samples if p.ep_converter.dead_time > 0.0 else 0)


def recall(memory) -> ControllerState:
    """Return the state of the controller."""
    k = CONTROLLER
    return ControllerState(
        memory[k], memory[k + 1], memory[k + 2], memory[k + 3], memory[k + 4], memory[k + 5],
        memory[k + 6], memory[k + 7], memory[k + 8], memory[k + 9], memory[k + 10],
        memory[k + 11], memory[k + 12])


def remember(memory, state: ControllerState) -> None:
    """Keep the state of the controller."""
    for k in range(len(state)):
        memory[CONTROLLER + k] = state[k]


def start_controller(
    p: PositionerParameters, set_point: float, current: float, y, memory
) -> None:
    """Fill the memory of a controller that has long held the stem in state `y` by a current, A."""
    remember(memory, at_rest(
        p.position_controller, p.actuator.travel, set_point, y[POSITION], current))
    forget(memory, current)


def forget(memory, current: float) -> None:
    """Fill the history as if the current (A) had stood for long."""
    for k in range(HISTORY, len(memory), PULSE):
        memory[k], memory[k + 1], memory[k + 2] = current, 0.0, 0.0


def sample(c: PositionController, travel: float, set_point: float, memory) -> None:
    """Take a sample at which the set point is `set_point` (m), if it is time for one."""
    before = recall(memory)
    if not is_due(c, before):
        return
    for k in range(len(memory) - 1, HISTORY + PULSE - 1, -1):
        memory[k] = memory[k - PULSE]
    if len(memory) > HISTORY:
        memory[HISTORY], memory[HISTORY + 1], memory[HISTORY + 2] = (
            before.current, before.slope, before.width)
    remember(memory, sampled(c, travel, before, set_point))


def present_current(c: PositionController, travel: float, set_point: float, memory) -> float:
    """Return the current, A, from this moment on, without taking the sample that may be due."""
    state = recall(memory)
    if is_due(c, state):
        state = sampled(c, travel, state, set_point)
    since = c.period - state.due
    return mean_current(state.current, state.slope, state.width, since, since)


def arriving_current(
    c: PositionController, dead_time: float, begin: float, end: float, memory
) -> float:
    """
    Return the mean current, A, that arrives from `begin` to `end` (s since the last sample).

    It was sent one dead time (s) before; `end` is after `begin`.
    """
    state = recall(memory)
    if dead_time <= 0.0:
        return mean_current(state.current, state.slope, state.width, begin, end)
    left, right = begin - dead_time, end - dead_time
    charge = 0.0
    if right > 0.0:
        first = max(left, 0.0)
        charge = (right - first) * mean_current(
            state.current, state.slope, state.width, first, right)
    oldest = (len(memory) - HISTORY) // PULSE - 1
    for back in range(max(int(-right / c.period), 0), min(int(-left / c.period), oldest) + 1):
        sent = -(back + 1) * c.period
        first, last = max(left - sent, 0.0), min(right - sent, c.period)
        if last > first:
            k = HISTORY + PULSE * back
            charge += (last - first) * mean_current(
                memory[k], memory[k + 1], memory[k + 2], first, last)
    return charge / (end - begin)


def follow_stem(c: PositionController, y, step: float, memory) -> None:
    """Let what the controller sees of the stem follow it over `step` s; `y` is the state then."""
    remember(memory, linkage_followed(c, recall(memory), y[POSITION], step))
