# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Records of real valves, put into a bag and played to a twin over topics, on the clock of the bag.

    python -m booster_ros.benchmark.twin_replay RECORD [RECORD ...] --params P [-p NAME:=VALUE ...]

Each RECORD goes on from the one before. Parameters are those of the twin. Prints what the twin
misses, its alarms, and how it says that the valve is. `ros2 bag play BAG --clock` beside `ros2 run
booster_ros twin --ros-args -p use_sim_time:=true` does the same, in the time that the bag takes.
"""

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path
import sys
import tempfile
from typing import Any

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
import numpy as np
import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float64, String
import yaml

from ..nodes.handling import handle_waiting
from ..nodes.ready import LATCHED
from ..nodes.tick_clock import NANOSECONDS
from ..nodes.twin import TwinNode
from ..programs.ros_domain import claim_domain
from ..records import read_record
from ..records.bag_writer import BagWriter
from ..twin.aligning import CHANNELS

BEGIN = 1000.0
"""Time of the first row in the bag, s: a clock at zero is one that has not been set."""

TURN = 0.5
"""Time of the bag from one turn of the twin to the next, s."""


def write_bag(records: Sequence[Path], bag: Path) -> None:
    """Write the channels of records, one after the other, as a bag of plain topics."""
    read = [read_record(path) for path in records]
    names = [name for name in CHANNELS if all(name in record.columns for record in read)]
    offset = BEGIN
    with BagWriter(bag, names, 'mcap') as writer:
        for record in read:
            time = record['time']
            for k, stamp in enumerate((offset + time - time[0]).tolist()):
                for name in names:
                    if np.isfinite(record[name][k]):
                        writer.write(name, float(record[name][k]), round(NANOSECONDS * stamp))
            offset += float(time[-1] - time[0] + np.median(np.diff(time)))


def messages(bag: Path) -> Iterator[tuple[int, str, float]]:
    """Yield stamp (ns), topic and value of what a bag holds, in order."""
    types = get_typestore(Stores.ROS2_JAZZY)
    with Reader(bag) as reader:
        for connection, stamp, raw in reader.messages():
            message: Any = types.deserialize_cdr(raw, connection.msgtype)
            yield stamp, connection.topic.lstrip('/'), float(message.data)


class Player(Node):
    """Plays a bag and its clock, and hears what the twin says."""

    def __init__(self, context: Context, names: Sequence[str]) -> None:
        super().__init__('player', context=context)
        self._clock_topic = self.create_publisher(Clock, '/clock', 10)
        self._topics = {name: self.create_publisher(Float64, name, 10) for name in names}
        self.alarms: list[tuple[float, str]] = []
        """When alarms came, s of the bag, and what they say."""
        self.health = ''
        self.left: dict[str, list[float]] = {}
        """What the model leaves, by channel."""
        self._now = 0.0
        self.create_subscription(String, 'twin/alarm', self._on_alarm, LATCHED)
        self.create_subscription(DiagnosticArray, 'twin/residuals', self._on_residuals, 10)
        self.create_subscription(DiagnosticArray, '/diagnostics', self._on_diagnostics, 10)

    def _on_alarm(self, message: String) -> None:
        self.alarms.append((self._now, message.data))

    def _on_residuals(self, message: DiagnosticArray) -> None:
        for status in message.status:
            values = {one.key: float(one.value) for one in status.values}
            self.left.setdefault(status.name, []).append(values['reading'] - values['predicted'])

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        self.health = next((one.message for one in message.status if one.name == 'twin: valve'), '')

    def tick(self, stamp: int) -> None:
        """Let it be so late, ns."""
        self._now = stamp / NANOSECONDS - BEGIN
        seconds, rest = divmod(stamp, NANOSECONDS)
        self._clock_topic.publish(Clock(clock=Time(sec=int(seconds), nanosec=int(rest))))

    def say(self, topic: str, value: float) -> None:
        """Publish a value."""
        self._topics[topic].publish(Float64(data=value))


def play(bag: Path, parameters: dict[str, object]) -> Player:
    """Play a bag to a twin with these parameters, as fast as it goes; return what was heard."""
    domain = claim_domain()
    context = Context()
    rclpy.init(args=[], context=context, domain_id=domain.id)
    executor = SingleThreadedExecutor(context=context)
    twin = TwinNode(context=context, parameter_overrides={**parameters, 'use_sim_time': True})
    played = list(messages(bag))
    player = Player(context, list(dict.fromkeys(topic for _, topic, _ in played)))
    for node in (twin, player):
        executor.add_node(node)

    try:
        turned = now = 0
        for stamp, topic, value in played:
            if stamp > now:
                now = stamp
                player.tick(stamp)
                handle_waiting(executor)
            player.say(topic, value)
            handle_waiting(executor)
            if stamp - turned >= TURN * NANOSECONDS:
                turned = stamp
                twin.turn()
                handle_waiting(executor)
        twin.report()
        handle_waiting(executor)
    finally:
        executor.shutdown()
        for node in (twin, player):
            node.destroy_node()
        context.try_shutdown()
        domain.release()
    return player


def main(arguments: list[str] | None = None) -> int:
    """Play what was given, and print what the twin says."""
    parser = argparse.ArgumentParser(prog='twin_replay', description='Play records to a twin.')
    parser.add_argument('records', type=Path, nargs='+')
    parser.add_argument('--params', required=True, help='parameter file of the model')
    parser.add_argument('-p', dest='given', action='append', default=[], metavar='NAME:=VALUE')
    given = parser.parse_args(arguments)
    parameters = {name: yaml.safe_load(value)
                  for name, _, value in (one.partition(':=') for one in given.given)}
    with tempfile.TemporaryDirectory() as folder:
        bag = Path(folder) / 'bag'
        write_bag(given.records, bag)
        heard = play(bag, {'model': given.params, **parameters})
    for name, left in heard.left.items():
        print(f'{name}: the model misses {np.sqrt(np.nanmean(np.square(left))):.3g} '
              f'({len(left)} readings)')
    for moment, sentence in heard.alarms:
        print(f'{moment:.0f} s: {sentence}')
    print(f'{len(heard.alarms)} alarms; in the end: {heard.health}')
    return 0


if __name__ == '__main__':
    sys.exit(main())
