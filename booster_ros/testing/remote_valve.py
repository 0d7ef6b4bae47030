# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A positioner in a process of its own, as launch_testing or `ros2 run` started it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
import time
from types import TracebackType
from typing import Any

from rcl_interfaces.msg import Log
from rcl_interfaces.srv import GetParameters, SetParametersAtomically
import rclpy
from rclpy.client import Client
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Bool, Float64
from std_srvs.srv import SetBool, Trigger

from ..nodes.tick_clock import NANOSECONDS
from .bench import Bench
from .series import Sample, Series

PATIENCE = 30.0
"""Real seconds after which something that does not come is given up."""

QUIET = 0.3
"""Real seconds without an output after which none of those before a reset is on its way."""

_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_LOGS = QoSProfile(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_DEPTH = 1000


class RemoteValve(Bench):
    """
    Advances one positioner over topics and services; use it as a context manager.

    The positioner is paused and told to step on commands: each command is one tick, and nothing
    else is waited for but its outputs. AssertionError where it does not answer.
    """

    def __init__(self, name: str = '/positioner', domain: int | None = None) -> None:
        """Wait until the positioner of this full name is ready, and reset it."""
        super().__init__()
        self.name = name
        """The full name of the positioner."""
        self._context = Context()
        rclpy.init(args=[], context=self._context, domain_id=domain)
        namespace = name.rpartition('/')[0] or '/'
        self._node = Node(
            'valve_bench', namespace=namespace, context=self._context,
            start_parameter_services=False)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._services: dict[str, Client] = {}
        self._pressures: list[float] = []
        self._positions: list[float] = []
        self._current = 0.0
        self._ready = False
        self._commands = self._node.create_publisher(Float64, 'control_current', 10)
        self._outputs = (
            self._node.create_subscription(
                Float64, 'chamber_pressure', self._on_pressure, _DEPTH),
            self._node.create_subscription(
                Float64, 'valve_position', self._on_position, _DEPTH))
        self._wait_ready()
        self._prepare()

    def _on_pressure(self, message: Float64) -> None:
        self._pressures.append(message.data)

    def _on_position(self, message: Float64) -> None:
        self._positions.append(message.data)

    def collect_log(self) -> list[str]:
        """Return what nodes have logged so far, a line for each message."""
        lines: list[str] = []

        def note(message: Log) -> None:
            lines.append(f'[{message.name}] {message.msg}')

        logs = self._node.create_subscription(Log, '/rosout', note, _LOGS)
        end = time.monotonic() + QUIET
        while time.monotonic() < end:
            before = len(lines)
            self._executor.spin_once(timeout_sec=QUIET)
            end = time.monotonic() + QUIET if len(lines) > before else end
        self._node.destroy_subscription(logs)
        return lines

    def _wait_ready(self) -> None:
        def ready(message: Bool) -> None:
            self._ready = message.data

        waiting = self._node.create_subscription(Bool, f'{self.name}/ready', ready, _LATCHED)
        self._spin_until(lambda: self._ready, f'{self.name} is not ready')
        self._node.destroy_subscription(waiting)

    def _prepare(self) -> None:
        self._call('pause', SetBool, SetBool.Request(data=True))
        values = self._call('get_parameters', GetParameters, GetParameters.Request(
            names=['publish_rate'])).values
        rate = parameter_value_to_python(values[0])
        self.period, self._tick = 1.0 / rate, round(NANOSECONDS / rate)
        self._spin_until(
            lambda: self._commands.get_subscription_count() > 0
            and all(output.get_publisher_count() for output in self._outputs),
            f'{self.name} does not take part in {self._commands.topic_name}')
        self.set({'step_on_command': True, 'step_ticks': 1})
        # a subscription may know its publisher before the publisher knows it
        for _ in range(10):
            self._pressures.clear()
            self._positions.clear()
            self._call('reset', Trigger, Trigger.Request())
            if self._arrive(1, 2.0):
                break
        else:
            raise AssertionError(f'no output of {self.name} arrives')
        while self._arrive(min(len(self._pressures), len(self._positions)) + 1, QUIET):
            pass
        self.reset()

    def send(self, current: float) -> None:
        """Command a current, A, from the next tick on."""
        self._current = current

    def step(self, ticks: int = 1) -> Sample:
        """Advance by so many ticks and return the last sample."""
        for _ in range(ticks):
            self._commands.publish(Float64(data=self._current))
            self._await_sample(len(self.series) + 1)
        return self.now

    def follow(self, seconds: float) -> Series:
        """
        Let another process send the commands, and return the samples of so many seconds.

        Each of its commands advances the valve by a tick.
        """
        found = Series()
        for _ in range(max(1, round(seconds / self.period))):
            self._await_sample(len(self.series) + 1)
            found.append(self.now)
        return found

    def reset(self) -> Sample:
        """Go to the initial state with all faults off, and return its sample."""
        self.series.clear()
        self._pressures.clear()
        self._positions.clear()
        self._current = 0.0
        self._call('reset', Trigger, Trigger.Request())
        return self._await_sample(1)

    def set(self, values: Mapping[str, Any]) -> None:
        """Set parameters (by dotted name) together; AssertionError where they are refused."""
        self._set('set_parameters_atomically', values)

    def inject(self, fault: str, **fields: Any) -> None:
        """Switch a fault on from the next tick on; fields as in docs/faults.md."""
        parameters = fields.pop('parameters', {})
        self._set('inject', {
            'fault': fault, **fields,
            **{f'parameters.{name}': value for name, value in parameters.items()}})

    def clear(self) -> None:
        """Switch all faults off."""
        self._call('clear', Trigger, Trigger.Request())

    def _set(self, service: str, values: Mapping[str, Any]) -> None:
        result = self._call(service, SetParametersAtomically, SetParametersAtomically.Request(
            parameters=[Parameter(name, value=value).to_parameter_msg()
                        for name, value in values.items()])).result
        assert result.successful, result.reason

    def close(self) -> None:
        """Leave the positioner paused, and end."""
        self._executor.shutdown()
        self._node.destroy_node()
        self._context.try_shutdown()

    def _await_sample(self, count: int) -> Sample:
        assert self._arrive(count, PATIENCE), (
            f'{self.name} has sent no sample number {count} after {PATIENCE:g} s')
        sample = Sample(
            (count - 1) * self._tick / NANOSECONDS, self._current, self._pressures[count - 1],
            self._positions[count - 1])
        self.series.append(sample)
        return sample

    def _arrive(self, count: int, timeout: float) -> bool:
        """Wait for so many of each output, and return whether they have come."""
        end = time.monotonic() + timeout
        while min(len(self._pressures), len(self._positions)) < count:
            if time.monotonic() > end:
                return False
            self._executor.spin_once(timeout_sec=0.1)
        return True

    def _spin_until(self, done: Callable[[], bool], complaint: str) -> None:
        end = time.monotonic() + PATIENCE
        while not done():
            assert time.monotonic() < end, f'{complaint} after {PATIENCE:g} s'
            self._executor.spin_once(timeout_sec=0.05)

    def _call(self, service: str, kind: Any, request: Any) -> Any:
        """Call a service of the positioner; what was not answered is asked again."""
        client = self._services.get(service)
        if client is None:
            client = self._services[service] = self._node.create_client(
                kind, f'{self.name}/{service}')
        self._spin_until(client.service_is_ready, f'there is no service {client.srv_name}')
        for _ in range(3):
            answer = client.call_async(request)
            end = time.monotonic() + PATIENCE / 3.0
            while not answer.done() and time.monotonic() < end:
                self._executor.spin_once(timeout_sec=0.05)
            if answer.done():
                return answer.result()
            client.remove_pending_request(answer)
        raise AssertionError(f'{client.srv_name} does not answer')

    def __enter__(self) -> RemoteValve:
        """Return the valve itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End."""
        self.close()
