# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which currents a positioner follows, as far as its parameters tell."""

from functools import partial
from typing import Any

import numpy as np
from rcl_interfaces.srv import GetParameters
from rclpy.client import Client
from rclpy.node import Node
from rclpy.parameter import parameter_value_to_python
from rclpy.task import Future

LIMITS = 'current_limits'
"""The parameter of a positioner that holds the lowest and the highest current it follows, A."""


PATIENCE = 3.0
"""Real time, s, for which the answer of a node that is asked for its limits is awaited."""

AGAIN = 0.3
"""Real time, s, after which a node that has not answered is asked again."""


class CurrentLimits:
    """
    The limits of the positioners that were asked, by the names of their nodes.

    No positioner follows a command beyond its limits: what was sent is then not what drove it. A
    node without the parameter follows any command, for all that is known.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._clients: dict[str, Client] = {}
        self._asked_at: dict[str, float] = {}
        self._awaited_since: dict[str, float] = {}
        self._limits: dict[str, tuple[float, float]] = {}

    def ask(self, name: str, now: float) -> None:
        """
        Ask a node for its limits until it answers; call this repeatedly.

        Its service may be found later, and an answer is lost where the node has not yet found who
        asks. `now` is the real time, s.
        """
        if name not in self._clients:
            self._clients[name] = self._node.create_client(GetParameters, f'{name}/get_parameters')
            self._awaited_since[name] = now
        elif (name in self._awaited_since and self._clients[name].service_is_ready()
              and now - self._asked_at.get(name, -AGAIN) >= AGAIN):
            self._asked_at[name] = now
            answer = self._clients[name].call_async(GetParameters.Request(names=[LIMITS]))
            answer.add_done_callback(partial(self._on_answer, name))

    def awaited(self, now: float) -> bool:
        """Tell whether a node that was asked may still answer; `now` is the real time, s."""
        return any(now - since < PATIENCE for since in self._awaited_since.values())

    def take(self, name: str, value: Any) -> None:
        """Keep the limits of a node, A; a value that is not two numbers is ignored."""
        limits = np.asarray(value)
        if limits.shape == (2,) and limits.dtype.kind in 'fi':
            self._limits[name] = float(limits[0]), float(limits[1])

    def complaint(self, current: float) -> str:
        """Return the sentence on a current (A) beyond the limits of one of them, '' for none."""
        for name, (low, high) in self._limits.items():
            if not low <= current <= high:
                return (f'{current:g} A is outside the {LIMITS} of {name}, {low:g} to {high:g} A: '
                        'it does not follow that')
        return ''

    def _on_answer(self, name: str, answer: Future) -> None:
        self._awaited_since.pop(name, None)
        response = answer.result()
        if response is not None and response.values:
            self.take(name, parameter_value_to_python(response.values[0]))
