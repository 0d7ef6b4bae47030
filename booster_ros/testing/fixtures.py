# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Fixtures for pytest: name this module in `pytest_plugins`.

    pytest_plugins = ['booster_ros.testing.fixtures']
"""

from collections.abc import Callable, Generator, Iterator, Mapping
from contextlib import ExitStack
from typing import Any

import pytest

from .remote_valve import RemoteValve
from .valve import Valve

LOGS = pytest.StashKey[list[RemoteValve]]()
"""Valves in other processes, whose logs are shown where a test fails."""


@pytest.fixture
def valve() -> Iterator[Valve]:
    """Return a positioner with the default parameters, in the process of the test."""
    with Valve() as made:
        yield made


@pytest.fixture
def make_valve() -> Iterator[Callable[..., Valve]]:
    """Return a function that makes positioners with other parameters, by dotted name."""
    with ExitStack() as valves:
        def make(parameters: Mapping[str, Any] | None = None, **options: Any) -> Valve:
            return valves.enter_context(Valve(parameters, **options))
        yield make


@pytest.fixture
def find_valve(request: pytest.FixtureRequest) -> Iterator[Callable[..., RemoteValve]]:
    """Return a function that finds a positioner in another process by its full name."""
    found = request.node.stash.setdefault(LOGS, [])
    with ExitStack() as valves:
        def find(name: str = '/positioner', **options: Any) -> RemoteValve:
            found.append(valves.enter_context(RemoteValve(name, **options)))
            return found[-1]
        yield find


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Show what nodes in other processes have logged, where a test fails."""
    report = yield
    if report.failed:
        for one in item.stash.get(LOGS, []):
            report.sections.append((f'Log of {one.name}', '\n'.join(one.collect_log())))
    return report
