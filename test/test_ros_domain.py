# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Domains of test processes and demos that run at the same time do not meet."""

import os
import subprocess
import sys

import pytest
import rclpy
from rclpy.context import Context

from booster_ros.programs.ros_domain import claim_domain

CLAIM_AND_WAIT = """
from booster_ros.programs.ros_domain import claim_domain
claimed = [claim_domain() for _ in range(10)]  # held on to: a claim ends with its object
print(*(domain.id for domain in claimed), flush=True)
input()
"""


def test_claims_of_one_process_differ():
    claimed = [claim_domain() for _ in range(20)]
    try:
        assert len({domain.id for domain in claimed}) == 20
    finally:
        for domain in claimed:
            domain.release()


def test_claims_of_several_processes_differ_and_end_with_them():
    ids = [int(os.environ['ROS_DOMAIN_ID'])]
    others = [
        subprocess.Popen(
            [sys.executable, '-c', CLAIM_AND_WAIT],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        for _ in range(4)
    ]
    ids += [int(domain) for other in others for domain in other.stdout.readline().split()]
    for other in others:
        other.communicate('\n')
    assert len(ids) == 41
    assert len(set(ids)) == 41
    claim_domain(among=ids[1:]).release()


def test_a_domain_in_which_a_participant_listens_is_not_claimed():
    domain = claim_domain()
    domain.release()
    context = Context()
    rclpy.init(context=context, domain_id=domain.id)
    try:
        listener = rclpy.create_node('listener', context=context)
        with pytest.raises(RuntimeError, match=f'{domain.id}'):
            claim_domain(among=[domain.id])
        listener.destroy_node()
    finally:
        context.try_shutdown()
    claim_domain(among=[domain.id]).release()


def test_the_process_of_the_tests_shares_no_memory(ros_client):
    """What processes that are killed leave of it may end this one."""
    with open('/proc/self/maps') as maps:
        assert not [line for line in maps if '/dev/shm/fast' in line]
