# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The course of the variable that a term without a name follows, over a run or a record."""

from collections.abc import Mapping

import numpy as np

from . import discrepancy as term
from .booster import diaphragm_force
from .discrepancy import past_at_rest, place_in_play
from .ep_converter import play, settled_back_pressure
from .sensors import lagged
from .stream import delayed_current
from .system import PAST_UNIT, PositionerParameters

Array = np.ndarray


def followed(p: PositionerParameters, time: Array, columns: Mapping[str, Array], past: float = 0.0
             ) -> Array:
    """
    Return the variable of the term in these parameters over time (s), shape (n,).

    `columns` are channels of a run or a record. For a change, they must include the variable that
    changes; for a play of the booster's force, all pressures that make up that force; for the error
    of the back pressure, that pressure and all that it follows. `past` is that of the start's
    `Departure`. A change of the current is that of the current as given, which a dead time or a
    hysteresis hides from the model for a while; the error is that of the current behind these.
    """
    table = p.discrepancy
    if table.variable == term.BACK_PRESSURE_ERROR:
        return _errors(p, time, columns)
    if term.has_play(table):
        return _places_in_play(p, columns, past * PAST_UNIT[term.FORCE_PLAY])
    if table.variable not in term.CHANGE_OF:
        return columns[term.VARIABLES[table.variable]]
    now = columns[term.VARIABLES[term.CHANGE_OF[table.variable]]]
    remembered = np.empty(len(now))
    remembered[0] = now[0] + past * PAST_UNIT[table.variable]
    stands = table.variable == term.CURRENT_CHANGE  # a command stands until the next
    for k in range(1, len(now)):
        step, end = time[k] - time[k - 1], now[k - 1] if stands else now[k]
        remembered[k] = remembered[k - 1] if step <= 0.0 else lagged(
            remembered[k - 1], now[k - 1], end, table.memory, step)
    return now - remembered


def _errors(p: PositionerParameters, time: Array, columns: Mapping[str, Array]) -> Array:
    """Return how far the back pressure still has to go row by row, Pa, shape (n,)."""
    ep, errors = p.ep_converter, np.empty(len(time))
    rows = np.column_stack([
        time, delayed_current(time, columns['control_current'], ep.dead_time),
        columns['supply_pressure'], columns['back_pressure']])
    seen = float(rows[0, 1])
    for k, (now, current, supply, back) in enumerate(rows.tolist()):
        seen = play(seen, current, ep.hysteresis)
        errors[k] = settled_back_pressure(ep, seen, supply, now, 0.0) - back
    return errors


def _places_in_play(p: PositionerParameters, columns: Mapping[str, Array], past: float) -> Array:
    """Return where in its play the booster's force stands row by row, -1 to 1, shape (n,)."""
    pressures = np.column_stack(
        [columns[name] for name in ('back_pressure', 'outlet_pressure', 'supply_pressure')])
    places = np.empty(len(pressures))
    for k, (back, outlet, supply) in enumerate(pressures.tolist()):
        force = diaphragm_force(p.booster, back, outlet, supply)
        if k == 0:
            past += past_at_rest(p.discrepancy, force)
        places[k] = place_in_play(p.discrepancy, past, force)
        past = force - p.discrepancy.reach * places[k]
    return np.clip(places, -1.0, 1.0)  # but for rounding they are
