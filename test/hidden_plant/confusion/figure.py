# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The figure: hidden effects against what was named."""

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from matplotlib import rc_context
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
import numpy as np

from ..effects import CATALOGUED, NAMELESS
from .page import actual_of
from .running import Result

_CELL = 0.24  # inches


def write_matrix(results: Sequence[Result], path: Path) -> None:
    """Write the matrix of counts over all sizes and noises, cells of several effects left out."""
    counts: Counter[tuple[str, str]] = Counter()
    for result in results:
        if len(result.cell.keys) < 2:
            for name in [one.name for one in result.found] or ['none']:
                counts[actual_of(result), name] += 1
    names = list(dict.fromkeys(effect.names[0] for effect in CATALOGUED.values()))
    hidden = {actual for actual, _ in counts}
    said = {name for _, name in counts}
    rows = [name for name in (*names, *NAMELESS, 'none') if name in hidden]
    columns = [name for name in names if name in said | hidden] + ['unknown', 'none']
    columns += sorted(said - set(columns))
    table = np.array([[counts[row, column] for column in columns] for row in rows], dtype=float)
    with rc_context({'svg.fonttype': 'none', 'svg.hashsalt': 'confusion', 'font.size': 7.5}):
        figure = Figure((2.6 + _CELL * len(columns), 2.4 + _CELL * len(rows)), layout='constrained')
        _draw(figure, rows, columns, table)
        path.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(path, format='svg', metadata={'Date': None, 'Creator': None})


def _draw(figure: Figure, rows: list[str], columns: list[str], table: np.ndarray) -> None:
    if not rows:
        return
    axes = figure.subplots()
    axes.set_xlim(-0.5, len(columns) - 0.5)
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.set_aspect('equal')
    most = float(table.max())
    axes.imshow(np.where(table > 0.0, table, np.nan), cmap='Blues',
                norm=LogNorm(0.5, max(2.0 * most, 2.0)), interpolation='nearest')
    for row, column in np.argwhere(table > 0.0):
        axes.text(column, row, f'{table[row, column]:.0f}', ha='center', va='center',
                  color='white' if table[row, column] > 0.5 * most > 1.0 else 'black')
    for row, name in enumerate(rows):
        expected = 'unknown' if name in NAMELESS else name
        place = columns.index(expected)
        axes.plot(np.array([-0.5, 0.5, 0.5, -0.5, -0.5]) + place,
                  np.array([-0.5, -0.5, 0.5, 0.5, -0.5]) + row, color='#d55e00', linewidth=0.8)
    axes.set_xticks(range(len(columns)), columns, rotation=90)
    axes.set_yticks(range(len(rows)), rows)
    axes.set_xticks(np.arange(len(columns) + 1) - 0.5, minor=True)
    axes.set_yticks(np.arange(len(rows) + 1) - 0.5, minor=True)
    axes.grid(which='minor', color='#e4e4e4', linewidth=0.5)
    axes.tick_params(which='both', length=0)
    axes.xaxis.tick_top()
    axes.set_xlabel('said (outlined: what would be right)', labelpad=12.0)
    axes.xaxis.set_label_position('top')
    axes.set_ylabel('hidden')
