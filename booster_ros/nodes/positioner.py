# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The node `positioner`: a simulated electro-pneumatic valve positioner.

Everything happens in one thread, between two ticks or in a tick: commands that arrive wait for the
next tick, parameters change between ticks. `docs/node.md` describes topics, services, time.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
import sys
from typing import Any

from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.context import Context
from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger

from ..parameters.schema import ALL_DESCRIPTIONS, Parameters, checked
from .declaration import (
    ParameterWatch,
    as_declared,
    check_files,
    destroyed_if_refused,
    declare,
    effective_values,
    files_without_section,
    overrides_of,
)
from .diagnostics import Loss, seconds
from .drive import make_drive
from .faults import Faults, planned
from .kick_off import KickOff
from .names import own_name
from .neighbours import Neighbours
from .node_time import NodeTime
from .outputs import OutputPublishers, are_finite
from .parameter_service import AllOrNone
from .process import run
from .process_pressure import ProcessPressure
from .ready import Ready
from .reporting import Condition, Reporter
from .stepping import Stepping
from .throttle import Throttle
from .tick_clock import NANOSECONDS, TickClock, nanoseconds
from .ticking import Ticking

DESCRIPTION = 'Simulate an electro-pneumatic valve positioner as a ROS 2 node.'
EXAMPLE = '--ros-args --params-file positioner.yaml -p publish_rate:=200.0\n' \
    'All parameters: docs/node.md, or `ros2 param describe` while it runs.'

CATCH_UP_PIECE = 0.1
"""Simulated seconds that are caught up before other callbacks have their turn."""

DIAGNOSTIC_PERIOD = 1.0
"""Seconds from one regular report on /diagnostics to the next."""

WARNING_PERIOD = 10.0
"""Seconds before a warning is given again."""


class Positioner(Node):
    """
    Simulates the positioner on the node's clock; ParameterError for bad parameters.

    Several fit into one process, and into one executor that runs one callback at a time.
    """

    def __init__(
        self, arguments: Sequence[str] = (), *, node_name: str = 'positioner',
        namespace: str | None = None, parameter_overrides: Mapping[str, Any] | None = None,
        context: Context | None = None,
    ) -> None:
        """
        Start with the parameters given, in files or as `parameter_overrides` (by dotted name).

        `arguments` is the command line, for messages only. Without a `context` it is rclpy's.
        """
        super().__init__(
            node_name, namespace=namespace, context=context,
            parameter_overrides=overrides_of(parameter_overrides or {}),
            automatically_declare_parameters_from_overrides=True, start_parameter_services=False)
        with destroyed_if_refused(self):
            self._begin(arguments)

    def _begin(self, arguments: Sequence[str]) -> None:
        check_files(arguments, self.get_fully_qualified_name(), checked)
        parameters = declare(self)
        settings = self._settings = parameters.node
        planned(settings.faults)  # refused here, not by the first parameter that rclpy declares
        self._watch = ParameterWatch(
            self, self._on_parameters, lambda parameters: planned(parameters.node.faults))
        self._parameter_service = AllOrNone(self, as_declared)
        period = round(NANOSECONDS / settings.publish_rate)
        step = nanoseconds(settings.integration_step)
        self._drive = make_drive(parameters, self._report_change)
        self._plant = self._drive.plant(step / NANOSECONDS)
        self._loss: Loss | None = None
        self._ticks = TickClock(
            period, step, nanoseconds(settings.max_catch_up),
            piece=max(2, nanoseconds(CATCH_UP_PIECE) // period))
        self._time = NodeTime(self)
        self._restarts = False
        self._throttle = Throttle(nanoseconds(WARNING_PERIOD))
        self._ticking = Ticking(
            self, self._time, self._ticks, self._throttle, self._run_ticks,
            paused=settings.start_paused or settings.step_on_command)
        self._stepping = Stepping(self, self._ticks.piece, self._evenly_stamped)

        self._outputs = OutputPublishers(
            self, own_name(self, settings.joint_name, 'valve_stem'),
            own_name(self, settings.frame_id, self.get_name()))
        self._process = ProcessPressure(self, self._throttle)
        self._commands = self._drive.commands(
            self, self._drive.rules(parameters), self._throttle, self._report_change,
            self._on_command)
        self._guard = self._commands.guard
        self._neighbours = Neighbours(
            self, self._commands.subscription, self._outputs.always_published)
        self._reporter = Reporter(
            self, self._time, self._ticks, self._guard, self._watch, self._condition)
        self._faults = Faults(
            self, self._plant, self._ticks, self._time, settings, self._on_faults)
        self._put_into_initial_state()
        self.create_service(Trigger, '~/reset', self._on_reset)
        self.create_service(SetBool, '~/pause', self._on_pause)
        # a group of its own: others have their turn between two portions of a step
        self.create_service(
            Trigger, '~/step', self._on_step, callback_group=MutuallyExclusiveCallbackGroup())
        self._steady_clock = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(DIAGNOSTIC_PERIOD, self._on_diagnostics, clock=self._steady_clock)
        self._ready = Ready(self)
        self._kick_off = KickOff(self, self._commands, self._outputs, self._kick)
        if settings.step_on_command:
            self._kick_off.begin()
        self._ticking.start()
        self._announce(arguments)

    def _announce(self, arguments: Sequence[str]) -> None:
        for path, sections in files_without_section(arguments, self.get_fully_qualified_name()):
            self.get_logger().warning(
                f'{path} holds nothing for {self.get_fully_qualified_name()} '
                f'(its sections: {sections}); `/**:` is for any node')
        values = {name: self.get_parameter(name).value for name in ALL_DESCRIPTIONS}
        self.get_logger().info(
            f'parameters in force (* other than the default):\n{effective_values(values)}')
        state = 'paused' if self._ticking.paused else 'running'
        self.get_logger().info(
            f'{state} on {"/clock" if self._time.follows_clock_topic else "wall time"}: '
            f'{self._settings.publish_rate:g} ticks per second')

    def _condition(self) -> Condition:
        thinned = self._ticking.thinning.left_out if self._ticking.thins else 0
        return Condition(
            self._ticking.paused, self._loss, thinned, self._neighbours.trouble, self._faults.on,
            self._faults.waiting, self._drive.reports())

    def _report_change(self) -> None:
        self._reporter.report_change()

    def _on_faults(self) -> None:
        self.get_logger().info(f'faults on: {", ".join(self._faults.on) or "none"}')
        self._reporter.report()

    # Ticks

    def _run_ticks(self, count: int) -> None:
        self._evenly_stamped()(count)

    def _evenly_stamped(self) -> Callable[[int], None]:
        """Return what runs so many ticks, their stamps a period apart to the nanosecond."""
        return partial(self._run_ticks_at, self._time.stamp_offset())

    def _run_ticks_at(self, offset: int, count: int) -> None:
        thins = self._ticking.thins
        for number in range(count):
            self._tick(offset, thins and number < count - 1)

    def _tick(self, stamp_offset: int, thinned: bool) -> None:
        if self._restarts:
            self._publish_restart(stamp_offset)
            return
        current = self._commands.at_tick(self._ticks.simulated)
        if self._loss is None:
            self._faults.before_tick()
        moment = self._ticks.next_due
        steps = self._ticks.run_tick()
        if self._loss is None:
            self._process.push(self._plant)
            self._drive.advance(self._plant, self._guard, current, steps)
            self._ticking.thinning.left_out += thinned
            self._publish(moment + stamp_offset, thinned)

    def _publish_restart(self, stamp_offset: int) -> None:
        """Publish the state after a reset, which takes a place of its own on the grid of ticks."""
        self._restarts = False
        moment = self._ticks.skip()
        if self._loss is None:
            self._publish(moment + stamp_offset)

    def _publish(self, stamp: int, thinned: bool = False) -> None:
        """Publish the outputs, at this time of the node's clock; report a state that is lost."""
        ideal = self._plant.readings()
        if not are_finite(ideal):
            self._on_loss()
            self._reporter.report()
            return
        self._readings = self._faults.read(ideal)
        self._outputs.faults = self._faults.shares
        self._outputs.set_point = self._drive.set_point(self._plant)
        self._outputs.publish(self._plant.outputs, self._readings, stamp, thinned)

    def _on_loss(self) -> None:
        self._loss = Loss(self._ticks.simulated, self.resolve_service_name('~/reset'))
        self.get_logger().error(str(self._loss))

    def _steady_now(self) -> int:
        return self._steady_clock.now().nanoseconds

    # Parameters

    def _on_parameters(self, parameters: Parameters) -> None:
        if parameters.node.step_on_command and not self._settings.step_on_command:
            self._kick_off.begin()
        self._settings = parameters.node
        rules = self._drive.rules(parameters)
        if self._guard.follow(rules):
            self.get_logger().warning(
                f'{rules.limits}: {rules.name} in force is now limited to '
                f'{self._guard.current:g} {rules.unit}')
        self._ticks.max_catch_up = nanoseconds(parameters.node.max_catch_up)
        self._faults.follow(parameters.physical, parameters.node)
        self.get_logger().info(f'parameters changed: {self._watch.last_change}')
        self._reporter.report()

    # For who runs the node instead of an executor

    def command(self, current: float) -> None:
        """Command a current, A, as a message would that arrives now."""
        self._commands.offer(current)

    def take_commands(self) -> None:
        """Take over the commands that have arrived."""
        self._commands.take_waiting()

    def advance(self, ticks: int) -> None:
        """Run and publish so many ticks of a paused positioner."""
        self._run_ticks(ticks)

    def restart(self) -> None:
        """Go to the initial state of a paused positioner and publish it."""
        self._on_reset(Trigger.Request(), Trigger.Response())

    def publish_again(self) -> None:
        """Publish the state of a paused positioner once more, with a stamp of its own."""
        self._kick()

    def sample(self) -> tuple[float, float, float, float]:
        """Return simulated time, s, current in force, A, and what the sensors read, Pa and m."""
        return self._ticks.simulated / NANOSECONDS, self._guard.current, *self._readings

    def inject(self, fields: Mapping[str, Any]) -> None:
        """Add a fault, as `~/inject` does; ParameterError where that cannot be."""
        self._faults.inject(fields)

    def clear(self) -> None:
        """Switch all faults off, as `~/clear` does."""
        self._faults.clear()

    @property
    def faults(self) -> list[str]:
        """The names of the faults that are on."""
        return self._faults.on

    # Services

    def _put_into_initial_state(self) -> None:
        state = self._settings.initial_state
        self._faults.restart()
        self._guard.force(self._drive.reset(self._plant, state))
        self._ticks.reset()
        self._loss = None
        if not are_finite(self._plant.readings()):
            self._on_loss()

    def _on_reset(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._stepping.stop()
        self._kick_off.end()
        self._commands.take_waiting()
        self._put_into_initial_state()
        self._restarts = True
        if self._ticking.stands:
            self._publish_restart(self._time.stamp_offset())
        self._reporter.report()
        state, rules = self._settings.initial_state, self._guard.rules
        response.success = self._loss is None
        response.message = str(self._loss) if self._loss else (
            f'chamber_pressure {state.chamber_pressure:g} Pa, valve_position '
            f'{self._plant.outputs().valve_position:g} m, {rules.name} '
            f'{self._guard.current:g} {rules.unit}, simulated time 0 s')
        return response

    def _on_pause(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        response.success = True
        response.message = 'paused' if request.data else 'running'
        if request.data != self._ticking.paused:
            self._stepping.stop()
            self._ticking.pause(request.data)
            if request.data and self._restarts:
                self._publish_restart(self._time.stamp_offset())
            self.get_logger().info(response.message)
            self._reporter.report()
        return response

    def _on_command(self) -> None:
        """Advance, where each command that arrives is to be followed by its ticks."""
        if not (self._ticking.paused and self._settings.step_on_command):
            return
        count = self._settings.step_ticks
        if count <= self._ticks.piece or self.executor is None:
            self._run_ticks(count)
            return
        self._commands.hold_back()
        self.executor.create_task(self._advance, count)

    async def _advance(self, count: int) -> int:
        self._commands.hold_back()
        done = await self._stepping.advance(count)
        self._commands.release()
        return done

    def _kick(self) -> None:
        """Publish the state as it is: a controller that answers to outputs has nothing before."""
        if self._ticking.paused:
            self._publish_restart(self._time.stamp_offset())

    async def _on_step(
        self, request: Trigger.Request, response: Trigger.Response
    ) -> Trigger.Response:
        if not self._ticking.paused:
            response.message = 'only a paused positioner steps: call ~/pause with data: true first'
            return response
        count = self._settings.step_ticks
        self._commands.take_waiting()
        done = await self._advance(count)
        response.success = self._loss is None and done == count
        response.message = str(self._loss) if self._loss else (
            f'{done} tick{"s" if done > 1 else ""}, simulated time '
            f'{seconds(self._ticks.simulated)} s')
        if done < count:
            response.message = f'ended by ~/reset or ~/pause after {response.message}'
        return response

    # Diagnostics

    def _on_diagnostics(self) -> None:
        for sentence in self._neighbours.look():
            self.get_logger().warning(sentence)
        self._reporter.report_regularly()
        if self._time.follows_clock_topic and self._time.now() == 0 and self._throttle.passes(
                'no /clock', self._steady_now()):
            self.get_logger().warning(
                'use_sim_time is true, but nothing has come on /clock: simulated time stands')


def main(args: Sequence[str] | None = None) -> int:
    """Run the node; `args` is the command line without the program's name."""
    arguments = sys.argv[1:] if args is None else list(args)
    return run('positioner', DESCRIPTION, lambda: Positioner(arguments), arguments, EXAMPLE)


if __name__ == '__main__':
    sys.exit(main())
