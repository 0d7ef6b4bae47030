# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A figure as a PNG that takes its place when it is complete."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

from .replacement import write_file

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def write_png(path: Path, figure: Figure) -> None:
    """Write a figure, 120 dots an inch, replacing what is there when it is complete."""
    with BytesIO() as drawn:
        figure.savefig(drawn, format='png', dpi=120)
        write_file(path, drawn.getvalue())
