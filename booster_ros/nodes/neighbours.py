# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Other nodes that get in a positioner's way: namesakes, second publishers, deaf commands."""

from collections.abc import Sequence

from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSCompatibility, qos_check_compatible
from rclpy.subscription import Subscription
from rclpy.topic_endpoint_info import TopicEndpointInfo


class Neighbours:
    """Looks at the graph for what keeps commands and outputs from being what they seem."""

    def __init__(
        self, node: Node, commands: Subscription, outputs: Sequence[Publisher]
    ) -> None:
        self._node = node
        self._commands = commands
        self._outputs = outputs
        self.trouble: list[str] = []
        """What was in the way at the last look, one sentence each."""

    def look(self) -> list[str]:
        """Look again, and return the sentences that are new."""
        before = self.trouble
        self.trouble = [*self._namesakes(), *self._second_publishers(), *self._deaf_commands()]
        return [sentence for sentence in self.trouble if sentence not in before]

    def _namesakes(self) -> list[str]:
        node = self._node
        own = (node.get_name(), node.get_namespace())
        if node.get_node_names_and_namespaces().count(own) < 2:
            return []
        return [f'another node is called {node.get_fully_qualified_name()} too: parameters and '
                'services reach one of them only (give one another name or namespace)']

    def _second_publishers(self) -> list[str]:
        found = []
        for publisher in self._outputs:
            infos = self._node.get_publishers_info_by_topic(publisher.topic_name)
            if len(infos) > 1:
                names = ', '.join(sorted(map(_name, infos)))
                found.append(f'several publish {publisher.topic_name} ({names}): who listens '
                             'gets a mixture')
        return found

    def _deaf_commands(self) -> list[str]:
        found = []
        own = self._commands.qos_profile
        for info in self._node.get_publishers_info_by_topic(self._commands.topic_name):
            compatible, reason = qos_check_compatible(info.qos_profile, own)
            if compatible == QoSCompatibility.ERROR:
                found.append(
                    f'the commands of {_name(info)} do not arrive, their QoS does not fit: '
                    f'{reason.strip().removeprefix("ERROR: ").rstrip(";")}')
        return sorted(found)


def _name(info: TopicEndpointInfo) -> str:
    return f'{info.node_namespace.rstrip("/")}/{info.node_name}'
