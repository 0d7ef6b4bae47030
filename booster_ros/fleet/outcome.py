# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What came of a valve, and the file in which it is kept."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
import json
from pathlib import Path
from typing import Any

from .false_discovery import LEAST, log_e_value
from .manifest import FleetError
from .statuses import CHANGED, NO_ANSWER, NONE, SILENT

NAME = 'valves.jsonl'

ANSWERED, REFUSED, FAILED, TIMEOUT = 'answered', 'refused', 'failed', 'timeout'
"""Refused is by a sentence on the input; failed is all else, such as a worker that died."""


@dataclass(frozen=True)
class Outcome:
    """
    What came of a valve.

    `inputs` and `state` identify its files and the program. `kind` is as in `statuses`;
    `misfit` the largest ratio of the held-out error of the refitted declared model to the noise,
    `left` that of what was chosen; None where there is no answer.
    """

    valve: str
    inputs: str
    state: str
    ended: str
    message: str = ''
    seconds: float = 0.0
    cpu_seconds: float = 0.0
    kind: str = NO_ANSWER
    effects: tuple[str, ...] = ()
    location: str = ''
    standing: str = ''
    explained: float | None = None
    misfit: float | None = None
    left: float | None = None
    log_e: float = LEAST
    summary: str = ''

    @property
    def answered(self) -> bool:
        """Tell whether the diagnosis came to a verdict."""
        return self.ended == ANSWERED


def answer_of(report: Mapping[str, Any]) -> dict[str, Any]:
    """Return what an outcome has of a report; KeyError or TypeError where it is none."""
    effects = report['effects']
    change = report['change']
    kind = report['verdict']
    if change and change['silent']:
        kind = SILENT
    elif kind == NONE and change and change['cut']:
        kind = CHANGED
    standings = [one['standing'] for one in effects]
    return {
        'kind': kind, 'effects': tuple(one['name'] for one in effects),
        'location': ', '.join(dict.fromkeys(one['location'] for one in effects)),
        'standing': next((one for one in ('confirmed', 'likely', 'candidate') if one in standings),
                         ''),
        'explained': _sum([one['explained'] for one in effects]),
        'misfit': _ratio(report['held_out'], 'before'), 'left': _ratio(report['held_out'], 'after'),
        'log_e': log_e_value(report['trace']), 'summary': report['summary']}


def _sum(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return sum(known) if known else None


def _ratio(errors: Mapping[str, Any], stage: str) -> float | None:
    return max((one[stage] / one['noise'] for one in errors.values()
                if one[stage] is not None and one['noise']), default=None)


def read_outcomes(folder: Path) -> dict[str, Outcome]:
    """Return the outcomes in a folder by valve, the last of each; none where it has not begun."""
    path = folder / NAME
    if not path.exists():
        return {}
    whole, _, _ = path.read_text(encoding='utf-8').rpartition('\n')
    try:
        found = [json.loads(line) for line in whole.splitlines()]
        return {one['valve']: Outcome(**{**one, 'effects': tuple(one['effects'])})
                for one in found}
    except (KeyError, TypeError, ValueError):
        raise FleetError(f'{path}: is not a file of outcomes') from None


def line_of(outcome: Outcome) -> str:
    """Return an outcome as a line of the file."""
    return json.dumps(asdict(outcome), ensure_ascii=False) + '\n'
