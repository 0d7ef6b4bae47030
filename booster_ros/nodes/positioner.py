# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The node `positioner`: a simulated electro-pneumatic valve positioner.

Everything happens in one thread, between two ticks or in a tick: commands that arrive wait for the
next tick, parameters change between ticks. `docs/node.md` describes topics, services, time.
"""

from collections.abc import Sequence
import sys

from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from rclpy.parameter import Parameter
from std_srvs.srv import SetBool, Trigger

from ..model.simulation import Plant
from ..parameters.schema import ALL_DESCRIPTIONS, NodeSettings, Parameters, checked
from .command_guard import CommandRules
from .commands import Commands
from .declaration import (
    ParameterWatch,
    check_files,
    declare,
    effective_values,
    files_without_section,
)
from .diagnostics import Loss, seconds
from .neighbours import Neighbours
from .node_time import NodeTime
from .outputs import OutputPublishers, is_finite
from .process import run
from .reporting import Condition, Reporter
from .stepping import Stepping
from .thinning import Thinning
from .throttle import Throttle
from .tick_clock import NANOSECONDS, TickClock, nanoseconds

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
    """Simulates the positioner on the node's clock; ParameterError for bad parameters."""

    def __init__(self, arguments: Sequence[str]) -> None:
        """Start with the parameters given; `arguments` is the command line, for messages only."""
        super().__init__('positioner', automatically_declare_parameters_from_overrides=True)
        check_files(arguments, self.get_fully_qualified_name(), checked)
        physical, settings = declare(self)
        self._settings = settings
        self._watch = ParameterWatch(self, self._on_parameters)
        self.add_post_set_parameters_callback(self._on_clock_choice)
        period = round(NANOSECONDS / settings.publish_rate)
        step = nanoseconds(settings.integration_step)
        self._plant = Plant(physical, step / NANOSECONDS)
        self._loss: Loss | None = None
        self._ticks = TickClock(
            period, step, nanoseconds(settings.max_catch_up),
            piece=max(2, nanoseconds(CATCH_UP_PIECE) // period))
        self._time = NodeTime(self)
        self._started = False
        self._paused = settings.start_paused
        self._restarts = False
        self._throttle = Throttle(nanoseconds(WARNING_PERIOD))
        self._thinning = Thinning()
        self._stepping = Stepping(self, self._ticks.piece, self._run_ticks)

        self._outputs = OutputPublishers(self)
        self._commands = Commands(
            self, _rules(settings), self._throttle, lambda: self._reporter.report_change(),
            lambda: None)
        self._guard = self._commands.guard
        self._neighbours = Neighbours(
            self, self._commands.subscription, self._outputs.always_published)
        self._reporter = Reporter(
            self, self._time, self._ticks, self._guard, self._watch, self._condition)
        self._put_into_initial_state()
        self.create_service(Trigger, '~/reset', self._on_reset)
        self.create_service(SetBool, '~/pause', self._on_pause)
        # a group of its own: others have their turn between two portions of a step
        self.create_service(
            Trigger, '~/step', self._on_step, callback_group=MutuallyExclusiveCallbackGroup())
        self._steady_clock = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(DIAGNOSTIC_PERIOD, self._on_diagnostics, clock=self._steady_clock)
        self._catch_up = self.create_guard_condition(self._on_time)
        self._start_timer()
        self._announce(arguments)

    def _announce(self, arguments: Sequence[str]) -> None:
        for path, sections in files_without_section(arguments, self.get_fully_qualified_name()):
            self.get_logger().warning(
                f'{path} holds nothing for {self.get_fully_qualified_name()} '
                f'(its sections: {sections}); `/**:` is for any node')
        values = {name: self.get_parameter(name).value for name in ALL_DESCRIPTIONS}
        self.get_logger().info(
            f'parameters in force (* other than the default):\n{effective_values(values)}')
        state = 'paused' if self._paused else 'running'
        self.get_logger().info(
            f'{state} on {"/clock" if self._time.follows_clock_topic else "wall time"}: '
            f'{self._settings.publish_rate:g} ticks per second')

    def _condition(self) -> Condition:
        thinned = self._thinning.left_out if self._thins() else 0
        return Condition(self._paused, self._loss, thinned, self._neighbours.trouble)

    # Time

    def _start_timer(self) -> None:
        """Tick from now on, on the clock that the node follows now."""
        self._begin()
        self._timer = self.create_timer(1.0, self._on_time, clock=self._time.clock)
        self._timer.timer_period_ns = self._ticks.period
        self._timer.reset()
        if self._paused:
            self._timer.cancel()

    def _begin(self) -> None:
        """Owe no ticks for the past. Simulated time shows 0 until something comes on /clock."""
        now = self._time.now()
        self._started = now > 0
        self._ticks.start(now)

    def _on_clock_choice(self, applied: list[Parameter]) -> None:
        if any(parameter.name == 'use_sim_time' for parameter in applied):
            self.destroy_timer(self._timer)
            self._start_timer()

    def _on_time(self) -> None:
        """Run the ticks that are due."""
        if self._paused:
            return
        if not self._started:
            self._begin()
            self._timer.reset()
            self.get_logger().info('/clock has begun')
            return
        due = self._ticks.due(self._time.now())
        if self._ticks.jump:
            self._on_clock_jump()
        self._thinning.note(self._ticks.backlog, self._steady_now() / NANOSECONDS)
        self._run_ticks(due)
        if self._ticks.backlog:
            self._catch_up.trigger()

    def _on_clock_jump(self) -> None:
        self._timer.reset()
        jump = self._ticks.jump / NANOSECONDS
        kind = 'jump backwards' if jump < 0.0 else 'jump forwards'
        if self._throttle.passes(kind, self._steady_now()):
            self.get_logger().warning(
                f'the clock jumped by {jump:+.3f} s: not simulated, the state is kept')

    def _run_ticks(self, count: int) -> None:
        offset = self._time.stamp_offset()
        thins = self._thins()
        for number in range(count):
            self._tick(offset, thins and number < count - 1)

    def _thins(self) -> bool:
        """Tell whether the node cannot keep up with wall time, and publishes less for that."""
        return not (self._paused or self._time.follows_clock_topic) and self._thinning.active(
            self._steady_now() / NANOSECONDS)

    def _tick(self, stamp_offset: int, thinned: bool) -> None:
        if self._restarts:
            self._publish_restart(stamp_offset)
            return
        current = self._commands.at_tick(self._ticks.simulated)
        moment = self._ticks.next_due
        steps = self._ticks.run_tick()
        if self._loss is None:
            self._plant.advance(current, steps)
            self._thinning.left_out += thinned
            self._publish(moment + stamp_offset, thinned)

    def _publish_restart(self, stamp_offset: int) -> None:
        """Publish the state after a reset, which takes a place of its own on the grid of ticks."""
        self._restarts = False
        moment = self._ticks.skip()
        if self._loss is None:
            self._publish(moment + stamp_offset)

    def _publish(self, stamp: int, thinned: bool = False) -> None:
        """Publish the outputs, at this time of the node's clock; report a state that is lost."""
        if not self._outputs.publish(self._plant, stamp, thinned):
            self._on_loss()
            self._reporter.report()

    def _on_loss(self) -> None:
        self._loss = Loss(self._ticks.simulated, self.resolve_service_name('~/reset'))
        self.get_logger().error(str(self._loss))

    def _steady_now(self) -> int:
        return self._steady_clock.now().nanoseconds

    # Parameters

    def _on_parameters(self, parameters: Parameters) -> None:
        self._settings = parameters.node
        if self._guard.follow(_rules(parameters.node)):
            self.get_logger().warning(
                f'current_limits now limit the current in force to {self._guard.current:g} A')
        self._ticks.max_catch_up = nanoseconds(parameters.node.max_catch_up)
        if parameters.physical != self._plant.parameters:
            self._plant.parameters = parameters.physical
        self.get_logger().info(f'parameters changed: {self._watch.last_change}')
        self._reporter.report()

    # Services

    def _put_into_initial_state(self) -> None:
        state = self._settings.initial_state
        self._plant.reset(state.chamber_pressure, state.valve_position, state.control_current)
        self._guard.force(state.control_current)
        self._ticks.reset()
        self._loss = None
        if not is_finite(self._plant):
            self._on_loss()

    def _on_reset(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._stepping.stop()
        self._commands.take_waiting()
        self._put_into_initial_state()
        self._restarts = True
        if self._paused:
            self._publish_restart(self._time.stamp_offset())
        self._reporter.report()
        state = self._settings.initial_state
        response.success = self._loss is None
        response.message = str(self._loss) if self._loss else (
            f'chamber_pressure {state.chamber_pressure:g} Pa, valve_position '
            f'{self._plant.outputs().valve_position:g} m, control_current '
            f'{state.control_current:g} A, simulated time 0 s')
        return response

    def _on_pause(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        response.success = True
        response.message = 'paused' if request.data else 'running'
        if request.data != self._paused:
            self._stepping.stop()
            self._paused = request.data
            if self._paused:
                self._timer.cancel()
                if self._restarts:
                    self._publish_restart(self._time.stamp_offset())
            else:
                self._begin()
                self._timer.reset()
            self.get_logger().info(response.message)
            self._reporter.report()
        return response

    async def _on_step(
        self, request: Trigger.Request, response: Trigger.Response
    ) -> Trigger.Response:
        if not self._paused:
            response.message = 'only a paused positioner steps: call ~/pause with data: true first'
            return response
        count = self._settings.step_ticks
        self._commands.take_waiting()
        self._commands.hold_back()
        done = await self._stepping.advance(count)
        self._commands.release()
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


def _rules(settings: NodeSettings) -> CommandRules:
    low, high = settings.current_limits
    return CommandRules(
        low, high, settings.invalid_current, settings.command_timeout, settings.stale_command)


def main(args: Sequence[str] | None = None) -> int:
    """Run the node; `args` is the command line without the program's name."""
    arguments = sys.argv[1:] if args is None else list(args)
    return run('positioner', DESCRIPTION, lambda: Positioner(arguments), arguments, EXAMPLE)


if __name__ == '__main__':
    sys.exit(main())
