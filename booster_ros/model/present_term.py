# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a term without a name adds in the present state, from its table (see `discrepancy`)."""

from . import discrepancy as term
from .discrepancy import Discrepancy, behind_play, forgets, interpolate
from .state import BACK, CHAMBER, PAST, POSITION, SUPPLY, VELOCITY

# For each variable of a term: the state that it is, or whose change it is, -1 where there is none;
# and the unit in which its state `past` is of order one, 0 where it has no past.
STATE_OF_VARIABLE = (
    -1, -1, BACK, SUPPLY, CHAMBER, POSITION, VELOCITY, -1, -1, -1, CHAMBER, POSITION, -1)

PAST_UNIT = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1e-4, 1e5, 1e-2, 0.1)


def present(table: Discrepancy, time: float, current: float, y, force: float) -> float:
    """Return the present value, SI, of a term's variable, or of the one whose change that is."""
    if table.variable == term.TIME:
        return time
    if table.variable == term.BOOSTER_FORCE:
        return force
    state = STATE_OF_VARIABLE[table.variable]
    return current if state < 0 else y[state]


def settled_past(table: Discrepancy, current: float, y) -> float:
    """Return the state `past` of a term whose variable has long been what it is now."""
    if not forgets(table):
        return 0.0
    return present(table, 0.0, current, y, 0.0) / PAST_UNIT[table.variable]


def discrepancy_at(table: Discrepancy, time: float, current: float, y, force: float) -> float:
    """
    Return the tabulated term, in the unit of the component that it is in (see discrepancy).

    Callers ask first whether the term is in their component: handing the table over costs more
    than the question, and nearly always there is no term.
    """
    past = PAST_UNIT[table.variable] * y[PAST]
    if table.variable == term.FORCE_PLAY:
        return behind_play(table, past, force)
    return interpolate(table, present(table, time, current, y, force) - past)
