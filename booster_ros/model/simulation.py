# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Running the model: step by step (`Plant`) or over a whole record (`simulate`)."""

from dataclasses import dataclass
import math
from typing import Mapping

import numpy as np

from .actuator import balance_position
from .compiled import compiled_run
from .kernel import OBSERVED, interval, run
from .solver import Workspace, new_workspace
from .system import (
    BACK, CHAMBER, MEMORIES, OUTLET, POSITION, STATE_NAMES, STATES, SUPPLY, TEMPERATURE, VELOCITY,
    Outputs, PositionerParameters, discrepancy_at, hold_inactive_states, is_active, observe,
    seen_current, start_memory)
from .discrepancy import EP_CONVERTER
from .ep_converter import settled_back_pressure
from .supply import set_pressure

DEFAULT_STEP = 1e-3
"""Interval of the stepping plant, s."""

LONGEST_INTERVAL = 0.02
"""Intervals between rows of a record are divided down to this, s."""

DEFAULT_TOLERANCE = 1.0
"""Multiplies the solver's error tolerance."""


def settled_state(
    p: PositionerParameters, current: float, chamber_pressure: float,
    valve_position: float | None, time: float = 0.0,
) -> list[float]:
    """
    Return the state of a positioner whose E/P converter has settled at `current` (A).

    `chamber_pressure` is gauge, Pa; the stem (m) stands where spring and pressure balance unless
    `valve_position` says where.
    """
    y = [0.0] * STATES
    y[SUPPLY] = set_pressure(p.supply, time)
    y[CHAMBER] = chamber_pressure
    y[OUTLET] = chamber_pressure
    y[TEMPERATURE] = p.supply.temperature
    y[POSITION] = (
        balance_position(p.actuator, chamber_pressure) if valve_position is None
        else valve_position)
    hold_inactive_states(p, time, y)
    extra = discrepancy_at(p, EP_CONVERTER, time, current, y, 0.0)
    y[BACK] = settled_back_pressure(p.ep_converter, current, y[SUPPLY], time, extra)
    return y


def active_states(p: PositionerParameters, pinned: tuple[int, ...] = ()) -> list[int]:
    """Return the states to integrate under these parameters, in rising order."""
    return [s for s in range(STATES) if is_active(p, s) and s not in pinned]


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
        self.reset()

    @property
    def step(self) -> float:
        """Length of one step, s."""
        return self._step

    @property
    def parameters(self) -> PositionerParameters:
        """The physical parameters; setting them keeps pressures, position and velocity."""
        return self._parameters

    @parameters.setter
    def parameters(self, parameters: PositionerParameters) -> None:
        self._parameters = parameters
        self._active = active_states(parameters)
        hold_inactive_states(parameters, self.time, self._y)

    @property
    def time(self) -> float:
        """Simulated seconds since the reset."""
        return self._steps * self._step

    def reset(
        self, chamber_pressure: float = 0.0, valve_position: float | None = None,
        control_current: float = 0.0,
    ) -> None:
        """
        Begin anew at a chamber pressure (gauge, Pa), a position (m) and a settled current (A).

        Without a position the stem stands where the spring balances the pressure.
        """
        p = self._parameters
        self._steps = 0
        self._current = control_current
        self._history = [control_current]
        self._seen = control_current
        self._y = settled_state(p, control_current, chamber_pressure, valve_position)
        self._memory = [0.0] * MEMORIES
        start_memory(p, control_current, self._y, self._step, self._memory)
        self._active = active_states(p)

    def advance(self, control_current: float, steps: int) -> None:
        """Let `steps` × step seconds pass with the command standing at `control_current` (A)."""
        self._current = control_current
        for _ in range(steps):
            self._seen = interval(
                self._parameters, self.time, self._step, self._delayed(control_current), self._y,
                self._memory, self._active, len(self._active), DEFAULT_TOLERANCE, self._work)
            self._steps += 1

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
        """Return what can be seen now."""
        return observe(
            self._parameters, self.time, self._current, self._seen, self._y, self._memory)


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
    control_current: np.ndarray,
    initial: Mapping[str, float] | None = None,
    pinned: Mapping[str, np.ndarray] | None = None,
    tolerance: float = DEFAULT_TOLERANCE,
    compiled: bool = True,
) -> Simulation:
    """
    Simulate over the rows of a record, shape (n,) each: time in s, control current in A.

    A current stands from its row to the next. `initial` may hold values of the state at the first
    row (keys `STATE_NAMES`, else settled, chamber vented); `pinned` channels (same keys) follow
    the given series instead of the equations. ValueError where shapes or times do not fit.
    """
    t = np.ascontiguousarray(time, dtype=float)
    current = np.ascontiguousarray(control_current, dtype=float)
    if t.ndim != 1 or t.shape != current.shape or len(t) == 0:
        raise ValueError('time and control_current must be equally long, one-dimensional, not empty')
    if len(t) > 1 and not np.all(np.diff(t) > 0.0):
        raise ValueError('time must rise from row to row')
    held = tuple(sorted(STATE_NAMES.index(name) for name in (pinned or {})))
    pins = np.zeros((len(t), STATES))
    for name, series in (pinned or {}).items():
        pins[:, STATE_NAMES.index(name)] = series
    start = dict(initial or {})
    start.update({STATE_NAMES[s]: float(pins[0, s]) for s in held})
    y = settled_state(
        parameters, float(current[0]), start.get('chamber_pressure', 0.0),
        start.get('valve_position'), float(t[0]))
    for name, value in start.items():
        y[STATE_NAMES.index(name)] = value
    memory = [0.0] * MEMORIES
    start_memory(parameters, float(current[0]), y, 1e-3, memory)
    active = active_states(parameters, held)
    out = np.empty((len(t), OBSERVED))
    delayed = delayed_current(t, current, parameters.ep_converter.dead_time)
    machine = compiled_run() if compiled else None
    if machine is not None:
        state = np.array(y)
        work = Workspace(*(np.zeros(STATES) for _ in range(7)),
                         *(np.zeros(STATES * STATES) for _ in range(2)))
        machine(parameters, t, current, delayed, np.array(held, dtype=np.int64), pins, state,
                np.array(memory), np.array(active, dtype=np.int64), len(active), tolerance,
                LONGEST_INTERVAL, work, out)
    else:
        run(parameters, t.tolist(), current.tolist(), delayed.tolist(), held, pins, y, memory,
            active, len(active), tolerance, LONGEST_INTERVAL, new_workspace(), out)
        state = np.array(y)
    return Simulation(dict(zip(Outputs._fields, out.T)), state)


def delayed_current(time: np.ndarray, current: np.ndarray, dead_time: float) -> np.ndarray:
    """
    Return, for each row's interval, the mean of the standing current one dead time (s) ago.

    The mean (not the value at one moment) makes the result continuous in the dead time.
    """
    if dead_time <= 0.0 or len(time) < 2:
        return current
    length = np.diff(time)
    charge = np.concatenate(([0.0], np.cumsum(current[:-1] * length)))

    def integral(moment: np.ndarray) -> np.ndarray:
        before = np.minimum(moment - time[0], 0.0) * current[0]
        return before + np.interp(moment, time, charge)

    mean = np.diff(integral(time - dead_time)) / length
    return np.concatenate((mean, mean[-1:]))


__all__ = ['BACK', 'CHAMBER', 'VELOCITY', 'Plant', 'Simulation', 'active_states', 'seen_current',
           'settled_state', 'simulate']
