# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Names of joints and frames, which must be unique among the valves of a plant."""

from rclpy.node import Node


def own_name(node: Node, given: str, base: str) -> str:
    """Return the name that was given, or else `base` behind the namespace of the node."""
    return given or '_'.join([*filter(None, node.get_namespace().split('/')), base])
