# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Observation models: what of a record a fit is made to meet.

`ROWS` is every reading. `WINDOWS` are statistics of windows of a second: the mean of each, and the
logarithm of the variance of what moves within it. When a stem slips hangs on the last digits of its
friction: single readings say little of it, and roughly; the statistics say how much friction there
is and how far slips go (a synthetic likelihood: S. N. Wood, Nature 466 (2010) 1102).

Both take what the model leaves of a channel's readings, in standard deviations of the noise, and
return what a fit minimises the squares of.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from booster_ros.diagnosis.data.experiment import Array
from booster_ros.signals.window_statistics import Windows


class Steps(NamedTuple):
    """Length of differences in z: they change residuals by `change` (norm), or are `most`."""

    change: float
    most: float


@dataclass(frozen=True, eq=False)
class Observation:
    """
    What of the readings of a channel counts.

    `of` makes its residuals of the scaled residuals of its rows, in series, of which `first_rows`
    are the counted rows each begins with. `steps` are those of a fit's differences, `last` those
    along the axes at its end; a fit to the very end goes on by `finer` ones. A `summary` of the
    readings says as much on thinned rows as on all, and bends too much for slopes to lead far.
    """

    name: str
    of: Callable[[Windows, Array], Array] = field(repr=False)
    first_rows: Callable[[Windows], list[Array]] = field(repr=False)
    steps: Steps
    last: Steps
    finer: tuple[Steps, ...] = ()
    summary: bool = False


ROWS = Observation('rows', lambda windows, scaled: windows.white(scaled),
                   lambda windows: [np.arange(len(windows.time))], Steps(1.0, 0.1), Steps(1.0, 0.1))
"""Every reading counts, by itself where none of its noise is chance."""

WINDOWS = Observation(
    'windows', lambda windows, scaled: np.append(windows.means(scaled), windows.strengths(scaled)),
    lambda windows: [windows.first, windows.first[windows.told]], Steps(100.0, 0.1),
    Steps(300.0, 0.3), finer=(Steps(30.0, 0.1), Steps(10.0, 0.1)), summary=True)
"""Means and logarithms of variances of windows count; slips make them rough on short ways: one slip
in another window is hundreds, and the next minimum over stiction some 0.1 away. Slopes that tell
how sure a fit is are over several of both, else they are those of the minimum that it ended in."""
