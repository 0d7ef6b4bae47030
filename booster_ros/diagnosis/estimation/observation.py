# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Observation models: what of a record a fit is made to meet.

`ROWS` is every reading. `WINDOWS` are statistics of windows of a second: the mean of each, and the
logarithm of the variance of what moves within it. A stem that sticks slips at moments that hang on
the last digits of its friction. Single readings then say little, and their sum of squares is rough;
the statistics say how much friction there is and how far slips go, and are smooth (a synthetic
likelihood: S. N. Wood, Nature 466 (2010) 1102).

Both take what the model leaves of the readings, in standard deviations of the noise, channel by
channel, and return what a fit minimises the squares of.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from booster_ros.diagnosis.estimation.window_statistics import Windows

Array = np.ndarray


class Observation(Protocol):
    """What of the readings counts; `visible` is the change of it that shows above its roughness."""

    @property
    def name(self) -> str:
        """What plain data call it by."""

    @property
    def visible(self) -> float:
        """The change of the residuals (norm) that a difference has to make."""

    def of(self, windows: Sequence[Windows], scaled: Sequence[Array]) -> list[Array]:
        """Return the residuals of each channel, from the scaled residuals of its rows."""

    def first_rows(self, windows: Windows) -> list[Array]:
        """
        Return of each series of a channel's residuals the first of the counted rows each is from.

        Within a series residuals may be autocorrelated; means and strengths are a series each.
        """


@dataclass(frozen=True)
class _Rows:
    """Every reading counts by itself."""

    name: str = 'rows'
    visible: float = 1.0

    def of(self, windows: Sequence[Windows], scaled: Sequence[Array]) -> list[Array]:
        return list(scaled)

    def first_rows(self, windows: Windows) -> list[Array]:
        return [np.arange(len(windows.time))]


@dataclass(frozen=True)
class _WindowStatistics:
    """Means and logarithms of variances of windows count."""

    name: str = 'windows'
    visible: float = 100.0

    def of(self, windows: Sequence[Windows], scaled: Sequence[Array]) -> list[Array]:
        return [np.concatenate([one.means(each), one.strengths(each)])
                for one, each in zip(windows, scaled)]

    def first_rows(self, windows: Windows) -> list[Array]:
        return [windows.first, windows.first[windows.told]]


ROWS: Observation = _Rows()
WINDOWS: Observation = _WindowStatistics()
