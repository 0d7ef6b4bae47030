# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The faults of a positioner: its timetable, the services that add and clear, what is told."""

from collections.abc import Callable, Mapping
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rcl_interfaces.srv import SetParametersAtomically
from rclpy.node import Node
from rclpy.parameter import parameter_value_to_python
from std_msgs.msg import Header
from std_srvs.srv import Trigger

from ..faults.acting import with_faults
from ..faults.injection import AT_ONCE, Injection, injection
from ..faults.kinds import POSITION, PRESSURE
from ..faults.schedule import Running, Schedule
from ..faults.sensing import Imperfection, Sensor
from ..faults.timetable import read_timetable, read_timetable_file
from ..model.parameters import ParameterError
from ..model.simulation import Plant
from ..model.system import PositionerParameters
from ..parameters.schema import FaultPlan, NodeSettings
from .node_time import NodeTime
from .outputs import stamp_message
from .ready import LATCHED
from .tick_clock import NANOSECONDS, TickClock

_PARAMETERS = 'parameters.'


class Faults:
    """
    Switches the faults of a plant on and off before each tick, and falsifies its readings.

    `changed` is called where another fault is on than before, or none.
    """

    def __init__(
        self, node: Node, plant: Plant, ticks: TickClock, time: NodeTime, settings: NodeSettings,
        changed: Callable[[], None],
    ) -> None:
        """Offer the services; ParameterError where the timetable cannot be read."""
        self._node = node
        self._plant = plant
        self._ticks = ticks
        self._time = time
        self._changed = changed
        self._base = plant.parameters
        self._told: list[tuple[int, bool, bool]] = []
        self._acting: tuple[tuple[Injection, float], ...] = ()
        self._publisher = node.create_publisher(DiagnosticArray, '~/faults', LATCHED)
        node.create_service(SetParametersAtomically, '~/inject', self._on_inject)
        node.create_service(Trigger, '~/clear', self._on_clear)
        self._settings = settings
        self._plan = planned(settings.faults)
        self._publish()

    def follow(self, base: PositionerParameters, settings: NodeSettings) -> None:
        """Follow these parameters from now on; another timetable replaces all faults at once."""
        before, self._settings = self._settings, settings
        self._base = base
        if settings.faults != before.faults:
            self._plan = planned(settings.faults)
            self._schedule = Schedule(self._plan)
        if settings.measurement.seed != before.measurement.seed:
            self._new_sensors()
        self._act()
        self._tell()

    def restart(self) -> None:
        """Begin the timetable anew, with all other faults off."""
        self._schedule = Schedule(self._plan)
        self._acting = ()
        self._plant.parameters = self._base
        self._new_sensors()
        self._tell()

    def before_tick(self) -> None:
        """Go on to the tick that begins now."""
        self._schedule.advance(
            self._ticks.simulated / NANOSECONDS, self._ticks.ticks, self._plant.outputs)
        self._act()
        self._tell()

    def read(self, ideal: tuple[float, float]) -> tuple[float, float]:
        """Return the readings, Pa gauge and m, for the model's: once for each sample."""
        pressure, position = ideal
        acting, given = self._acting, self._settings.measurement
        return (
            self._pressure.read(
                pressure, Imperfection(given.pressure_noise, given.pressure_resolution),
                [one for one in acting if one[0].fault.sensor == PRESSURE]),
            self._position.read(
                position, Imperfection(given.position_noise, given.position_resolution),
                [one for one in acting if one[0].fault.sensor == POSITION]))

    def inject(self, fields: Mapping[str, Any]) -> Injection:
        """
        Add a fault, see `faults.injection`; ParameterError where that cannot be.

        Without a moment to begin it is on from the next tick on. Strength 0 takes it away.
        """
        made = injection(fields)
        if made.begin == AT_ONCE and made.strength == 0.0:
            self._schedule.remove(made.name)
            return made
        others = [(one.injection, 1.0) for one in self._schedule.on
                  if one.injection.name != made.name]
        with_faults(self._base, [*others, (made, 1.0)])  # it has to fit those that are on
        self._schedule.add(made)
        return made

    def clear(self) -> list[str]:
        """Switch all faults off, those to come too; return the names of those that were on."""
        names = self.on
        self._schedule = Schedule()
        self._act()
        self._tell()
        return names

    @property
    def on(self) -> list[str]:
        """The names of the faults that are on."""
        return [one.injection.name for one in self._schedule.on]

    @property
    def shares(self) -> dict[str, float]:
        """What is on of each fault, as a share of its full strength."""
        return {one.injection.name: one.share for one in self._schedule.on}

    @property
    def waiting(self) -> int:
        """How many faults are still to come."""
        return self._schedule.waiting

    def _new_sensors(self) -> None:
        seed = self._settings.measurement.seed
        self._pressure, self._position = Sensor(PRESSURE, seed), Sensor(POSITION, seed)

    def _act(self) -> None:
        """Give the plant the parameters that the faults make of those in force."""
        acting = tuple((one.injection, one.share) for one in self._schedule.on)
        try:
            parameters = with_faults(self._base, acting)
        except ParameterError as error:
            last = acting[-1][0].name
            self._schedule.remove(last)
            self._node.get_logger().error(f'the fault {last} is taken away: {error}')
            self._act()
            return
        self._acting = acting
        if parameters != self._plant.parameters:
            self._plant.parameters = parameters

    def _tell(self) -> None:
        """Publish what is on, and call `changed`, where that is not what was told last."""
        state = [(id(one.injection), one.ended is None, one.share >= 1.0)
                 for one in self._schedule.on]
        if state != self._told:
            self._told = state
            self._publish()
            self._changed()

    def _publish(self) -> None:
        moment = self._ticks.next_due - self._ticks.period + self._time.stamp_offset()
        on = self._schedule.on if self._told else []
        self._publisher.publish(DiagnosticArray(
            header=Header(stamp=stamp_message(max(moment, 0)), frame_id=self._node.get_name()),
            status=[_status(one) for one in on]))

    # Services

    def _on_inject(
        self, request: SetParametersAtomically.Request,
        response: SetParametersAtomically.Response,
    ) -> SetParametersAtomically.Response:
        fields: dict[str, Any] = {}
        for parameter in request.parameters:
            value = parameter_value_to_python(parameter.value)
            if parameter.name.startswith(_PARAMETERS):
                fields.setdefault('parameters', {})[
                    parameter.name.removeprefix(_PARAMETERS)] = value
            else:
                fields[parameter.name] = value
        try:
            made = self.inject(fields)
        except ParameterError as error:
            response.result.successful = False
            response.result.reason = str(error)
            return response
        response.result.successful = True
        response.result.reason = f'{made.name}, strength {made.strength:g}'
        return response

    def _on_clear(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        names = self.clear()
        response.success = True
        response.message = f'cleared: {", ".join(names)}' if names else 'no fault was on'
        return response


def planned(given: FaultPlan) -> list[Injection]:
    """Return the injections of the timetables, of the text first; ParameterError for bad ones."""
    found = read_timetable(given.timetable, 'faults.timetable')
    return found + (read_timetable_file(given.file) if given.file else [])


def _status(one: Running) -> DiagnosticStatus:
    given = one.injection
    began = 0.0 if one.began is None else one.began
    course = 'going' if one.ended is not None else 'on' if one.share >= 1.0 else 'growing'
    values = {'strength': repr(given.strength), 'on since [s]': repr(began)}
    values |= {name: repr(value) for name, value in given.parameters.items()}
    if given.size is not None:
        values['size'] = repr(given.size)
    return DiagnosticStatus(
        level=DiagnosticStatus.WARN, name=given.name, message=course,
        values=[KeyValue(key=key, value=value) for key, value in values.items()])
