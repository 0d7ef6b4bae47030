# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Steps ahead, which reach beyond the interval: a state that stands needs no step for every row.

While a step ahead lasts, the state follows it. Where an input changes, the step is left at that
moment: results depend neither on what comes later nor on how rows are divided into portions.
"""

from .memory import PASSED, STEP_AHEAD
from .state import POSITION, STATES, VELOCITY
from .system import derivatives


def begin_ahead(p, time, current, direction, y, memory, step, stuck, w) -> None:
    """Keep the step of length `step` s from `y` to w.trial as the step ahead."""
    memory[STEP_AHEAD], memory[PASSED] = step, 0.0
    derivatives(p, time, current, direction, w.trial, w.stage_rates)
    for i in range(STATES):
        w.start[i] = y[i]
    if stuck:
        for state in (POSITION, VELOCITY):
            w.rates[state] = w.stage_rates[state] = 0.0


def covers(memory, length: float) -> bool:
    """Tell whether the step ahead goes on for more than `length` s from now."""
    return memory[PASSED] + length < memory[STEP_AHEAD] * (1.0 - 1e-9)


def go_along(y, memory, length: float, active, count: int, w) -> None:
    """
    Take `y` further by `length` s along the step ahead, which must cover that time.

    Within the step the state follows the cubic that has the step's states and rates at its ends.
    """
    step = memory[STEP_AHEAD]
    memory[PASSED] += length
    s = memory[PASSED] / step
    late = s * s * (3.0 - 2.0 * s)
    rising, falling = step * s * (1.0 - s) * (1.0 - s), step * s * s * (1.0 - s)
    for i in range(count):
        k = active[i]
        y[k] = (w.start[k] + late * (w.trial[k] - w.start[k])
                + rising * w.rates[k] - falling * w.stage_rates[k])


def finish(y, memory, active, count: int, w) -> float:
    """Take `y` and w.rates to the end of the step ahead; return the time passed, s."""
    rest = memory[STEP_AHEAD] - memory[PASSED]
    memory[STEP_AHEAD] = 0.0
    for i in range(count):
        y[active[i]] = w.trial[active[i]]
    for i in range(STATES):
        w.rates[i] = w.stage_rates[i]
    return rest
