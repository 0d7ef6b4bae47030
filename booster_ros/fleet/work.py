# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The diagnosis of one valve, a process of its own, wherever it runs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
import json
from pathlib import Path
import shutil
import sys
import threading
from typing import Any

from ..running.program import MODULE, PATH, Program
from ..surroundings import environment_with_package
from .manifest import Valve
from .outcome import ANSWERED, FAILED, REFUSED, TIMEOUT, Outcome, answer_of

REPORTS = 'valves'
"""Folder in that of the fleet with a folder for each valve."""

_REFUSED = 2


@dataclass(frozen=True)
class Order:
    """
    What is to be done of a valve, told to whoever does it; paths hold on all machines.

    `settings` are the variables by which libraries choose kernels and threads.
    """

    valve: Valve
    folder: Path
    out: Path
    options: tuple[str, ...]
    timeout: float
    inputs: str
    state: str
    settings: Mapping[str, str]


def diagnosed(values: Mapping[str, Any], stop: threading.Event) -> Outcome | None:
    """
    Run `close_loop` on a valve and return what came of it, None where `stop` ended it.

    `values` are those of an `Order`. It runs in the folder of the manifest, in a process that gives
    back all memory when it ends.
    """
    order = Order(**{**values, 'valve': Valve(**values['valve'])})
    kept = order.out / REPORTS / order.valve.name
    shutil.rmtree(kept, ignore_errors=True)
    variables = {**order.settings, PATH: environment_with_package()[PATH]}
    program = Program((sys.executable, '-m', MODULE), order.folder, Path(), '', variables)
    ended = program.run(
        'close_loop', [*order.valve.words(), *order.options, '--out', str(kept)], order.timeout,
        stop)
    if stop.is_set():
        return None

    def outcome(how: str, message: str = '', **answer: Any) -> Outcome:
        return Outcome(order.valve.name, order.inputs, order.state, how, message,
                       round(ended.seconds, 3), round(ended.cpu_seconds, 3), **answer)

    if ended.status is None:
        return outcome(TIMEOUT, f'no answer in {order.timeout:g} s')
    if ended.status:
        said = ended.said.removeprefix('close_loop: ')
        return outcome(REFUSED if ended.status == _REFUSED else FAILED,
                       said or f'close_loop ended with {ended.status}')
    try:
        report = json.loads((kept / 'report.json').read_text(encoding='utf-8'))
        return outcome(ANSWERED, **answer_of(report))
    except (OSError, ValueError, KeyError, TypeError) as error:
        return outcome(FAILED, f'report.json cannot be read: {error!r}')
