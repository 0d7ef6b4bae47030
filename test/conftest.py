# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Keep each test process in a ROS domain of its own on this machine, and tell tests with nodes."""

from __future__ import annotations

from collections.abc import Iterator
import functools
import gc
import os
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

import pytest

from booster_ros.model import compiled
from booster_ros.programs.ros_domain import claim_domain

if TYPE_CHECKING:
    from ros_client import RosClient

# Before anything initialises rclpy; kept for as long as the process lives.
_DOMAIN = claim_domain()
os.environ['ROS_DOMAIN_ID'] = str(_DOMAIN.id)
# Processes that tests kill leave their shared memory as it is; this one, which outlives them all,
# keeps away from it, and says by itself that it talks to this machine alone: the discovery range
# LOCALHOST brings shared memory with it. What it starts is as users have it (`RosProcess`).
os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'SYSTEM_DEFAULT'
# Fast DDS reads the second of these variables from version 3 on, the first until then.
for _NAME in ('FASTRTPS_DEFAULT_PROFILES_FILE', 'FASTDDS_DEFAULT_PROFILES_FILE'):
    os.environ[_NAME] = str(Path(__file__).with_name('fastdds_here.xml'))
# Programs under test must not open windows, nor colour what they print.
os.environ['MPLBACKEND'] = 'Agg'
os.environ['RCUTILS_COLORIZED_OUTPUT'] = '0'


def pytest_unconfigure() -> None:
    """Give the domain back."""
    _DOMAIN.release()


WITH_NODES = {'rclpy', 'ros_client', 'ros_process', 'positioner_here', 'positioner_process'}
"""Modules by whose functions and classes tests start nodes."""


@functools.cache
def starts_nodes(module: ModuleType) -> bool:
    """Tell whether a file of tests takes anything from the modules that start nodes."""
    homes = (value.__name__ if isinstance(value, ModuleType) else getattr(value, '__module__', '')
             for value in vars(module).values())
    return any(str(home).partition('.')[0] in WITH_NODES for home in homes)


LONG = (
    'test_fake_controller', 'test_positioner_node', 'test_positioner_time',
    'test_positioner_set_points', 'test_docs_testing', 'test_stepwise', 'test_loop_closed',
    'test_campaign', 'test_twin_node_answers', 'test_fleet_run', 'test_demo', 'test_close_loop',
    'test_html_report', 'test_twin_answers', 'test_model_limits', 'test_hidden_plant')
"""
Files that take long, these first: what comes last would keep one of several cores busy alone.

The first five need no machine code: where the model is not compiled yet, that is a minute's work,
which `make test` does meanwhile, and who needs it waits for it.
"""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark each test as one that starts nodes or one that does not; put the longest files first."""
    for item in items:
        if isinstance(item, pytest.Function) and not item.get_closest_marker('linter'):
            item.add_marker('ros' if starts_nodes(item.module) else 'unit')
    place = {name: number for number, name in enumerate(LONG)}
    items.sort(key=lambda item: place.get(item.path.stem, len(LONG)))


def pytest_collection_finish() -> None:
    """Refuse files that run the model as they are imported: all processes would compile it."""
    if compiled.compiled_modules.cache_info().currsize:
        raise pytest.UsageError('a file of tests runs the model while it is imported, and each of '
                                'several processes would compile it; let a test or a fixture do it')
    gc.freeze()  # what is loaded stays, and need not be looked through again and again


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
