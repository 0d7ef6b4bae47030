# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Measure the positioner's CPU use and the jitter of its ticks, beside rclpy's own floor.

    python -m booster_ros.benchmark.node_jitter

The floor is a timer that publishes the same messages and computes nothing. Both run in turns, each
in a process of its own; jitter is by how much the time between two publications differs from the
period, from the time stamps that the publishing DDS puts on its messages. Linux only.
"""

import os
from pathlib import Path
import statistics
import subprocess
import sys
import time
from typing import Any, NamedTuple

import numpy as np
import rclpy
from rclpy.executors import SingleThreadedExecutor
from std_msgs.msg import Float64

from ..programs.ros_domain import claim_domain

RATES = (100.0, 1000.0)
ROUNDS = 5
SETTLING = 1.0
MEASURED = 3.0
CURRENT = 0.4524e-3

COMMANDS = {
    'floor': 'booster_ros.benchmark.node_floor',
    'positioner': 'booster_ros.nodes.positioner',
}


class Sample(NamedTuple):
    """
    One run: CPU use in % of a core, in µs per tick; jitter's percentiles, µs; ticks missing.

    rclpy's timer skips ticks where the machine is busy, the positioner catches them up: per tick
    the two can be compared even then.
    """

    cpu: float
    per_tick: float
    p50: float
    p99: float
    worst: float
    missing: int


def measure(module: str, rate: float) -> Sample:
    """Run a node at a rate (Hz), with a current commanded, and measure it."""
    node = subprocess.Popen(
        [sys.executable, '-m', module, '--ros-args', '-p', f'publish_rate:={rate}'],
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    listener = rclpy.create_node('listener')
    executor = SingleThreadedExecutor()
    executor.add_node(listener)
    stamps: list[int] = []

    def note(message: Float64, about: dict[str, Any]) -> None:
        stamps.append(about['source_timestamp'])

    # rclpy's annotation does not know of callbacks that are told about the message as well
    listener.create_subscription(
        Float64, 'chamber_pressure', note, 1000)  # type: ignore[arg-type]
    commands = listener.create_publisher(Float64, 'control_current', 10)
    try:
        while not stamps:
            executor.spin_once()
        commands.publish(Float64(data=CURRENT))
        _spin(executor, SETTLING)
        stamps.clear()
        before, begin = cpu_seconds(node.pid), time.monotonic()
        _spin(executor, MEASURED)
        used, passed = cpu_seconds(node.pid) - before, time.monotonic() - begin
    finally:
        node.terminate()
        node.wait()
        executor.shutdown()
        listener.destroy_node()
    return _sample(np.array(stamps), 1e9 / rate, used, passed)


def _spin(executor: SingleThreadedExecutor, seconds: float) -> None:
    end = time.monotonic() + seconds
    while (left := end - time.monotonic()) > 0.0:
        executor.spin_once(timeout_sec=left)


def cpu_seconds(pid: int) -> float:
    """Return the CPU time, user and system, that a process has used so far."""
    fields = Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')


def _sample(stamps: np.ndarray, period: float, used: float, passed: float) -> Sample:
    jitter = np.abs(np.diff(stamps) - period) / 1e3
    p50, p99 = np.percentile(jitter, (50, 99))
    missing = round((stamps[-1] - stamps[0]) / period) + 1 - len(stamps)
    return Sample(
        100.0 * used / passed, 1e6 * used / len(stamps), float(p50), float(p99),
        float(jitter.max()), missing)


def main() -> int:
    """Measure and print a Markdown table of medians over the rounds."""
    domain = claim_domain()
    os.environ['ROS_DOMAIN_ID'] = str(domain.id)
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    rclpy.init()
    print('| rate Hz | node | CPU % of a core | CPU µs per tick | jitter p50 µs | p99 µs '
          '| worst µs | missing |')
    print('|---|---|---|---|---|---|---|---|')
    for rate in RATES:
        samples: dict[str, list[Sample]] = {name: [] for name in COMMANDS}
        for _ in range(ROUNDS):
            for name, module in COMMANDS.items():
                samples[name].append(measure(module, rate))
        for name, found in samples.items():
            cpu, *others = (statistics.median(column) for column in zip(*found, strict=True))
            print(f'| {rate:g} | {name} | {cpu:.1f} | '
                  + ' | '.join(f'{value:.0f}' for value in others) + ' |', flush=True)
        added = statistics.median(
            ours.per_tick / floor.per_tick - 1.0
            for ours, floor in zip(samples['positioner'], samples['floor'], strict=True))
        print(f'| {rate:g} | added to the floor | | {100.0 * added:+.0f} % | | | | |', flush=True)
    rclpy.try_shutdown()
    domain.release()
    return 0


if __name__ == '__main__':
    sys.exit(main())
