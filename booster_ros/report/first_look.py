# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A page with all columns of a file over time, before anything is made of them."""

from collections.abc import Sequence
from html import escape
from typing import NamedTuple

from matplotlib.figure import Figure
import numpy as np

from booster_ros.report.figure_style import MEASURED, blank, over_time, styled, svg
from booster_ros.report.markup import bullets, figure

Array = np.ndarray

_MOST = 40
_HEIGHT = 1.15
"""Most columns that are drawn, and the height of each in inches."""

_PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>
body {{ margin: 2rem auto; max-width: 60rem; padding: 0 1rem; color: #1d2329;
       font: 16px/1.5 system-ui, sans-serif; }}
h1 {{ font-size: 1.3rem; }} li {{ font-size: .875rem; }}
figure {{ margin: 1rem 0; overflow-x: auto; }}
figure svg {{ display: block; width: 100%; min-width: 34rem; height: auto; }}
</style>
</head>
<body>
<h1>{title}</h1>
{notes}
{drawing}
</body>
</html>
"""


class Series(NamedTuple):
    """A column to draw: what it is called and its values, NaN where there is none."""

    label: str
    values: Array


def first_look(title: str, time: Array | None, series: Sequence[Series], notes: Sequence[str]
               ) -> str:
    """Return the page: each series over time, s, or over the number of the row without it."""
    shown = list(series)[:_MOST]
    left = [f'{len(series) - _MOST} more columns are not drawn'] if len(series) > _MOST else []
    drawing = ''
    if shown:
        with styled():
            drawing = figure(svg(_figure(time, shown), 'look'), f'All columns of {title}')
    return _PAGE.format(title=escape(title), notes=bullets([*notes, *left]), drawing=drawing)


def _figure(time: Array | None, series: Sequence[Series]) -> Figure:
    drawn = blank(0.5 + _HEIGHT * len(series))
    rows = drawn.subplots(len(series), 1, sharex=True, squeeze=False)[:, 0]
    for axes, one in zip(rows, series):
        x = np.arange(len(one.values), dtype=float) if time is None else time
        known = np.isfinite(x)
        order = np.argsort(x[known], kind='stable')
        axes.plot(*over_time(x[known][order], one.values[known][order]), color=MEASURED)
        axes.set_title(one.label)
    rows[-1].set_xlabel('row' if time is None else 'time, s')
    return drawn
