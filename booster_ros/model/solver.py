# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The solver: error-controlled steps, and dry friction that sticks.

One call of `advance` takes the state over one interval in which all inputs stand still:

1. try a step; where its estimated error exceeds the tolerance, shorten it and try again;
2. a sliding stem whose velocity would change sign is stopped at the crossing, exactly at zero,
   and stays there while the force on it is below the break-away friction;
3. a stuck stem whose force passes the break-away friction starts to slide at that moment.

Steps are linearly implicit (`rodas3`), except where a stem slips: within milliseconds nothing is
stiff any more, and accuracy asks for short steps, which an explicit method of higher order
(`dormand_prince`) does better. Slips in a packing that yields are taken in such steps as well.

The functions work on lists (plain Python) and on numpy arrays (compiled) alike.
"""

import math

from .actuator import is_in_a_stop, presliding_time
from .ahead import begin_ahead, covers, finish, go_along
from .dormand_prince import ORDER as EXPLICIT_ORDER, contraction, explicit_step
from .memory import DIRECTION, STEP_AHEAD, STIFFNESS, TRIAL_STEP
from .rodas3 import ORDER as IMPLICIT_ORDER, fill_jacobian, implicit_step
from .state import CHAMBER, POSITION, PRESLIDING, STATES, VELOCITY
from .sticking import breakaway_excess, friction_time_scale, slip_direction, sticks
from .system import PositionerParameters, derivatives
from .workspace import Workspace, new_workspace

FINEST_DIVISION = 4000.0
"""No step is shorter than the interval divided by this, whatever the error estimate says."""

FINEST_STEP = 1e-8
"""
Shortest step, s, for the rest of an interval in which a step as short as `FINEST_DIVISION` allows
is lost: a light stem whose friction fades runs away within a microsecond.
"""

AHEAD_SHARE = 0.1
"""Share of the tolerance allowed to a step over several rows: its error is seen at all of them."""

LOST = 1e6
"""Factor on the tolerance: a shortest step whose error is beyond even that is lost."""

MOST_STEPS = 4000
MOST_INACCURATE = 500
"""
Most steps within an interval, and most of them whose error is beyond the tolerance though they are
as short as can be: what takes more is not followed, and would hold up whoever waits for it.
"""

SHORTEST_EVENT = 1e-7
"""Shortest step to where sticking or sliding ends, s: time must pass."""

FIRST_SLIP_STEP = 3e-4
"""Trial step after break-away, s."""

LONGEST_EXPLICIT = 2e-3
"""A sliding stem's steps up to this length, s, are explicit unless they turn out to be stiff."""

YIELDING_EXPLICIT = 6.0
"""
Where the packing yields, trial steps up to this many times `presliding_time` are explicit as well:
those of slips and of what follows them, not those of a creeping stem.
"""

STIFF = 2.5
STIFF_STEPS = 3
"""Contraction beyond which an explicit step is stiff; how many such steps prove a slide stiff."""

EVENT_FORCE = 1e-3
EVENT_TRIALS = 8
"""Force, N, beyond break-away at which the end of sticking is looked for; most trials for that."""

ROUNDING = 1e-6
"""Force, N, beyond break-away up to which a stem still rests, as one pressed to a stop does."""


def _try_step(p, time, current, direction, y, h, explicit, active, count, w) -> float:
    if explicit:
        return explicit_step(p, time, current, direction, y, h, active, count, w)
    return implicit_step(p, time, current, direction, y, h, active, count, w)


def _step_factor(error: float, explicit: bool) -> float:
    """Return the factor on the step that brings its error just within the tolerance."""
    order = EXPLICIT_ORDER if explicit else IMPLICIT_ORDER
    return min(max(0.9 * max(error, 1e-9) ** (-1.0 / order), 0.2), 5.0)


def _step_to_breakaway(p, time, current, y, step, active, count, w) -> float:
    """
    Shorten the step so that a stuck stem is just about to slide; the result is in w.trial.

    The search is by false position, as the force runs nearly straight over a step. It ends so far
    beyond break-away that a stem which is found there does slide.
    """
    early, before = 0.0, breakaway_excess(p, time, current, y) - EVENT_FORCE
    late, after = step, breakaway_excess(p, time, current, w.trial) - EVENT_FORCE
    middle = late
    for _ in range(EVENT_TRIALS if before < 0.0 < after else 0):
        middle = early + (late - early) * before / (before - after)
        implicit_step(p, time, current, 0.0, y, middle, active, count, w)
        excess = breakaway_excess(p, time, current, w.trial) - EVENT_FORCE
        if abs(excess) < 0.9 * EVENT_FORCE:
            break
        if excess > 0.0:
            late, after = middle, excess
        else:
            early, before = middle, excess
    if before >= 0.0 or middle < SHORTEST_EVENT:
        middle = SHORTEST_EVENT
        implicit_step(p, time, current, 0.0, y, middle, active, count, w)
    return middle


def _zero_crossing(start: float, slope: float, end: float, end_slope: float) -> float:
    """
    Return where in 0..1 the cubic with these values and slopes at 0 and 1 crosses zero.

    `start` and `end` have different signs. Bisection: twenty halvings are finer than the cubic is.
    """
    low, high = 0.0, 1.0
    for _ in range(20):
        s = 0.5 * (low + high)
        value = ((1.0 - s) * (1.0 - s) * ((1.0 + 2.0 * s) * start + s * slope)
                 + s * s * ((3.0 - 2.0 * s) * end - (1.0 - s) * end_slope))
        if value * start > 0.0:
            low = s
        else:
            high = s
    return high


def _step_to_rest(p, time, now, current, direction, y, step, explicit, active, count, w) -> float:
    """
    Shorten the step so that it ends where a sliding stem stops; the result is in w.trial.

    A stem that would not even get going is stuck over this step, though barely. `time` is that of
    an implicit step, `now` that of the step that was tried; `count` includes the stem's states.
    """
    if y[VELOCITY] * direction <= 0.0:
        fill_jacobian(p, time, current, 0.0, y, active, count - 2, w)
        implicit_step(p, time, current, 0.0, y, step, active, count - 2, w)
        return step
    derivatives(p, now, current, direction, w.trial, w.stage_rates)
    share = _zero_crossing(
        y[VELOCITY], step * w.rates[VELOCITY], w.trial[VELOCITY], step * w.stage_rates[VELOCITY])
    step = max(share * step, min(step, SHORTEST_EVENT))
    _try_step(p, now, current, direction, y, step, explicit, active, count, w)
    return step


def _begin_slip(p, time, current, y, memory) -> None:
    """
    Remember where to a stuck stem begins to slide, and that it starts in short steps.

    One that a stop has yielded to creeps as slowly as the force on it changes. In explicit steps
    its velocity would be noise of either sign, and it would stop and go thousands of times.
    """
    memory[DIRECTION] = slip_direction(p, time, current, y)
    memory[TRIAL_STEP] = FIRST_SLIP_STEP
    memory[STIFFNESS] = STIFF_STEPS if is_in_a_stop(p.actuator, y[POSITION]) else 0.0


def _is_explicit(memory, step: float, direction: float, fast: float) -> bool:
    """
    Tell whether a step of this length is to be explicit: that of a slip not proved to be stiff.

    `fast` is the longest trial step, s, of a slip in a packing that yields (0: it does not); a
    longer one ends the slip.
    """
    short = memory[TRIAL_STEP] <= fast or (direction != 0.0 and step <= LONGEST_EXPLICIT)
    if fast > 0.0 and not short:
        memory[STIFFNESS] = 0.0
    return short and memory[STIFFNESS] < STIFF_STEPS


def _allowed(tolerance: float, step: float, left: float) -> float:
    """Return the error that a step may have of which `left` s are within the interval."""
    return tolerance * AHEAD_SHARE if step > left else tolerance


def _propose(memory, step: float, smallest: float, cut: bool) -> None:
    """
    Remember the length of the next trial step, s.

    A step `cut` short by an event or by the end of the interval says nothing against long ones.
    """
    memory[TRIAL_STEP] = max(step, memory[TRIAL_STEP] if cut else smallest)


def _take(y, rates_known: bool, w) -> None:
    """Take `y` to the end of the step, and w.rates as well where the step knows them there."""
    for i in range(STATES):
        y[i] = w.trial[i]
    if rates_known:
        for i in range(STATES):
            w.rates[i] = w.stage_rates[i]


def _still_left(left: float, passed: float, length: float) -> float:
    """Return what is left of an interval of `length` s: what rounding leaves is nothing."""
    return left - passed if left - passed > 1e-12 * length else 0.0


def advance(
    p: PositionerParameters, time: float, current: float, length: float, y, memory,
    active, count: int, tolerance: float, w: Workspace, longest_ahead: float = 0.0,
) -> None:
    """
    Take the state `y` over `length` s of standing inputs, in place.

    `time` (s), that of the interval's middle, is one of these inputs; explicit steps, those of a
    stem that slips, do follow the time.

    `active[:count]` are the states to integrate, in rising order; the others stand still.
    `tolerance` multiplies `TOLERANCE` (infinite: no step is shortened, however large its error).
    Steps of up to `longest_ahead` s may reach beyond the interval; `memory` and `w` hold what is
    left of one.
    """
    smallest = length / FINEST_DIVISION
    dry = sticks(p) and count > 0 and active[count - 1] == VELOCITY
    fast = 0.0
    if count > 0 and active[count - 1] == PRESLIDING:
        fast = min(LONGEST_EXPLICIT, YIELDING_EXPLICIT * presliding_time(p.actuator))
    left = length
    steps, inaccurate = 0, 0
    rates_known = False
    while left > 0.0:
        if memory[STEP_AHEAD] > 0.0:
            if covers(memory, left):
                go_along(y, memory, left, active, count, w)
                return
            left = _still_left(left, finish(y, memory, active, count, w), length)
            rates_known = True
            continue
        if dry and memory[DIRECTION] == 0.0 and breakaway_excess(p, time, current, y) > ROUNDING:
            _begin_slip(p, time, current, y, memory)
            rates_known = False
        direction = memory[DIRECTION] if dry else 0.0
        stuck = dry and direction == 0.0
        moving = count
        if stuck:
            y[VELOCITY] = 0.0
            moving = count - 2
        if not rates_known:
            derivatives(p, time, current, direction, y, w.rates)
        tried = min(memory[TRIAL_STEP], max(left, longest_ahead))
        if direction != 0.0:
            tried = min(tried, max(friction_time_scale(p, y, w.rates), smallest))
        explicit = _is_explicit(memory, tried, direction, fast)
        if not explicit:
            fill_jacobian(p, time, current, direction, y, active, moving, w)
        # the explicit method can follow the time (and is slower where the time stands)
        now = time - 0.5 * length + (length - left) if explicit else time
        step = tried
        error = _try_step(p, now, current, direction, y, step, explicit, active, moving, w)
        allowed = _allowed(tolerance, step, left)
        while not error <= allowed and step > smallest:
            step = max(step * min(_step_factor(error / allowed, explicit), 0.7), smallest)
            error = _try_step(p, now, current, direction, y, step, explicit, active, moving, w)
            allowed = _allowed(tolerance, step, left)
        steps += 1
        inaccurate += 0 if error <= allowed else 1
        lost = not error <= LOST * tolerance and not step > smallest
        if lost and smallest > FINEST_STEP:
            smallest = memory[TRIAL_STEP] = FINEST_STEP
            rates_known = True
            continue
        if lost or steps > MOST_STEPS or inaccurate > MOST_INACCURATE:
            y[CHAMBER] = math.nan  # nothing sensible can follow; do not creep on with tiny steps
            return
        if step > left and direction != 0.0 and w.trial[VELOCITY] * direction <= 0.0:
            step, allowed = left, tolerance  # a step ahead does not end a slide
            error = _try_step(p, now, current, direction, y, step, explicit, active, moving, w)
        whole = step == tried
        proposal = step * _step_factor(error / allowed, explicit)
        if explicit and contraction(active, moving, w) > STIFF:
            memory[STIFFNESS] += 1.0

        lands = direction != 0.0 and w.trial[VELOCITY] * direction <= 0.0
        if lands:
            step = _step_to_rest(
                p, time, now, current, direction, y, step, explicit, active, count, w)
        elif stuck and breakaway_excess(p, time, current, w.trial) > 0.0:
            step = _step_to_breakaway(p, time, current, y, step, active, moving, w)

        _propose(memory, proposal, smallest, whole and step < memory[TRIAL_STEP])
        if step > left:
            begin_ahead(p, time, current, direction, y, memory, step, stuck, w)
            continue
        rates_known = explicit and not lands
        _take(y, rates_known, w)
        if lands:
            y[VELOCITY] = 0.0
            memory[DIRECTION] = 0.0
            memory[TRIAL_STEP] = length  # what was fast has come to rest
        left = _still_left(left, step, length)


__all__ = ['Workspace', 'advance', 'new_workspace']
