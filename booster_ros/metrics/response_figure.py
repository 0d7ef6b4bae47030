# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The picture of a valve that follows its set point."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from matplotlib.figure import Figure
import numpy as np

from ..records import Record
from ..writing.png import write_png
from .step_response import StepResponse


def draw_responses(record: Record, steps: Sequence[StepResponse], path: Path) -> None:
    """
    Draw set point, position and chamber pressure over time into a PNG, replacing it when done.

    T63 of each step that has one is marked.
    """
    figure = Figure(figsize=(9.0, 7.0), layout='constrained')
    upper, lower = figure.subplots(2, sharex=True, height_ratios=(3, 2))
    time = record['time']
    upper.plot(time, 1e3 * record['set_point'], color='black', linewidth=1.0,
               drawstyle='steps-post', label='set point')
    known = np.isfinite(record['valve_position'])
    upper.plot(time[known], 1e3 * record['valve_position'][known], linewidth=1.3,
               label='valve position')
    timed = [one.time + one.t63 for one in steps if one.t63 is not None]
    for moment in timed:
        upper.axvline(moment, color='tab:green', linestyle=':',
                      label='T63' if moment == timed[0] else None)
    known = np.isfinite(record['chamber_pressure'])
    lower.plot(time[known], record['chamber_pressure'][known] / 1e3, linewidth=1.3)
    upper.set_title('Set points over ROS 2 topics, held by the position controller')
    upper.set_ylabel('set point and valve position, mm')
    upper.legend(loc='upper right', frameon=False)
    lower.set_ylabel('chamber pressure, kPa')
    lower.set_xlabel('time, s')
    for panel in (upper, lower):
        panel.grid(alpha=0.3)
    write_png(path, figure)
