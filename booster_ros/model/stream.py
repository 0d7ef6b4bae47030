# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Running the model over rows of time and current that come in portions."""

from collections.abc import Mapping
import math
from typing import Any

import numpy as np

from .actuator import balance_position, process_force
from .closed_loop import size_of_memory, start_controller
from .compiled import compiled_run
from .discrepancy import EP_CONVERTER, STEM
from .ep_converter import settled_back_pressure
from .holding import holding_current
from .kernel import OBSERVED, run
from .memory import CENTRED, Departure, start_current, start_memory
from .outputs import Outputs
from .rows import Rows, check_finite, check_positive, check_states, checked_rows
from .solver import Workspace, new_workspace
from .state import (
    BACK, CHAMBER, OUTLET, PAST, POSITION, PRESLIDING, PRESSURE_DROP, STATE_NAMES, STATES, SUPPLY,
    TEMPERATURE)
from .sticking import held_force
from .system import (
    PositionerParameters, discrepancy_at, hold_inactive_states, is_active, is_direct, plant_of,
    rest_in_play,
    settled_past, undrawn_supply)
from .undefined import UNDEFINED

LONGEST_INTERVAL = 0.02
"""Longest interval, s: longer ones between rows of a record are divided."""

LEAST_PART = 1e-3
"""Share of the longest interval: a current that arrives nearer to a row divides nothing."""

DEFAULT_TOLERANCE = 1.0
"""Factor on the solver's error tolerance."""


def settled_state(
    p: PositionerParameters, current: float, chamber_pressure: float,
    valve_position: float | None, time: float = 0.0, pressure_drop: float = 0.0,
) -> list[float]:
    """
    Return the state of a positioner whose E/P converter has settled at `current` (A).

    `chamber_pressure` is gauge, Pa; the stem (m) stands where the forces on it balance, friction
    aside, unless `valve_position` says where. `pressure_drop` is that over the process valve, Pa.
    """
    y = [0.0] * STATES
    y[SUPPLY] = undrawn_supply(p, time)
    y[CHAMBER] = chamber_pressure
    y[OUTLET] = chamber_pressure
    if is_direct(p):
        y[BACK] = chamber_pressure  # until it has been found
    y[TEMPERATURE] = p.supply.temperature
    y[PRESSURE_DROP] = pressure_drop
    pushed = process_force(p.actuator, pressure_drop)
    y[POSITION] = (
        balance_position(p.actuator, chamber_pressure, lambda position: pushed)
        if valve_position is None else valve_position)
    y[PAST] = settled_past(p.discrepancy, current, y)
    hold_inactive_states(p, time, y, ())
    extra = 0.0
    if p.discrepancy.location == EP_CONVERTER:
        extra = discrepancy_at(p.discrepancy, time, current, y, 0.0)
    y[BACK] = settled_back_pressure(p.ep_converter, current, y[SUPPLY], time, extra)
    if is_direct(p):
        y[CHAMBER] = y[OUTLET] = y[BACK]
        if valve_position is None:
            y[POSITION] = balance_position(p.actuator, y[CHAMBER], lambda position: pushed)
    if valve_position is None and p.discrepancy.location == STEM:
        _balance_with_term(p, time, current, y)
    rest_in_play(p, y)
    if is_active(p, PRESLIDING):
        y[PRESLIDING] = held_force(p, time, current, y)
    return y


def _balance_with_term(p: PositionerParameters, time: float, current: float, y) -> None:
    """Put the stem where the forces on it, a term included, balance and have done so for long."""

    def put(position: float) -> None:
        y[POSITION] = position
        y[PAST] = settled_past(p.discrepancy, current, y)

    pushed = process_force(p.actuator, y[PRESSURE_DROP])

    def extra(position: float) -> float:
        put(position)
        return pushed + discrepancy_at(p.discrepancy, time, current, y, 0.0)

    put(balance_position(p.actuator, y[CHAMBER], extra))


def active_states(p: PositionerParameters, pinned: tuple[int, ...] = ()) -> list[int]:
    """Return the states to integrate under these parameters, in rising order."""
    # what has the pressure of a converter whose pressure is given follows no equation either
    given = (*pinned, CHAMBER) if is_direct(p) and BACK in pinned else pinned
    return [s for s in range(STATES) if is_active(p, s) and s not in given]


def _share_pressure(p: PositionerParameters, given: Mapping[str, float], y) -> None:
    """Give converter and chamber, between which nothing is, the one pressure that is given."""
    pushed = process_force(p.actuator, y[PRESSURE_DROP])
    for name in ('back_pressure', 'chamber_pressure'):
        if name in given:
            y[BACK] = y[CHAMBER] = given[name]
            if 'valve_position' not in given:
                y[POSITION] = balance_position(p.actuator, given[name], lambda position: pushed)
            return


def command_name(p: PositionerParameters) -> str:
    """Return what commands a positioner: the column of a record that holds it."""
    return 'set_point' if p.position_controller.enabled else 'control_current'


class Stream:
    """
    A simulation that takes its rows in portions and keeps only what the next portion needs.

    Time in s; a command is a control current in A, or a set point in m where the parameters enable
    the position controller, and stands from its row to the next. Compiled where numba is there and
    `compiled` says so, else plain Python, with the same result.
    """

    def __init__(
        self, parameters: PositionerParameters, time: float, command: float,
        initial: Mapping[str, float] | None = None, pinned: tuple[str, ...] = (),
        tolerance: float = DEFAULT_TOLERANCE, compiled: bool = True,
        departure: Departure = CENTRED, longest_interval: float = LONGEST_INTERVAL,
    ) -> None:
        """
        Start at `time`, settled at a current, the chamber vented.

        A controller starts as if it had long held the state at which the stream begins. `initial`
        may hold other values of the state (keys `STATE_NAMES`); what a state does not tell may be
        away from settled by a `departure`. The states `pinned` are given with each
        portion and follow no equation. Intervals between rows that are longer than
        `longest_interval` (s) are divided. ValueError where there is no state of a name, time,
        command or a state is not finite, tolerance or `longest_interval` is not positive.
        """
        given = dict(initial or {})
        check_states('initial', given)
        check_states('pinned', pinned)
        for name, value in {'time': time, command_name(parameters): command, **given}.items():
            check_finite(name, value)
        check_positive('tolerance', tolerance)
        check_positive('longest_interval', longest_interval)
        start = (given.get('chamber_pressure', 0.0), given.get('valve_position'), time,
                 given.get('pressure_drop', 0.0))
        is_loop = parameters.position_controller.enabled
        current = command
        if is_loop:
            current = holding_current(parameters, time, settled_state(parameters, 0.0, *start))
        y = settled_state(parameters, start_current(parameters, current, departure), *start)
        for name, value in given.items():
            y[STATE_NAMES.index(name)] = value
        if is_direct(parameters):
            _share_pressure(parameters, given, y)
        y[BACK] += departure.back_pressure
        rest_in_play(parameters, y)
        y[TEMPERATURE] += departure.temperature
        y[PAST] += departure.past
        hold_inactive_states(
            parameters, time, y, tuple(STATE_NAMES.index(name) for name in pinned))
        memory = [0.0] * size_of_memory(parameters)
        start_memory(parameters, current, y, 1e-3, memory, departure)
        if is_loop:
            start_controller(parameters, command, current, y, memory)
        self._parameters = plant_of(parameters)
        self._controller = parameters.position_controller
        # behind a controller no current is known beforehand: the loop itself delays it
        self._dead_time = 0.0 if is_loop else parameters.ep_converter.dead_time
        self._command_name = command_name(parameters)
        self._longest = float(longest_interval)
        self._tolerance = float(tolerance)  # for an int all would be compiled anew
        self._pinned = tuple(sorted(STATE_NAMES.index(name) for name in pinned))
        self._active = active_states(parameters, self._pinned)
        self._machine = compiled_run() if compiled else None
        self._state: Any = y if self._machine is None else np.array(y)
        self._memory: Any = memory if self._machine is None else np.array(memory)
        work = new_workspace()
        self._work = work if self._machine is None else Workspace(
            *(np.array(numbers) for numbers in work))  # type: ignore[arg-type]
        # the rows that still matter: as far back as the dead time, the last one at least
        self._time = np.empty(0)
        self._command = np.empty(0)
        self._pins = np.empty((0, STATES))

    @property
    def state(self) -> np.ndarray:
        """The state at the last row, in the order of `STATE_NAMES`."""
        return np.array(self._state)

    def advance(
        self, time: np.ndarray, command: np.ndarray,
        pinned: Mapping[str, np.ndarray] | None = None,
    ) -> dict[str, np.ndarray]:
        """
        Go on to the last of these rows, shape (n,) each; return what is seen at each of them.

        Of rows with the same stamp the last one counts. ValueError where shapes differ, a value is
        not finite, time falls, or other states are pinned than at the start.
        """
        return self.go_on(checked_rows(time, command, pinned, self._command_name))

    def go_on(self, rows: Rows) -> dict[str, np.ndarray]:
        """Do as `advance` with rows that have been checked."""
        t, command, held = rows
        places = {STATE_NAMES.index(name): series for name, series in held.items()}
        if set(places) != set(self._pinned):
            names = ', '.join(STATE_NAMES[place] for place in self._pinned) or 'none'
            raise ValueError(
                f'pinned: {", ".join(held) or "none"} given, but pinned from the start: {names}')
        before = len(self._time)
        if before and t[0] < self._time[-1]:
            raise ValueError(f'time must not fall from {self._time[-1]} to {t[0]} s')
        t = np.concatenate((self._time, t))
        command = np.concatenate((self._command, command))
        pins = np.zeros((len(t), STATES))
        pins[:before] = self._pins
        for place, series in places.items():
            pins[before:, place] = series
        first = max(before - 1, 0)
        moments = arrivals(t, command, self._dead_time, self._longest)
        moments = moments[moments > t[first]]
        if len(moments) > 0:
            at = np.searchsorted(t, moments)
            out = self._run(*with_rows(moments, at, t, command, pins), first)
            out = np.delete(out, at + np.arange(len(at)) - first, axis=0)
        else:
            out = self._run(t, command, pins, first)
        self._keep(t, command, pins)
        return dict(zip(Outputs._fields, out[before - first:].T))

    def _run(self, time: np.ndarray, command: np.ndarray, pins: np.ndarray, first: int
             ) -> np.ndarray:
        """Run from row `first` to the last; return what is seen at each of these."""
        delayed = delayed_current(time, command, self._dead_time)
        time, command, delayed, pins = time[first:], command[first:], delayed[first:], pins[first:]
        out = np.full((len(time), OBSERVED), np.nan)
        if self._machine is None:
            try:
                run(self._parameters, self._controller, time.tolist(), command.tolist(),
                    delayed.tolist(), self._pinned, pins, self._state, self._memory, self._active,
                    len(self._active), self._tolerance, self._longest, self._work, out)
            except UNDEFINED:  # the rows that are left have no solution
                self._state[CHAMBER] = math.nan
            return out
        self._machine(
            self._parameters, self._controller, time, command, delayed,
            np.array(self._pinned, dtype=np.int64), pins, self._state, self._memory,
            np.array(self._active, dtype=np.int64), len(self._active), self._tolerance,
            self._longest, self._work, out)
        return out

    def _keep(self, time: np.ndarray, command: np.ndarray, pins: np.ndarray) -> None:
        oldest = time[-1] - self._dead_time
        first = max(int(np.searchsorted(time, oldest, 'right')) - 2, 0)
        first = min(first, len(time) - 1)
        self._time = time[first:].copy()
        self._command = command[first:].copy()
        self._pins = pins[first:].copy()


def arrivals(
    time: np.ndarray, current: np.ndarray, dead_time: float, longest: float
) -> np.ndarray:
    """
    Return the moments, s, at which changes of the current arrive, one dead time (s) late.

    They rise, and each appears once. Only those between rows further apart than `longest` s
    count: between closer rows the mean current stands for them.
    """
    if dead_time <= 0.0:
        return np.empty(0)
    moments = np.unique(time[1:][np.diff(current) != 0.0] + dead_time)
    moments = moments[moments < time[-1]]
    after = np.searchsorted(time, moments)
    since, until = moments - time[after - 1], time[after] - moments
    far = np.minimum(since, until) > LEAST_PART * longest
    return moments[far & (since + until > longest)]


def with_rows(
    moments: np.ndarray, at: np.ndarray, time: np.ndarray, current: np.ndarray, pins: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return time, current and pinned states with rows at `moments` s, before the rows `at`."""
    share = (moments - time[at - 1]) / (time[at] - time[at - 1])
    between = pins[at - 1] + share[:, None] * (pins[at] - pins[at - 1])
    return (np.insert(time, at, moments), np.insert(current, at, current[at - 1]),
            np.insert(pins, at, between, axis=0))


def delayed_current(time: np.ndarray, current: np.ndarray, dead_time: float) -> np.ndarray:
    """
    Return, for each row's interval, the mean of the standing current one dead time (s) ago.

    The mean (not the value at one moment) makes the result continuous in the dead time. It is made
    of the levels that the interval has, one dead time ago, and of nothing before: so it does not
    depend on where a portion of a record begins, and is the level itself where there is but one.
    """
    if dead_time <= 0.0 or len(time) < 2:
        return current
    changes = np.concatenate(([0], np.flatnonzero(np.diff(current) != 0.0) + 1))
    since, level = time[changes], current[changes]
    begins, ends = time[:-1] - dead_time, time[1:] - dead_time
    first = np.maximum(np.searchsorted(since, begins, 'right') - 1, 0)
    last = np.maximum(np.searchsorted(since, ends, 'left') - 1, first)
    mean = level[last]
    several = np.flatnonzero((last > first) & (ends > begins))
    if len(several):
        first, last, begins, ends = (each[several] for each in (first, last, begins, ends))
        charge = level[first] * (since[first + 1] - begins) + level[last] * (ends - since[last])
        between = np.add.reduceat(
            np.append(level[:-1] * np.diff(since), 0.0), np.stack((first + 1, last), 1).ravel())
        charge += np.where(last > first + 1, between[::2], 0.0)
        mean[several] = charge / (ends - begins)
    stands = np.diff(time) <= 0.0
    mean[stands] = current[:-1][stands]
    return np.concatenate((mean, mean[-1:]))
