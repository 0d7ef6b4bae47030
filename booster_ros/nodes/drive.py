# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What drives the plant of a positioner: a commanded current, or a set point and its controller."""

from collections.abc import Callable
from typing import Any, Protocol

from rclpy.node import Node

from ..model.controlled_plant import ControlledPlant
from ..model.position_controller import set_point_of
from ..model.simulation import Plant
from ..model.system import PositionerParameters
from ..parameters.schema import InitialState, Parameters
from .command_guard import CommandGuard, CommandRules, rules_of
from .commands import Commands
from .deviation import TravelDeviation
from .diagnostics import Report, travel_report
from .names import own_name
from .set_points import SetPoints

BELOW, BEYOND = 0.0125, 1.03125
"""
Least and largest set point as shares of the travel, below 0 and in all: 3.8 and 20.5 mA, between
which a loop current is no failure (NAMUR NE 43).
"""


class Drive(Protocol):
    """What a positioner does differently where something else is commanded."""

    def plant(self, step: float) -> Plant:
        """Return the plant; `step` in s."""

    def rules(self, parameters: Parameters) -> CommandRules:
        """Return what is done with commands under these parameters."""

    def commands(self, node: Node, rules: CommandRules, *others: Any) -> Commands:
        """Subscribe to the commands."""

    def reset(self, plant: Plant, state: InitialState) -> float:
        """Put the plant into a state, and return the command that is in force there."""

    def advance(self, plant: Plant, guard: CommandGuard, command: float, steps: int) -> None:
        """Let the plant go on by so many steps."""

    def set_point(self, plant: Plant) -> float | None:
        """Return the set point in force, m, where one is commanded."""

    def reports(self) -> list[Report]:
        """Return what else there is to report."""


class CurrentDrive:
    """The control current is commanded."""

    def __init__(self, physical: PositionerParameters) -> None:
        self._physical = physical

    def plant(self, step: float) -> Plant:
        """Return the plant; `step` in s."""
        return Plant(self._physical, step)

    def rules(self, parameters: Parameters) -> CommandRules:
        """Return what is done with currents under these parameters."""
        return rules_of(parameters.node)

    def commands(self, node: Node, rules: CommandRules, *others: Any) -> Commands:
        """Subscribe to the currents."""
        return Commands(node, rules, *others)

    def reset(self, plant: Plant, state: InitialState) -> float:
        """Put the plant into a state, and return the current, A, that is in force there."""
        plant.reset(state.chamber_pressure, state.valve_position, state.control_current)
        return state.control_current

    def advance(self, plant: Plant, guard: CommandGuard, command: float, steps: int) -> None:
        """Let the plant go on by so many steps at this current, A."""
        plant.advance(command, steps)

    def set_point(self, plant: Plant) -> float | None:
        """Return None: there is none."""
        return None

    def reports(self) -> list[Report]:
        """Return nothing: what is commanded is what happens."""
        return []


class SetPointDrive:
    """
    The set point is commanded, and the position controller makes the current of it.

    `changed` is called where the travel deviation has become better or worse.
    """

    def __init__(self, parameters: Parameters, changed: Callable[[], None]) -> None:
        self._physical = parameters.physical
        self._changed = changed
        self._deviation = TravelDeviation()
        self._joint = parameters.node.joint_name
        self._follow(parameters)

    def _follow(self, parameters: Parameters) -> None:
        self._physical = parameters.physical
        self._deviation.band = parameters.node.deviation_band * parameters.physical.actuator.travel
        self._deviation.delay = parameters.node.deviation_delay

    def plant(self, step: float) -> Plant:
        """Return the plant; `step` in s."""
        return ControlledPlant(self._physical, step)

    def rules(self, parameters: Parameters) -> CommandRules:
        """Return what is done with set points under these parameters."""
        self._follow(parameters)
        settings, travel = parameters.node, parameters.physical.actuator.travel
        return CommandRules(
            -BELOW * travel, BEYOND * travel, settings.invalid_current, settings.command_timeout,
            settings.stale_command, 'set_point', 'm', 'from the travel', float('nan'))

    def commands(self, node: Node, rules: CommandRules, *others: Any) -> Commands:
        """Subscribe to the set points."""
        throttle, changed, arrived = others
        return SetPoints(
            node, rules, throttle, changed, arrived, self._position_of,
            own_name(node, self._joint, 'valve_stem'))

    def _position_of(self, current: float) -> float:
        return set_point_of(
            self._physical.position_controller, current, self._physical.actuator.travel)

    def reset(self, plant: Plant, state: InitialState) -> float:
        """Put the plant into a state; the position there, m, is the set point in force."""
        assert isinstance(plant, ControlledPlant)
        plant.reset(state.chamber_pressure, state.valve_position)
        self._deviation.reset()
        return plant.set_point

    def advance(self, plant: Plant, guard: CommandGuard, command: float, steps: int) -> None:
        """Let the plant go on by so many steps at this set point, m, or vent where it is stale."""
        assert isinstance(plant, ControlledPlant)
        if guard.vents:
            plant.vent(steps)
        else:
            plant.advance(command, steps)
        position = plant.readings()[1]
        if self._deviation.note(plant.set_point - position, plant.time):
            self._changed()

    def set_point(self, plant: Plant) -> float | None:
        """Return the set point in force, m."""
        assert isinstance(plant, ControlledPlant)
        return plant.set_point

    def reports(self) -> list[Report]:
        """Return the report on the travel."""
        return [travel_report(self._deviation)]


def make_drive(parameters: Parameters, changed: Callable[[], None]) -> Drive:
    """Return the drive that the parameters ask for."""
    if parameters.physical.position_controller.enabled:
        return SetPointDrive(parameters, changed)
    return CurrentDrive(parameters.physical)
