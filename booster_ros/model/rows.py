# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a simulation is given, checked once for all rows: one NaN would be in all that follows."""

from collections.abc import Iterable, Mapping
import math
from typing import NamedTuple

import numpy as np

from .state import STATE_NAMES


class Rows(NamedTuple):
    """Time (s), command and pinned states (SI, by name), finite, of shape (n,), n > 0."""

    time: np.ndarray
    command: np.ndarray
    pinned: dict[str, np.ndarray]


def checked_rows(
    time: np.ndarray, command: np.ndarray, pinned: Mapping[str, np.ndarray] | None,
    command_name: str = 'control_current',
) -> Rows:
    """
    Return rows that a simulation may run over; `command_name` is what a complaint calls a command.

    ValueError where shapes differ, there is no such state, a value is not finite or time falls.
    """
    t = np.ascontiguousarray(time, dtype=float)
    commands = np.ascontiguousarray(command, dtype=float)
    if t.ndim != 1 or t.shape != commands.shape or len(t) == 0:
        raise ValueError(
            f'time and {command_name} must be equally long, one-dimensional, not empty')
    held = {name: np.asarray(series, dtype=float) for name, series in (pinned or {}).items()}
    check_states('pinned', held)
    for name, series in held.items():
        if series.shape != t.shape:
            raise ValueError(
                f'pinned {name} must have a value for each of the {len(t)} rows, got the shape '
                f'{series.shape}')
    for name, series in (('time', t), (command_name, commands), *held.items()):
        finite = np.isfinite(series)
        if not finite.all():
            row = int(np.argmin(finite))
            check_finite(f'{name}[{row}]', float(series[row]))
    if not np.all(np.diff(t) >= 0.0):
        raise ValueError('time must not fall from row to row')
    return Rows(t, commands, held)


def check_states(role: str, names: Iterable[str]) -> None:
    """Raise ValueError where a name of what is given in this `role` is not that of a state."""
    for name in names:
        if name not in STATE_NAMES:
            raise ValueError(
                f'{role}: there is no state {name}; there are {", ".join(STATE_NAMES)}')


def check_finite(name: str, value: float) -> None:
    """Raise ValueError where a value is NaN or infinite."""
    if not math.isfinite(value):
        raise ValueError(f'{name} must be finite, got {value}')


def check_positive(name: str, value: float) -> None:
    """Raise ValueError where a value is not greater than zero."""
    if not value > 0.0:
        raise ValueError(f'{name} must be positive, got {value}')
