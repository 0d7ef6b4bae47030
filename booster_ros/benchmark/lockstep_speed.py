# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Measure how fast a controller and the positioner alternate, as a multiple of real time.

    python -m booster_ros.benchmark.lockstep_speed

A PI controller closes the position loop at 100 Hz: as a function and as a ROS node in the process
of the positioner, and in a process of its own. Each run is repeated; the bytes of all samples have
to be the same.
"""

from collections.abc import Callable
import os
import subprocess
import sys
import time

from rclpy.context import Context
from rclpy.logging import LoggingSeverity, set_logger_level
from rclpy.node import Node
from std_msgs.msg import Float64

from ..control.pi import PiController
from ..programs.ros_domain import claim_domain
from ..testing import RemoteValve, Sample, Series, Valve

SECONDS = 20.0
ROUNDS = 5
PERIOD = 0.01
POSITIONS = (0.004, 0.012, 0.0118)
"""Set points, m, each for an equal share of the time."""


class Loop:
    """The position loop under test."""

    def __init__(self) -> None:
        self._pi = PiController(0.2, 5.0, 0.0, 6e-4, 4e-4)
        self._samples = 0

    def current(self, position: float) -> float:
        """Return the current (A) after the next position, m."""
        share = self._samples * PERIOD / SECONDS
        self._samples += 1
        set_point = POSITIONS[min(int(share * len(POSITIONS)), len(POSITIONS) - 1)]
        return self._pi.update(set_point - position, PERIOD)


class LoopNode(Node):
    """The same loop as a node that answers each position with a current."""

    def __init__(self, context: Context) -> None:
        super().__init__('loop', context=context)
        self._loop = Loop()
        self._currents = self.create_publisher(Float64, 'control_current', 10)
        self.create_subscription(Float64, 'valve_position', self._on_position, 10)

    def _on_position(self, message: Float64) -> None:
        self._currents.publish(Float64(data=self._loop.current(message.data)))


Measured = tuple[float, bytes]


def in_process_function() -> Measured:
    """Let a function close the loop."""
    with Valve() as valve:
        loop = Loop()
        return _timed(valve.series, lambda: valve.run(
            SECONDS, lambda sample: loop.current(sample.valve_position)))


def in_process_node() -> Measured:
    """Let a node in the same process close the loop, over topics."""
    with Valve() as valve:
        valve.add(LoopNode(valve.context))
        return _timed(valve.series, lambda: valve.run(SECONDS))


def across_processes() -> Measured:
    """Let this process close the loop of a positioner in another one, over topics."""
    domain = claim_domain()
    environment = {**os.environ, 'ROS_DOMAIN_ID': str(domain.id)}
    node = subprocess.Popen(
        [sys.executable, '-m', 'booster_ros', 'positioner', '--ros-args', '-p',
         'start_paused:=true'], env=environment, stderr=subprocess.DEVNULL)
    try:
        with RemoteValve(domain=domain.id) as valve:
            loop = Loop()

            def controller(sample: Sample) -> float:
                return loop.current(sample.valve_position)
            return _timed(valve.series, lambda: valve.run(SECONDS, controller))
    finally:
        node.terminate()
        node.wait()
        domain.release()


def _timed(series: Series, run: Callable[[], Series]) -> Measured:
    begin = time.perf_counter()
    run()
    return SECONDS / (time.perf_counter() - begin), series.tobytes()


CASES = {
    'a function in the same process': in_process_function,
    'a node in the same process': in_process_node,
    'another process': across_processes,
}


def main() -> int:
    """Measure and print a Markdown table: median, slowest and fastest of the rounds."""
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    set_logger_level('positioner', LoggingSeverity.WARN)
    print('| controller | times real time | slowest | fastest | runs alike to the bit |')
    print('|---|---|---|---|---|')
    for name, case in CASES.items():
        runs = [case() for _ in range(ROUNDS)]
        speeds = sorted(speed for speed, _ in runs)
        alike = 'yes' if len({content for _, content in runs}) == 1 else 'no'
        print(f'| {name} | {speeds[ROUNDS // 2]:.1f} | {speeds[0]:.1f} | {speeds[-1]:.1f} '
              f'| {alike} |', flush=True)
    return 0


if __name__ == '__main__':
    sys.exit(main())
