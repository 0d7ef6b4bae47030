# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a block of residuals is summarised by: by channel a few numbers, and an operating cell."""

from collections.abc import Mapping, Sequence
from statistics import mode
from typing import Any, NamedTuple

import numpy as np

Array = np.ndarray

LEVEL, REVERSAL, SPREAD = 'level', 'reversal', 'spread'
KINDS = (LEVEL, REVERSAL, SPREAD)

FEWEST_ROWS = 16
"""Rows with a residual that a block must have to be summarised."""

SIDE = 0.1
"""Share of a block's rows that must go up, and down, for a difference between the two."""

MOVES = 0.002
"""Share of the span per second beyond which a channel moves up or down."""

ACTIVITIES = (0.02, 0.5)
"""Ways gone in a block, as shares of the span, between little, some and much motion."""

THIRDS = 3


class Summary(NamedTuple):
    """
    A block: where it begins and ends (s), cells by channel, and numbers by (channel, kind).

    A cell is told by what the model says of the same channel, which a fault of that part does not
    move: else a large fault would be taken for an operating point that is new.
    """

    begin: float
    end: float
    cells: dict[str, tuple[int, int]]
    numbers: dict[tuple[str, str], float]

    def as_values(self) -> list[Any]:
        """Return it as plain values, for `restored`."""
        return [self.begin, self.end, {name: list(cell) for name, cell in self.cells.items()},
                [[*name, number] for name, number in self.numbers.items()]]

    @classmethod
    def restored(cls, values: Sequence[Any]) -> 'Summary':
        """Return the summary that `as_values` told of."""
        begin, end, cells, numbers = values
        return cls(begin, end, {name: (third, way) for name, (third, way) in cells.items()},
                   {(channel, kind): number for channel, kind, number in numbers})


def summary(
    time: Array, said: Mapping[str, Array], left: Mapping[str, Array], spans: Mapping[str, float],
) -> Summary | None:
    """
    Return the summary of a block; None where no channel has enough residuals.

    `said` are the predictions, `left` the residuals, shape (n,) each; `spans` are the travel, m,
    and the supply pressure, Pa. Numbers:

    level     mean of the residual, as a share of the span (bias, leak, spring, gain)
    reversal  half of: mean while the valve goes up less mean while it goes down, as a share of the
              span (friction, backlash, dead band); missing where it does not go both ways
    spread    logarithm of the standard deviation about the mean (stick-slip, hunting, lags)

    The cell is the third of the range that the predicted channel is in, and how far it went.
    """
    numbers: dict[tuple[str, str], float] = {}
    for name, residual in left.items():
        known = np.isfinite(residual)
        if np.count_nonzero(known) < max(FEWEST_ROWS, len(residual) // 2):
            continue
        share = residual[known] / spans[name]
        mean = float(np.mean(share))
        numbers[name, LEVEL] = mean
        numbers[name, SPREAD] = float(np.log(max(float(np.std(share)), 1e-9)))
        speed = np.gradient(said[name], time)[known] / spans[name]
        up, down = speed > MOVES, speed < -MOVES
        if min(np.count_nonzero(up), np.count_nonzero(down)) >= SIDE * len(share):
            numbers[name, REVERSAL] = 0.5 * float(np.mean(share[up]) - np.mean(share[down]))
    if not numbers:
        return None
    cells = {name: _cell(course / spans[name]) for name, course in said.items()}
    return Summary(float(time[0]), float(time[-1]), cells, numbers)


def _cell(said: Array) -> tuple[int, int]:
    """Return the operating cell of what is said of a channel, in shares of its span."""
    course = said[np.isfinite(said)]
    if not len(course):
        return 0, 0
    third = int(np.clip(THIRDS * np.mean(course), 0, THIRDS - 1))
    way = float(np.sum(np.abs(np.diff(course))))
    return third, int(np.searchsorted(ACTIVITIES, way))


def joined(blocks: list[Summary]) -> Summary:
    """Return several blocks as one: numbers averaged, of each channel the cell of most blocks."""
    names = dict.fromkeys(name for one in blocks for name in one.numbers)
    return Summary(
        blocks[0].begin, blocks[-1].end,
        {channel: mode(one.cells[channel] for one in blocks if channel in one.cells)
         for channel in dict.fromkeys(channel for one in blocks for channel in one.cells)},
        {name: float(np.mean([one.numbers[name] for one in blocks if name in one.numbers]))
         for name in names})
