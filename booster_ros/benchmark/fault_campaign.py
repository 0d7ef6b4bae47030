# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Inject faults by the hundred into a running positioner, and count what is seen and what is left.

    python -m booster_ros.benchmark.fault_campaign [COUNT]

The positioner runs in a process of its own, at 100 Hz on wall time. Each fault is injected over
`~/inject`, waited for in `~/state`, and cleared; all faults take their turns. Linux only.
"""

from collections.abc import Callable
import os
from pathlib import Path
import subprocess
import sys
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.srv import SetParametersAtomically
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from std_srvs.srv import Trigger

from ..faults.kinds import FAULTS
from ..programs.ros_domain import claim_domain

COUNT = 1000
STATE_DEPTH = 1000
PATIENCE = 20.0
"""Real seconds after which a fault that is not seen counts as missed."""


class Campaign:
    """Listens to one positioner and talks to it."""

    def __init__(self) -> None:
        self._node = rclpy.create_node('campaign')
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self._node)
        self._inject = self._node.create_client(SetParametersAtomically, 'positioner/inject')
        self._clear = self._node.create_client(Trigger, 'positioner/clear')
        self._ticks: list[int] = []
        self._on: list[str] = []
        self._node.create_subscription(
            DiagnosticArray, 'positioner/state', self._on_state, STATE_DEPTH)

    def wait(self) -> None:
        """Wait until the positioner is there."""
        while not (self._inject.service_is_ready() and self._clear.service_is_ready()
                   and self._ticks):
            self._executor.spin_once(timeout_sec=0.1)
        self._ticks.clear()

    def _on_state(self, message: DiagnosticArray) -> None:
        state, faults = message.status
        self._ticks.append(round(100.0 * float(state.values[0].value)))
        self._on = [entry.key for entry in faults.values]

    def inject(self, name: str) -> bool:
        """Inject a fault, wait until it is seen, clear it, and return whether it was seen."""
        parameter = Parameter('fault', value=name).to_parameter_msg()
        answer = self._call(self._inject, SetParametersAtomically.Request(parameters=[parameter]))
        seen = bool(answer.result.successful) and self._until(lambda: self._on == [name])
        self._call(self._clear, Trigger.Request())
        return seen and self._until(lambda: not self._on)

    def lost(self) -> int:
        """Return how many ticks were not seen between the first and the last."""
        return self._ticks[-1] - self._ticks[0] + 1 - len(set(self._ticks))

    def left(self) -> int:
        """Return how many faults are on now."""
        return len(self._on)

    def _call(self, client: Any, request: Any) -> Any:
        answer = client.call_async(request)
        while not answer.done():
            self._executor.spin_once(timeout_sec=0.1)
        return answer.result()

    def _until(self, done: Callable[[], bool]) -> bool:
        end = time.monotonic() + PATIENCE
        while not done() and time.monotonic() < end:
            self._executor.spin_once(timeout_sec=0.1)
        return done()


def _memory(pid: int) -> float:
    """Return the resident memory of a process, MB."""
    for line in Path(f'/proc/{pid}/status').read_text().splitlines():
        if line.startswith('VmRSS'):
            return float(line.split()[1]) / 1024.0
    return 0.0


def main() -> int:
    """Run the campaign and print what came of it."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else COUNT
    domain = claim_domain()
    os.environ['ROS_DOMAIN_ID'] = str(domain.id)
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    node = subprocess.Popen(
        [sys.executable, '-m', 'booster_ros', 'positioner', '--ros-args', '-p',
         'initial_state.control_current:=0.00043'], stderr=subprocess.DEVNULL)
    rclpy.init()
    try:
        campaign = Campaign()
        campaign.wait()
        names = list(FAULTS)
        seen, memory = 0, []
        for number in range(count):
            seen += campaign.inject(names[number % len(names)])
            if number % max(count // 10, 1) == 0:
                memory.append(_memory(node.pid))
        memory.append(_memory(node.pid))
        print(f'injected {count}, seen and gone {seen}, left behind {campaign.left()}, '
              f'ticks lost {campaign.lost()}')
        print(f'memory, MB: {", ".join(f"{value:.1f}" for value in memory)}')
    finally:
        node.terminate()
        node.wait()
        rclpy.try_shutdown()
        domain.release()
    return 0


if __name__ == '__main__':
    sys.exit(main())
