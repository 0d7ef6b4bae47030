# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
When commands are sent: tick by tick, with a paused positioner that is advanced by its services.

Nothing depends on how fast messages travel: a step is asked for when the command has been sent,
the positioner takes waiting commands before it steps, and the next command is sent when the
outputs of that step are here.
"""

import math
from typing import Any

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from rclpy.parameter import parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient
from rclpy.task import Future
from std_srvs.srv import SetBool, Trigger

from ..model.parameters import ParameterError
from ..run_error import RunError
from .current_limits import LIMITS, CurrentLimits
from .pace import Player
from .tick_clock import NANOSECONDS

PATIENCE = 5.0
"""Seconds of real time after which a positioner that does not answer is given up."""

QUIET = 0.2
"""Seconds to wait for the last messages of a positioner that was just paused."""


class Lockstep:
    """
    Advances one positioner from its initial state; its name is as seen from `node`.

    The first output is the initial state; each output is stamped with its tick, whatever the
    clocks show. At the end the positioner runs on, unless it was started paused.
    """

    def __init__(self, node: Node, positioner: str, rate: float, limits: CurrentLimits) -> None:
        self._begin = 0
        self._node = node
        self._positioner = positioner
        self._rate = rate
        self._limits = limits
        self._clock = Clock(clock_type=ClockType.STEADY_TIME)
        self._pause = node.create_client(SetBool, f'{positioner}/pause')
        self._reset = node.create_client(Trigger, f'{positioner}/reset')
        self._step = node.create_client(Trigger, f'{positioner}/step')
        self._parameters = AsyncParameterClient(node, positioner)
        self._period = 0
        self._stays_paused = False
        self._samples: dict[str, int] = {}
        self._awaited = 0
        self._answers = self._answers_seen = 0
        self._arrival: Future | None = None
        self._given_up = False

    def missing(self) -> list[str]:
        """
        Return the services that nobody offers.

        Those of the parameters count too: they may be found later, and a request before is lost.
        """
        missing = [
            client.srv_name for client in (self._pause, self._reset, self._step)
            if not client.service_is_ready()]
        if not self._parameters.services_are_ready():
            missing.append(f'{self._positioner}/get_parameters')
        return [f'there is no {self._node.resolve_service_name(name)}' for name in missing]

    def begin(self, player: Player, last_sample: int) -> None:
        """Play from now on, as a task beside the callbacks of the node."""
        executor = self._node.executor
        assert executor is not None
        executor.create_task(self._play, player)
        self._node.create_timer(PATIENCE, self._check_progress, clock=self._clock)

    def stamp(self, column: str, received: int) -> int | None:
        """Return the stamp of the tick that an output belongs to, None before the first."""
        if column not in self._samples:
            return None
        stamp = self._begin + self._samples[column] * self._period
        self._samples[column] += 1
        if self._arrival is not None and self._has_arrived():
            self._arrival.set_result(None)
            self._arrival = None
        return stamp

    def left_behind(self) -> str:
        """Return the sentence that it stays paused, as an ended context calls no service."""
        if self._stays_paused or self._given_up or not self._answers:
            return ''
        service = self._node.resolve_service_name(self._pause.srv_name)
        return (f'{self._positioner} stays paused until '
                f'"ros2 service call {service} std_srvs/srv/SetBool \'{{data: false}}\'"')

    def _check_progress(self) -> None:
        if self._answers == self._answers_seen:
            self._given_up = True
            raise RunError(f'lockstep: {self._positioner} does not answer')
        self._answers_seen = self._answers

    async def _play(self, player: Player) -> None:
        ticks = await self._prepare()
        await self._wait(QUIET)
        self._begin = self._node.get_clock().now().nanoseconds
        player.begin(self._begin)
        self._samples = {'chamber_pressure': 0, 'valve_position': 0}
        await self._call(self._reset, Trigger.Request())
        await self._outputs(1)
        for number in range(math.ceil(player.duration * self._rate - 1e-9)):
            player.send(number / self._rate, self._begin + number * ticks * self._period)
            await self._call(self._step, Trigger.Request())
            await self._outputs(1 + (number + 1) * ticks)
        if not self._stays_paused:
            await self._call(self._pause, SetBool.Request(data=False))
        player.finish()

    async def _prepare(self) -> int:
        """Pause the positioner and return its ticks for each step."""
        response = await self._parameters.get_parameters(
            ['publish_rate', 'step_ticks', 'start_paused', LIMITS])
        publish_rate, ticks, self._stays_paused, limits = (
            parameter_value_to_python(value) for value in response.values)
        self._limits.take(self._positioner, limits)
        if publish_rate is None or ticks is None:
            raise RunError(
                f'lockstep: {self._positioner} has no parameters publish_rate and step_ticks')
        if abs(self._rate * ticks - publish_rate) > 1e-9 * publish_rate:
            raise ParameterError(
                f'rate ({self._rate:g} Hz) must in lockstep be publish_rate / step_ticks of '
                f'{self._positioner}, {publish_rate / ticks:g} Hz')
        self._period = round(NANOSECONDS / publish_rate)
        await self._call(self._pause, SetBool.Request(data=True))
        return int(ticks)

    async def _call(self, client: Any, request: Any) -> None:
        response = await client.call_async(request)
        self._answers += 1
        if not response.success:
            raise RunError(f'lockstep: {client.srv_name}: {response.message}')

    async def _outputs(self, count: int) -> None:
        """Wait until `count` of each output have arrived."""
        self._awaited = count
        if not self._has_arrived():
            self._arrival = Future(executor=self._node.executor)
            await self._arrival

    def _has_arrived(self) -> bool:
        return min(self._samples.values()) >= self._awaited

    async def _wait(self, seconds: float) -> None:
        over: Future = Future(executor=self._node.executor)
        timer = self._node.create_timer(
            seconds, lambda: over.done() or over.set_result(None), clock=self._clock)
        await over
        self._node.destroy_timer(timer)
