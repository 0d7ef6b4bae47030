# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Panels in rows and columns, in the words of plotly.js, the library that draws them in a page.

Traces, axes and layout are what its reference calls them (https://plotly.com/javascript/reference).
"""

from __future__ import annotations

import base64
from collections.abc import Sequence
import json
from typing import Any

import numpy as np

from booster_ros.report.tones import GRID, INK, NOISE

GAP_SHARED, GAP = 24.0, 62.0
"""Height between rows, pixels, without and with the numbers of an axis between them."""

_TOP, _BOTTOM = 46, 46
_BETWEEN = 0.11
"""Width between columns, as a share of the width."""

_AXIS = {'showgrid': True, 'gridcolor': GRID, 'zeroline': False, 'linecolor': NOISE}


class Panels:
    """
    A figure of panels, numbered row by row from 1 on.

    `heights` are those of the rows, pixels, from the top. With `shared` all panels have one x-axis,
    the lowest. `titles` stand above the columns.
    """

    def __init__(self, heights: Sequence[float], columns: int = 1, shared: bool = False,
                 titles: Sequence[str] = ()):
        gap = GAP_SHARED if shared else GAP
        inside = sum(heights) + gap * (len(heights) - 1)
        self.rows, self.columns = len(heights), columns
        self.height = inside + _TOP + _BOTTOM
        self.traces: list[dict[str, Any]] = []
        self.layout: dict[str, Any] = {
            'height': self.height, 'margin': {'l': 84, 'r': 8, 't': _TOP, 'b': _BOTTOM},
            'plot_bgcolor': 'white', 'dragmode': 'zoom', 'hoverlabel': {'namelength': -1},
            'font': {'family': 'system-ui, sans-serif', 'size': 12, 'color': INK},
            'legend': {'orientation': 'h', 'x': 0, 'xanchor': 'left', 'yref': 'container', 'y': 1,
                       'yanchor': 'top'}}
        spans = [_span(column, columns) for column in range(columns)]
        self.layout['annotations'] = [
            {'text': title, 'x': sum(span) / 2, 'y': 1.0, 'xref': 'paper', 'yref': 'paper',
             'xanchor': 'center', 'yanchor': 'bottom', 'showarrow': False, 'font': {'size': 12}}
            for title, span in zip(titles, spans)]
        bottom = inside
        for row, height in enumerate(heights, 1):
            bottom -= height
            for column, span in enumerate(spans, 1):
                number = self.number(row, column)
                x = {'anchor': f'y{axis(number)}', 'domain': list(span), **_AXIS}
                if shared and row < self.rows:
                    x |= {'matches': f'x{axis(self.number(self.rows, column))}',
                          'showticklabels': False}
                self.layout[f'xaxis{axis(number)}'] = x
                self.layout[f'yaxis{axis(number)}'] = {
                    'anchor': f'x{axis(number)}', 'nticks': 6, **_AXIS,
                    'domain': [bottom / inside, min((bottom + height) / inside, 1.0)]}
            bottom -= gap

    def number(self, row: int, column: int = 1) -> int:
        """Return the number of a panel."""
        return (row - 1) * self.columns + column

    def draw(self, row: int, column: int = 1, **trace: Any) -> None:
        """Add points or a line to a panel; arrays are packed."""
        at = axis(self.number(row, column))
        self.traces.append({'type': 'scatter', 'xaxis': f'x{at}', 'yaxis': f'y{at}', **trace})

    def x_axis(self, row: int, column: int = 1, **settings: Any) -> None:
        """Change the x-axis of a panel."""
        self.layout[f'xaxis{axis(self.number(row, column))}'] |= settings

    def y_axis(self, row: int, column: int = 1, **settings: Any) -> None:
        """Change the y-axis of a panel."""
        self.layout[f'yaxis{axis(self.number(row, column))}'] |= settings

    def to_json(self) -> str:
        """Return traces and layout as plotly.js takes them."""
        return json.dumps({'data': self.traces, 'layout': self.layout}, default=_packed,
                          ensure_ascii=False, allow_nan=False)


def axis(panel: int) -> str:
    """Return the number by which the axes of a panel are called: those of the first have none."""
    return '' if panel == 1 else str(panel)


def _span(column: int, columns: int) -> tuple[float, float]:
    """Return from where to where a column goes, as shares of the width."""
    width = (1.0 - _BETWEEN * (columns - 1)) / columns
    first = column * (width + _BETWEEN)
    return first, min(first + width, 1.0)


def _packed(values: np.ndarray) -> dict[str, str]:
    """Return an array as plotly.js unpacks it: kind of numbers, and their bytes."""
    kind = {'float32': 'f4', 'float64': 'f8'}[values.dtype.name]
    little = np.ascontiguousarray(values, dtype=f'<{kind}')
    return {'dtype': kind, 'bdata': base64.b64encode(little.tobytes()).decode('ascii')}
