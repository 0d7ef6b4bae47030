# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which variable of the model explains a residual best."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

Array = np.ndarray

_MOST_BINS = 20
_ROWS_PER_BIN = 8

WORTH_SHOWING = 0.1
"""Share of the variance below which a variable explains nothing that an eye would see."""


@dataclass(frozen=True)
class Explanation:
    """A variable and the share of a residual's variance that its binned mean explains."""

    variable: str
    share: float


def best_explanation(residual: Array, variables: Mapping[str, Array]) -> Explanation | None:
    """
    Return the variable over which the residual has the clearest mean curve (correlation ratio).

    Return None where no variable explains a share that is worth a picture. The variable is for the
    axis of a picture, not a test: which effect it is has been decided by fits.
    """
    found = [Explanation(name, explained_share(residual, values))
             for name, values in variables.items()]
    found = [one for one in found if one.share >= WORTH_SHOWING]
    return max(found, key=lambda one: one.share) if found else None


def explained_share(residual: Array, variable: Array) -> float:
    """Return the share of variance between bins of equally many rows; NaN if one is constant."""
    known = np.isfinite(residual) & np.isfinite(variable)
    residual, variable = residual[known], variable[known]
    if len(residual) < 3 * _ROWS_PER_BIN or np.ptp(variable) == 0.0 or np.ptp(residual) == 0.0:
        return float('nan')
    middles, means, counts = binned_mean(variable, residual)
    if len(middles) < 2:
        return float('nan')
    between = float(np.sum(counts * (means - residual.mean()) ** 2))
    return between / float(np.sum((residual - residual.mean()) ** 2))


def binned_mean(x: Array, y: Array) -> tuple[Array, Array, Array]:
    """Return middle, mean and count of bins of x that hold about equally many finite points."""
    known = np.isfinite(x) & np.isfinite(y)
    x, y = x[known], y[known]
    bins = min(_MOST_BINS, len(x) // _ROWS_PER_BIN)
    edges = np.unique(np.quantile(x, np.linspace(0.0, 1.0, bins + 1))) if bins else x[:0]
    if len(edges) < 2:
        return np.array([]), np.array([]), np.array([])
    place = np.clip(np.searchsorted(edges, x, side='right') - 1, 0, len(edges) - 2)
    counts = np.bincount(place, minlength=len(edges) - 1)
    full = counts > 0
    sums_x, sums_y = (np.bincount(place, v, minlength=len(edges) - 1)[full] for v in (x, y))
    return sums_x / counts[full], sums_y / counts[full], counts[full]
