# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Running the model: step by step (`Plant`) or over a whole record (`simulate`)."""

from collections.abc import Mapping
from dataclasses import dataclass
import math

import numpy as np

from .intervals import interval
from .kernel import parts_of
from .memory import CENTRED, DIRECTION, MEMORIES, STANDING, Departure, start_memory
from .outputs import Outputs, observe, readings
from .rows import check_finite, checked_rows
from .solver import new_workspace
from .state import CHAMBER, PAST, PRESLIDING, PRESSURE_DROP, STATES
from .sticking import dry_friction, sliding_direction, sticks
from .stream import (
    DEFAULT_TOLERANCE, LONGEST_INTERVAL, Stream, active_states, command_name, settled_state)
from .system import (
    PositionerParameters, booster_force, hold_inactive_states, is_active, rest_in_play,
    settled_past)
from .undefined import UNDEFINED

DEFAULT_STEP = 1e-3
"""Interval of the stepping plant, s."""


class Plant:
    """
    The positioner as a thing in time: command it, let time pass, look at it.

    Plain Python and deterministic: the same calls give the same bits. `step` is the interval in s
    over which a command stands; the solver divides it where accuracy asks for it.
    """

    def __init__(self, parameters: PositionerParameters, step: float = DEFAULT_STEP) -> None:
        """Start vented at current 0. ValueError unless `step` is positive and finite."""
        if not (math.isfinite(step) and step > 0.0):
            raise ValueError(f'the integration step must be positive, got {step} s')
        self._step = step
        self._work = new_workspace()
        self._parameters = parameters
        self._drop = 0.0
        self.reset()

    @property
    def step(self) -> float:
        """Length of one step, s."""
        return self._step

    @property
    def parameters(self) -> PositionerParameters:
        """
        The physical parameters; setting them keeps pressures, position and velocity.

        Setting them also keeps what a term remembers, unless the new term has another location or
        variable, and the force of friction: a stem that is stuck stays where it is, one that moves
        slides on.
        """
        return self._parameters

    @parameters.setter
    def parameters(self, parameters: PositionerParameters) -> None:
        table, before = parameters.discrepancy, self._parameters.discrepancy
        if (table.location, table.variable) != (before.location, before.variable):
            self._y[PAST] = settled_past(table, self._seen, self._y)  # as if at rest for long
            rest_in_play(parameters, self._y)
        y, memory = self._y, self._memory
        slid = memory[DIRECTION]
        memory[STANDING] = math.nan  # a step ahead was for other parameters
        try:
            memory[DIRECTION] = sliding_direction(parameters, y)
            hold_inactive_states(parameters, self.time, y, ())
            if sticks(self._parameters) and is_active(parameters, PRESLIDING):
                y[PRESLIDING] = dry_friction(parameters, self.time, self._seen, slid, y)
        except UNDEFINED:
            y[CHAMBER] = math.nan
        self._parameters = parameters
        self._active = active_states(parameters)

    @property
    def time(self) -> float:
        """Simulated seconds since the reset."""
        return self._steps * self._step

    @property
    def pressure_drop(self) -> float:
        """The pressure drop over the process valve, Pa; a reset keeps it."""
        return self._drop

    @pressure_drop.setter
    def pressure_drop(self, pressure_drop: float) -> None:
        check_finite('pressure_drop', pressure_drop)
        if pressure_drop != self._drop:
            self._drop = self._y[PRESSURE_DROP] = pressure_drop
            self._memory[STANDING] = math.nan  # a step ahead was for another force

    def reset(
        self, chamber_pressure: float = 0.0, valve_position: float | None = None,
        control_current: float = 0.0,
    ) -> None:
        """
        Begin anew at a chamber pressure (gauge, Pa), a position (m) and a settled current (A).

        Without a position the stem stands where the forces on it balance.
        """
        p = self._parameters
        self._steps = 0
        self._current = control_current
        self._history = [control_current]
        self._seen = control_current
        self._memory = [0.0] * MEMORIES
        try:
            self._y = settled_state(
                p, control_current, chamber_pressure, valve_position, pressure_drop=self._drop)
            start_memory(p, control_current, self._y, self._step, self._memory)
        except UNDEFINED:
            self._y = [math.nan] * STATES
        self._active = active_states(p)

    def advance(self, command: float, steps: int) -> None:
        """
        Let `steps` × step seconds pass with the control current standing at `command` (A).

        ValueError where the current is not finite or `steps` is negative; nothing has changed then.
        """
        check_finite('control_current', command)
        if steps < 0:
            raise ValueError(f'steps must not be negative, got {steps}')
        self._current = command
        parts = parts_of(self._parameters, self._step, self._step)
        length = self._step / parts
        for _ in range(steps):
            delayed = self._delayed(command)
            for part in range(parts):
                if self.is_lost:
                    break
                try:
                    self._seen = interval(
                        self._parameters, self.time + part * length, length, delayed, (),
                        self._y, self._memory, self._active, len(self._active), DEFAULT_TOLERANCE,
                        self._work)
                except UNDEFINED:
                    self._y[CHAMBER] = math.nan
            self._steps += 1

    @property
    def is_lost(self) -> bool:
        """Whether the model has no solution from some moment on: then its chamber has no number."""
        return math.isnan(self._y[CHAMBER])

    def _delayed(self, current: float) -> float:
        """Return the mean over this step of the command one dead time ago."""
        dead_time = self._parameters.ep_converter.dead_time
        history = self._history
        if dead_time <= 0.0:
            history[:] = [current]
            return current
        whole, part = divmod(dead_time / self._step, 1.0)
        history.append(current)
        del history[:max(len(history) - int(whole) - 2, 0)]
        late = history[max(len(history) - 1 - int(whole), 0)]
        later = history[max(len(history) - 2 - int(whole), 0)]
        return (1.0 - part) * late + part * later

    def outputs(self) -> Outputs:
        """Return what can be seen now, NaN where the model has no solution."""
        try:
            return observe(
                self._parameters, self.time, self._current, self._seen, self._y, self._memory)
        except UNDEFINED:
            return Outputs(*[math.nan] * len(Outputs._fields))

    def readings(self) -> tuple[float, float]:
        """Return what the sensors read now: pressure, Pa gauge, and position, m; NaN if lost."""
        p, time, y = self._parameters, self.time, self._y
        if self.is_lost:  # sensors that lag still have a number
            return math.nan, math.nan
        try:
            force = booster_force(p, time, self._seen, y)
            return readings(p, time, self._seen, y, self._memory, force)
        except UNDEFINED:
            return math.nan, math.nan


@dataclass(frozen=True)
class Simulation:
    """The outcome of `simulate`: `columns[name]` over time, names and units as `Outputs`."""

    columns: dict[str, np.ndarray]
    final_state: np.ndarray

    def __getitem__(self, name: str) -> np.ndarray:
        """Return one column."""
        return self.columns[name]


def simulate(
    parameters: PositionerParameters,
    time: np.ndarray,
    command: np.ndarray,
    initial: Mapping[str, float] | None = None,
    pinned: Mapping[str, np.ndarray] | None = None,
    tolerance: float = DEFAULT_TOLERANCE,
    compiled: bool = True,
    departure: Departure = CENTRED,
    longest_interval: float = LONGEST_INTERVAL,
) -> Simulation:
    """
    Simulate over the rows of a record, shape (n,) each: time in s, control current in A.

    Where the parameters enable the position controller, the command is a set point in m instead.
    A command stands from its row to the next. `initial` may hold values of the state at the first
    row (keys `STATE_NAMES`); what it lacks starts settled, with the chamber vented.
    `pinned` channels (same keys) follow the given series instead of the equations. `departure` is
    how far from settled the model starts. Intervals between rows that are longer than
    `longest_interval` (s) are divided. ValueError where shapes or times do not fit, there is no
    state of a name, a value is not finite, tolerance or `longest_interval` is not positive.
    """
    rows = checked_rows(time, command, pinned, command_name(parameters))
    start = {**(initial or {}), **{name: float(series[0]) for name, series in rows.pinned.items()}}
    stream = Stream(
        parameters, float(rows.time[0]), float(rows.command[0]), start, tuple(rows.pinned),
        tolerance, compiled, departure, longest_interval)
    columns = stream.go_on(rows)
    return Simulation(columns, stream.state)


__all__ = ['Plant', 'Simulation', 'active_states', 'settled_state', 'simulate']
