# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Measure CPU use and memory of the twin beside a positioner at 100 Hz, on the real clock.

    python -m booster_ros.benchmark.twin_cost [--seconds S]

Positioner, fake controller and twin run in processes of their own; every topic that the twin
listens to is published 100 times a second. The history is of 30 s, so that it is full before
anything is measured. Linux only.
"""

import argparse
import os
from pathlib import Path
import subprocess
import sys
import time

from .node_jitter import cpu_seconds
from ..programs.ros_domain import claim_domain

SETTLING = 60.0
"""Time, s, after which compiling, listening and the history are over."""

PARTS = 3
"""Parts of the measured time, each told on its own."""

COMMANDS = {
    'positioner': ('publish_rate:=100.0', 'measurement.pressure_noise:=150.0',
                   'measurement.position_noise:=8.0e-6'),
    'fake_controller': ('profile:=sines', 'loop:=true', 'frequencies:=[0.21,0.55,0.83]',
                        'low:=0.42e-3', 'high:=0.446e-3'),
    'twin': ('history:=30.0', 'block:=2.0', 'learning:=60.0'),
}


def main(arguments: list[str] | None = None) -> int:
    """Measure and print a Markdown table."""
    parser = argparse.ArgumentParser(prog='twin_cost', description='Measure what a twin costs.')
    parser.add_argument('--seconds', type=float, default=180.0, help='time that is measured')
    part = parser.parse_args(arguments).seconds / PARTS
    domain = claim_domain()
    told = {**os.environ, 'ROS_DOMAIN_ID': str(domain.id),
            'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}
    nodes = {name: subprocess.Popen(
        [sys.executable, '-m', f'booster_ros.nodes.{name}', '--ros-args',
         *(word for value in values for word in ('-p', value))],
        env=told, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        for name, values in COMMANDS.items()}
    try:
        time.sleep(SETTLING)
        print('| seconds after the start | CPU of the twin, % of a core | its memory, MB |')
        print('|---|---|---|')
        pid = nodes['twin'].pid
        for k in range(PARTS):
            before, begin = cpu_seconds(pid), time.monotonic()
            time.sleep(part)
            share = 100.0 * (cpu_seconds(pid) - before) / (time.monotonic() - begin)
            print(f'| {SETTLING + k * part:.0f} to {SETTLING + (k + 1) * part:.0f} | {share:.1f} '
                  f'| {_resident(pid):.1f} |', flush=True)
    finally:
        for node in nodes.values():
            node.terminate()
        for node in nodes.values():
            node.wait()
        domain.release()
    return 0


def _resident(pid: int) -> float:
    """Return the memory, MB, that a process has in use."""
    pages = int(Path(f'/proc/{pid}/statm').read_text().split()[1])
    return pages * os.sysconf('SC_PAGE_SIZE') / 1e6


if __name__ == '__main__':
    sys.exit(main())
