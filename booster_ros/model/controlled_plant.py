# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The positioner that holds its position, as a thing in time: command it a set point."""

from .closed_loop import HISTORY, forget, recall, remember, size_of_memory, start_controller
from .control_law import mean_current
from .holding import holding_current
from .kernel import controlled_interval, parts_of
from .memory import start_memory
from .position_controller import CONTINUOUS, PositionController
from .rows import check_finite
from .simulation import Plant
from .state import POSITION
from .stream import DEFAULT_TOLERANCE, settled_state
from .system import PositionerParameters


class ControlledPlant(Plant):
    """A `Plant` with its position controller, which the parameters must enable."""

    @property
    def parameters(self) -> PositionerParameters:
        """
        The physical parameters; setting them keeps what a `Plant` keeps, and the integral part.

        Other periods and dead times are in force from the next sample, which comes at once.
        """
        return self._parameters

    @parameters.setter
    def parameters(self, parameters: PositionerParameters) -> None:
        if not parameters.position_controller.enabled:
            raise ValueError('position_controller.enabled must stay true')
        Plant.parameters.fset(self, parameters)  # type: ignore[attr-defined]
        size = size_of_memory(parameters)
        state = recall(self._memory)
        if size != len(self._memory) or state.due > parameters.position_controller.period:
            self._memory = self._memory[:HISTORY] + [0.0] * (size - HISTORY)
            remember(self._memory, state._replace(due=0.0))
            forget(self._memory, state.current)

    def reset(
        self, chamber_pressure: float = 0.0, valve_position: float | None = None,
        control_current: float | None = None,
    ) -> None:
        """
        Begin anew at a chamber pressure (gauge, Pa) and a position (m), which is the set point.

        Without a position the stem stands where the forces on it balance, without a control current
        (A) the one is in force that holds it there.
        """
        p = self._parameters
        super().reset(chamber_pressure, valve_position, 0.0)
        current = control_current
        if current is None:
            current = holding_current(p, 0.0, self._y)
        self._y = settled_state(
            p, current, chamber_pressure, valve_position, pressure_drop=self._drop)
        self._current = self._seen = current
        self._memory = [0.0] * size_of_memory(p)
        start_memory(p, current, self._y, self._step, self._memory)
        self.set_point = self._y[POSITION]
        start_controller(p, self.set_point, current, self._y, self._memory)

    def advance(self, command: float, steps: int) -> None:
        """
        Let `steps` × step seconds pass with the set point standing at `command` (m).

        ValueError where it is not finite or `steps` is negative; nothing has changed then.
        """
        check_finite('set_point', command)
        self.set_point = command
        self._follow(self._parameters.position_controller, steps)

    def vent(self, steps: int) -> None:
        """
        Let `steps` × step seconds pass without a set point: the controller sends no current.

        Its integral part begins anew when it does. ValueError where `steps` is negative.
        """
        self._follow(self._parameters.position_controller._replace(
            current_limits=(0.0, 0.0), integral_time=0.0, output=CONTINUOUS), steps)

    def _follow(self, c: PositionController, steps: int) -> None:
        if steps < 0:
            raise ValueError(f'steps must not be negative, got {steps}')
        parts = parts_of(self._parameters, self._step, self._step)
        length = self._step / parts
        for _ in range(steps):
            for part in range(parts):
                self._seen = controlled_interval(
                    self._parameters, c, self.time + part * length, length, self.set_point, (),
                    self._y, self._memory, self._active, len(self._active), DEFAULT_TOLERANCE,
                    self._work)
            self._steps += 1
        state = recall(self._memory)
        since = c.period - state.due
        self._current = mean_current(state.current, state.slope, state.width, since, since)


def make_plant(parameters: PositionerParameters, step: float) -> Plant:
    """Return the plant, with the controller where the parameters enable it; `step` in s."""
    return (ControlledPlant if parameters.position_controller.enabled else Plant)(parameters, step)
