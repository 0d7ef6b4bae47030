# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The responses to steps as a short table."""

from collections.abc import Sequence

from .step_response import StepResponse

NOT_TOLD = '-'


def table_of_steps(steps: Sequence[StepResponse], travel: float) -> str:
    """Return dead time, T63, T86 and overshoot of each step, a column each; `travel` in m."""
    rows = [('step', '% of travel', [f'{100.0 * one.size / travel:+.1f}' for one in steps])]
    for name, values in (
        ('dead time', [one.dead_time for one in steps]),
        ('T63', [one.t63 for one in steps]),
        ('T86', [one.t86 for one in steps]),
    ):
        rows.append((name, 's', [_told(value, 2) for value in values]))
    rows.append(('overshoot', '% of step', [
        _told(None if one.overshoot is None else 100.0 * one.overshoot, 1) for one in steps]))
    return '\n'.join(
        f'{name:24}{unit:12}' + ''.join(f'{value:>10}' for value in values)
        for name, unit, values in rows)


def _told(value: float | None, digits: int) -> str:
    return NOT_TOLD if value is None else f'{value:.{digits}f}'
