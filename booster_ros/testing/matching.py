# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Whether two nodes have found each other: before that, messages are lost."""

import time

from rclpy.node import Node

PATIENCE = 10.0
"""Seconds of real time in which nodes of one machine find each other."""


def wait_for_match(one: Node, another: Node) -> None:
    """
    Wait until each publisher of one has found each subscription of the other, both ways.

    AssertionError if they share no topic, or do not find each other.
    """
    end = time.monotonic() + PATIENCE
    shared = _shared(one, another) + _shared(another, one)
    assert shared, (
        f'{another.get_fully_qualified_name()} shares no topic with '
        f'{one.get_fully_qualified_name()}: are both in one namespace?')
    while any(not publisher.get_subscription_count() or not subscription.get_publisher_count()
              for publisher, subscription in shared):
        assert time.monotonic() < end, (
            f'{another.get_fully_qualified_name()} and {one.get_fully_qualified_name()} do not '
            'find each other: do types and QoS of their topics fit?')
        time.sleep(0.001)


_ANYBODYS = ('/rosout', '/parameter_events', '/clock', '/diagnostics')


def _shared(sender: Node, receiver: Node) -> list:
    return [
        (publisher, subscription) for publisher in sender.publishers
        for subscription in receiver.subscriptions
        if publisher.topic_name == subscription.topic_name
        and publisher.topic_name not in _ANYBODYS]
