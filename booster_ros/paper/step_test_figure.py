# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The picture of a recorded step test."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure
import numpy as np

from ..records import Record
from ..writing.png import write_png
from .indices import SETTLING_BAND
from .step_test import StepResponse


def draw_step_test(record: Record, responses: Sequence[StepResponse], path: Path) -> None:
    """Draw current, pressure and position over time into a PNG file, replacing it when done."""
    figure = Figure(figsize=(9.0, 7.0), layout='constrained')
    panels = figure.subplots(3, sharex=True, height_ratios=(1, 2, 2))
    time = record['time']
    _draw(panels[0], time, record['control_current'] * 1e3, 'control current, mA', 'steps-post')
    _draw(panels[1], time, record['chamber_pressure'] / 1e3, 'chamber pressure, kPa', 'default')
    _draw(panels[2], time, record['valve_position'] * 1e3, 'valve position, mm', 'default')
    for response in responses:
        _mark_settling(panels[1], response)
    panels[0].set_title('0 → 0.4524 → 0 → 0.4524 mA over ROS 2 topics')
    panels[1].legend(loc='lower right', frameon=False)
    panels[-1].set_xlabel('time, s')
    write_png(path, figure)


def _draw(panel: Axes, time: np.ndarray, values: np.ndarray, label: str, style: str) -> None:
    known = np.isfinite(values)
    panel.plot(time[known], values[known], drawstyle=style, linewidth=1.3)
    panel.set_ylabel(label)
    panel.grid(alpha=0.3)


def _mark_settling(panel: Axes, response: StepResponse) -> None:
    """Show the band within which the response has to stay, and since when it does."""
    indices = response.indices()
    final = indices.final_pressure
    half_width = SETTLING_BAND * (final - response.pressure[0] / 1e3)
    first = not panel.get_legend_handles_labels()[1]
    span = response.time[[0, -1]]
    panel.fill_between(
        span,
        final - half_width,
        final + half_width,
        color='tab:green',
        alpha=0.15,
        linewidth=0,
        label='within 5 % of the final value' if first else None,
    )
    panel.axvline(
        response.time[0] + indices.settling_time_5_percent,
        color='tab:green',
        linestyle=':',
        label='settled' if first else None,
    )
