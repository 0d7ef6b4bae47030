# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How the figures of the report look, and how they get into the page."""

from collections.abc import Iterator
from contextlib import contextmanager
import io
from itertools import pairwise
import re
from typing import Any

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
import numpy as np

from booster_ros.diagnosis.data.blocks import Segment
from booster_ros.records.time_axis import gap_rows

Array = np.ndarray

WIDTH = 9.6
"""Inches; the page shows a figure at most this wide."""

# Told apart by colour-blind eyes and in grey print (Okabe and Ito).
MEASURED = '#3a3a3a'
BEFORE = '#d55e00'
AFTER = '#0072b2'
NOISE = '#9a9a9a'
LOCKED = '#eef1f4'
ROLE_SHADES = {'train': '#dfe5ea', 'test': '#6f8090'}

_STYLE: dict[Any, Any] = {
    'svg.fonttype': 'none',  # text stays text: light, sharp, searchable
    'font.size': 9.0,
    'axes.titlesize': 9.0,
    'axes.titlelocation': 'left',
    'axes.labelsize': 9.0,
    'axes.edgecolor': '#8a8a8a',
    'axes.linewidth': 0.7,
    'axes.spines.top': False,
    'axes.spines.right': False,
    'axes.labelcolor': '#222222',
    'text.color': '#222222',
    'xtick.color': '#555555',
    'ytick.color': '#555555',
    'xtick.labelsize': 8.0,
    'ytick.labelsize': 8.0,
    'axes.grid': True,
    'grid.color': '#e4e4e4',
    'grid.linewidth': 0.6,
    'legend.frameon': False,
    'legend.fontsize': 8.5,
    'lines.linewidth': 1.1,
    'path.simplify': True,
    'path.simplify_threshold': 0.2,
}

_COLUMNS = 750
"""Min-max pairs along a figure: more than a screen resolves."""


@contextmanager
def styled(salt: str = '') -> Iterator[None]:
    """Give figures made within the style of the report, and ids derived from `salt`."""
    with rc_context({**_STYLE, 'svg.hashsalt': salt}):
        yield


def blank(height: float) -> Figure:
    """Return an empty figure of this height in inches."""
    return Figure(figsize=(WIDTH, height), layout='constrained')


def svg(figure: Figure, name: str) -> str:
    """Return a figure as an SVG element whose ids do not clash with those of other figures."""
    text = io.StringIO()
    with styled(name):
        figure.savefig(text, format='svg', dpi=144, metadata={'Date': None, 'Creator': None})
    markup = text.getvalue()
    markup = markup[markup.index('<svg'):]
    markup = re.sub(r'<metadata>.*?</metadata>', '', markup, flags=re.DOTALL)
    markup = re.sub(r'(<svg[^>]*?) width="[^"]*" height="[^"]*"|(<svg[^>]*?) height="[^"]*"',
                    lambda m: m.group(1) or m.group(2), markup, count=1)
    markup = re.sub(r'(\bid="|url\(#|href="#)', rf'\g<1>{name}-', markup)
    return re.sub(r'\n\s*', '\n', markup)


def envelope(x: Array, y: Array) -> tuple[Array, Array]:
    """Return a line thinned to its lowest and highest points, so that it looks the same."""
    size = len(y)
    if size <= 4 * _COLUMNS:
        return x, y
    edges = np.linspace(0, size, _COLUMNS + 1).astype(int)
    rows: list[int] = []
    for first, last in pairwise(edges):
        part = y[first:last]
        if np.isfinite(part).any():
            rows += sorted({first + int(np.nanargmin(part)), first + int(np.nanargmax(part))})
        else:
            rows.append(int(first))
    return x[rows], y[rows]


def over_time(time: Array, y: Array) -> tuple[Array, Array]:
    """Return a line over time thinned like `envelope`, and broken where the record has a gap."""
    x, y = envelope(time, y)
    resumed = time[gap_rows(time)]
    places = np.searchsorted(x, resumed)
    return np.insert(x, places, resumed), np.insert(y, places, np.nan)


def thin(*series: Array, most: int = 1600) -> list[Array]:
    """Return every n-th element of equally long series, so that at most `most` are left."""
    step = max(1, -(-len(series[0]) // most))
    return [values[::step] for values in series]


def shade_locked(axes: Axes, time: Array, segments: tuple[Segment, ...]) -> None:
    """Shade the part of the record that was locked until the end."""
    for segment in segments:
        if segment.role == 'test':
            last = min(segment.last, len(time) - 1)
            axes.axvspan(time[segment.first], time[last], color=LOCKED, linewidth=0, zorder=0)


def role_strip(axes: Axes, time: Array, segments: tuple[Segment, ...]) -> None:
    """Draw what each part of the record was used for as a strip over time."""
    for segment in segments:
        last = min(segment.last, len(time) - 1)
        axes.axvspan(time[segment.first], time[last], facecolor=ROLE_SHADES[segment.role],
                     linewidth=0.5, edgecolor='white')
    axes.set_yticks([])
    axes.grid(visible=False)
    axes.tick_params(bottom=False, labelbottom=False)
    for spine in axes.spines.values():
        spine.set_visible(False)
