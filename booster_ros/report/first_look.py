# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A page with all columns of a file over time, before anything is made of them."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from booster_ros.report.interactive import series_over_time
from booster_ros.report.markup import bullets
from booster_ros.report.panels import Panels
from booster_ros.report.templating import plot, plot_library, rendered

Array = np.ndarray

_MOST = 40
"""Most columns that are drawn."""


class Series(NamedTuple):
    """A column to draw: what it is called and its values, NaN where there is none."""

    label: str
    values: Array


def first_look(title: str, time: Array | None, series: Sequence[Series], notes: Sequence[str]
               ) -> str:
    """Return the page: each series over time, s, or over the number of the row without it."""
    shown = list(series)[:_MOST]
    left = [f'{len(series) - _MOST} more columns are not drawn'] if len(series) > _MOST else []
    return rendered(
        'look.html', title=title, notes=bullets([*notes, *left]), library=plot_library(),
        drawing=plot(_figure(time, shown), 'look', f'All columns of {title}') if shown else '')


def _figure(time: Array | None, series: Sequence[Series]) -> Panels:
    x = np.arange(len(series[0].values), dtype=float) if time is None else time
    known = np.flatnonzero(np.isfinite(x))
    known = known[np.argsort(x[known], kind='stable')]
    return series_over_time(x[known], [(one.label, one.values[known]) for one in series],
                            'row' if time is None else 'time, s')
