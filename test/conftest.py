# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Keep each test process in a ROS domain of its own on this machine."""

from __future__ import annotations

from collections.abc import Iterator
import os
from typing import TYPE_CHECKING

import pytest

from booster_ros.programs.ros_domain import claim_domain

if TYPE_CHECKING:
    from ros_client import RosClient

# Before anything initialises rclpy; kept for as long as the process lives.
_DOMAIN = claim_domain()
os.environ['ROS_DOMAIN_ID'] = str(_DOMAIN.id)
os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
# Programs under test must not open windows, nor colour what they print.
os.environ['MPLBACKEND'] = 'Agg'
os.environ['RCUTILS_COLORIZED_OUTPUT'] = '0'


def pytest_unconfigure() -> None:
    """Give the domain back."""
    _DOMAIN.release()


@pytest.fixture(scope='session')
def ros_domain() -> int:
    """Return the domain id of this test process (clients other than rclpy must be told)."""
    return _DOMAIN.id


@pytest.fixture
def ros_client() -> Iterator[RosClient]:
    """Return a node inside the test."""
    from ros_client import RosClient  # here, so that tests of the model need no ROS

    with RosClient() as client:
        yield client
