# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A positioner in the process of the test, with a ROS domain of its own."""

from __future__ import annotations

from collections.abc import Mapping
from types import TracebackType
from typing import Any

import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter

from ..nodes.handling import handle_waiting
from ..nodes.positioner import Positioner
from ..programs.ros_domain import claim_domain
from .bench import Bench
from .matching import wait_for_match
from .series import Sample


class Valve(Bench):
    """
    Runs the node `positioner`, and with it the nodes that are to be tested, tick by tick.

    Use it as a context manager. It speaks on real topics and services, in a domain that no other
    process uses. Within one process DDS hands a message over before `publish` returns, so that
    a run depends on nothing but its commands: the same test gives the same bytes.
    """

    def __init__(
        self, parameters: Mapping[str, Any] | None = None, namespace: str | None = None,
        domain: int | None = None,
    ) -> None:
        """Start with parameters by dotted name; `domain` is a ROS domain other than one's own."""
        super().__init__()
        self._claimed = claim_domain() if domain is None else None
        self.domain = domain if self._claimed is None else self._claimed.id
        """The ROS domain, for other processes that are to take part."""
        self.context = Context()
        """Where nodes that take part are to be made: `MyNode(context=valve.context)`."""
        rclpy.init(args=[], context=self.context, domain_id=self.domain)
        self.positioner = Positioner(
            namespace=namespace, context=self.context,
            parameter_overrides={'start_paused': True, **(parameters or {})})
        """The node itself."""
        self.period = 1.0 / self.positioner.get_parameter('publish_rate').value
        self._executor = SingleThreadedExecutor(context=self.context)
        self._nodes: list[Node] = []
        self.reset()

    def add(self, node: Node) -> None:
        """
        Let a node take part: from now on it handles each sample before the next tick begins.

        AssertionError if it neither reads an output nor sends `control_current`.
        """
        wait_for_match(self.positioner, node)
        self._nodes.append(node)
        self._executor.add_node(node)
        self.positioner.publish_again()
        self.turn()

    def send(self, current: float) -> None:
        """Command a current, A, from the next tick on."""
        self.positioner.command(current)

    def step(self, ticks: int = 1) -> Sample:
        """Advance by so many ticks, before each of which the nodes handle the last sample."""
        for _ in range(ticks):
            self.turn()
            self.positioner.take_commands()
            self.positioner.advance(1)
            self._note()
        return self.now

    def reset(self) -> Sample:
        """Go to the initial state with all faults off, and return its sample."""
        self.series.clear()
        self.positioner.restart()
        return self._note()

    def set(self, values: Mapping[str, Any]) -> None:
        """Set parameters (by dotted name) together; AssertionError where they are refused."""
        result = self.positioner.set_parameters_atomically(
            [Parameter(name, value=value) for name, value in values.items()])
        assert result.successful, result.reason

    def inject(self, fault: str, **fields: Any) -> None:
        """Switch a fault on from the next tick on; fields as in docs/faults.md."""
        self.positioner.inject({'fault': fault, **fields})

    def clear(self) -> None:
        """Switch all faults off."""
        self.positioner.clear()

    @property
    def faults(self) -> list[str]:
        """The names of the faults that are on."""
        return self.positioner.faults

    def close(self) -> None:
        """End all nodes."""
        self._executor.shutdown()
        for node in (*self._nodes, self.positioner):
            node.destroy_node()
        self.context.try_shutdown()
        if self._claimed is not None:
            self._claimed.release()

    def _note(self) -> Sample:
        sample = Sample(*self.positioner.sample())
        self.series.append(sample)
        return sample

    def turn(self) -> None:
        """Let the nodes handle what has come for them, without any time for the valve."""
        if self._nodes:
            handle_waiting(self._executor)

    def __enter__(self) -> Valve:
        """Return the valve itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End all nodes."""
        self.close()
