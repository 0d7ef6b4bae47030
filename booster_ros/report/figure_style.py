# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How the figures of the report look, and how they get into the page."""

from collections.abc import Iterator
from contextlib import contextmanager
import io
import re
from typing import Any

from matplotlib import rc_context
from matplotlib.figure import Figure

WIDTH = 9.6
"""Inches; the page shows a figure at most this wide."""


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
