# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Table III beside the same indices of our own step responses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from .indices import StepIndices
from .printed import PrintedIndex

LABELS = {
    'final_pressure': 'final pressure',
    'rise_time_10_90': 'rise time, 10 to 90 %',
    'settling_time_5_percent': 'settling time, 5 %',
    'integral_square_error': 'integral square error',
}


def comparison(played: Sequence[StepIndices], printed: Mapping[str, PrintedIndex]) -> str:
    """Return Table III with a column for each played step, and how far the mean is off."""
    steps = ''.join(f'{f"step {number}":>10}' for number in range(1, len(played) + 1))
    lines = [
        f'{"Table III":32}{"the paper":>20}{" booster_ros":>{10 * len(played)}}',
        f'{"":32}{"measured":>10}{"simulated":>10}{steps}{"to simulated":>14}',
    ]
    for name, label in LABELS.items():
        row = printed[name]
        values = [getattr(indices, name) for indices in played]
        digits = 0 if row.simulated > 1e3 else 2 if row.simulated < 100 else 1
        cells = ''.join(f'{value:10.{digits}f}' for value in [row.measured, row.simulated, *values])
        off = sum(values) / len(values) / row.simulated - 1.0
        lines.append(f'{label:24}{row.unit:8}{cells}{off:+14.2%}')
    return '\n'.join(lines)
