# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Orders on the side of a worker, in the process that carries them out."""

from __future__ import annotations

from collections.abc import Mapping
import importlib
import threading
from typing import Any

_stops: dict[str, threading.Event] = {}


def carried_out(run: str, function: str, values: Mapping[str, Any]) -> Any:
    """
    Carry out an order of a run and return what came of it.

    `function` is named by its module and its name, 'booster_ros.fleet.work:diagnosed'. It is called
    with `values` and with an event that `stop_run` sets.
    """
    module, _, name = function.partition(':')
    stop = _stops.setdefault(run, threading.Event())
    return getattr(importlib.import_module(module), name)(values, stop)


def stop_run(run: str) -> None:
    """Tell the orders of a run that this process carries out to end."""
    _stops.setdefault(run, threading.Event()).set()
