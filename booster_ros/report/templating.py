# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Pages from templates, each one file that needs nothing else."""

from __future__ import annotations

from functools import cache
from importlib.resources import files
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from booster_ros.report.panels import Panels

_FOLDER = 'report'


@cache
def _environment() -> Environment:
    return Environment(
        loader=PackageLoader('booster_ros', f'{_FOLDER}/templates'), autoescape=True,
        undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True)


def rendered(template: str, **content: Any) -> str:
    """Return a page; the template says what of its content is markup, all else is escaped."""
    return _environment().get_template(template).render(**content)


@cache
def plot_library() -> str:
    """Return the script that draws plots, to stand in a page."""
    script = files('booster_ros') / _FOLDER / 'plotly' / 'plotly-basic.min.js'
    return script.read_text(encoding='utf-8')


def plot(figure: Panels, name: str, description: str) -> str:
    """Return a figure as markup: its data, and a place that the library fills."""
    pieces: Any = _environment().get_template('plots.html').module
    # nothing in the data may end the element that it stands in
    data = figure.to_json().replace('<', '\\u003c')
    return str(pieces.plot(name, description, figure.height, data))
