# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The valves of a fleet, side by side."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict

from ..running.on_dask import run_orders
from .outcome import FAILED, Outcome
from .work import Order


def run_fleet(
    orders: Sequence[Order], scheduler: str, jobs: int, tell: Callable[[Outcome], None],
    check: Callable[[], None],
) -> None:
    """Diagnose valves as `run_orders` says; one whose worker failed has an outcome as well."""
    by_valve = {order.valve.name: order for order in orders}

    def fail(name: str, why: str) -> None:
        tell(Outcome(name, by_valve[name].inputs, by_valve[name].state, FAILED, why))

    run_orders('booster_ros.fleet.work:diagnosed',
               {name: asdict(order) for name, order in by_valve.items()}, scheduler, jobs, tell,
               fail, check)
