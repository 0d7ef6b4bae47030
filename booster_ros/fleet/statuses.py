# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Statuses after NAMUR NE 107, from the verdict on a valve by one table.

| verdict | standing | status |
|---|---|---|
| a channel stands still from some moment on | | failure |
| it changed on the way, and nothing is missing since | | out of specification |
| unknown: something is missing that has no name | confirmed, likely | out of specification |
| effect: a cause with a name | confirmed, likely | maintenance |
| effect or unknown | candidate | check |
| no answer: the record was refused, or took too long | | check |
| none | | good |

What is missing in one valve, but not kept at the false-discovery rate of the plant, is 'good' as
well: the table of the fleet has it, and raises no alarm.
"""

from __future__ import annotations

FAILURE, OUT_OF_SPECIFICATION, MAINTENANCE, CHECK, GOOD = (
    'failure', 'out of specification', 'maintenance', 'check', 'good')

ORDER = (FAILURE, OUT_OF_SPECIFICATION, MAINTENANCE, CHECK, GOOD)
"""What needs attention first."""

SILENT, CHANGED, UNKNOWN, EFFECT, NONE, NO_ANSWER = (
    'silent', 'changed', 'unknown', 'effect', 'none', 'no answer')

_BY_KIND = {
    SILENT: FAILURE, CHANGED: OUT_OF_SPECIFICATION, UNKNOWN: OUT_OF_SPECIFICATION,
    EFFECT: MAINTENANCE, NONE: GOOD, NO_ANSWER: CHECK}


def status_of(kind: str, standing: str, kept: bool) -> str:
    """Return the status; `kept` tells whether the false-discovery rate of the plant keeps it."""
    if kind in (EFFECT, UNKNOWN):
        if not kept:
            return GOOD
        if standing == 'candidate':
            return CHECK
    return _BY_KIND[kind]
