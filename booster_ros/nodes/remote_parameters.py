# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The parameters of a node in another process: read and set together, without waiting."""

from collections import deque
from collections.abc import Callable, Mapping
import time
from typing import Any, NamedTuple

from rcl_interfaces.srv import GetParameters, SetParametersAtomically
from rclpy.client import Client
from rclpy.node import Node
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.task import Future

PATIENCE = 10.0
"""Seconds in which the other node has to be there and answer."""


class _Job(NamedTuple):
    """Values to set; what is told of those before, and at the end of what went wrong."""

    values: dict[str, Any]
    before: Callable[[dict[str, Any]], None] | None
    done: Callable[[str], None]


class RemoteParameters:
    """Sets parameters of the node `name` by one atomic call each time; `turn` has to be called."""

    def __init__(self, node: Node, name: str) -> None:
        self.name = name
        """Of the other node, with its namespace where that is not the one of `node`."""
        self._get = node.create_client(GetParameters, f'{name}/get_parameters')
        self._set = node.create_client(
            SetParametersAtomically, f'{name}/set_parameters_atomically')
        self._jobs: deque[_Job] = deque()
        self._deadline: float | None = None
        self._asked: tuple[Client, Future] | None = None

    def exchange(self, values: Mapping[str, Any], before: Callable[[dict[str, Any]], None],
                 done: Callable[[str], None]) -> None:
        """
        Set all values or none, once `before` has been told what they were.

        `done` is called with '' at the end, or with a sentence on what went wrong.
        """
        self._jobs.append(_Job(dict(values), before, done))

    def put(self, values: Mapping[str, Any], done: Callable[[str], None]) -> None:
        """Set all values or none, after what was asked for earlier; `done` as of `exchange`."""
        self._jobs.append(_Job(dict(values), None, done))

    def turn(self) -> None:
        """Go on with what has been answered; give up what has not been in time."""
        if not self._jobs:
            return
        job = self._jobs[0]
        if self._deadline is None:
            self._deadline = time.monotonic() + PATIENCE
        if self._asked is None:
            if self._get.service_is_ready() and self._set.service_is_ready():
                self._ask(job)
        elif self._asked[1].done():
            client, future = self._asked
            self._answered(job, client, future.result())
            return
        if time.monotonic() > self._deadline:
            if self._asked is not None:
                client, future = self._asked
                client.remove_pending_request(future)
            self._finish(job, f'{self.name} did not answer within {PATIENCE:g} s')

    def _ask(self, job: _Job) -> None:
        if job.before is not None:
            self._asked = self._get, self._get.call_async(
                GetParameters.Request(names=list(job.values)))
        else:
            self._send(job)

    def _answered(self, job: _Job, client: Client, answer: Any) -> None:
        if client is self._get:
            before = {name: parameter_value_to_python(value)
                      for name, value in zip(job.values, answer.values)}
            if job.before is not None:
                job.before({name: value for name, value in before.items() if value is not None})
            self._send(job)
            return
        self._finish(job, '' if answer.result.successful else (
            f'{self.name} refused: {answer.result.reason}'))

    def _send(self, job: _Job) -> None:
        parameters = [Parameter(name, value=list(value) if isinstance(value, tuple) else value)
                      .to_parameter_msg() for name, value in job.values.items()]
        self._asked = self._set, self._set.call_async(
            SetParametersAtomically.Request(parameters=parameters))

    def _finish(self, job: _Job, problem: str) -> None:
        self._jobs.popleft()
        self._deadline = self._asked = None
        job.done(problem)
