# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The picture of an answer: residual, alarm, verdict, adopted model, residual gone."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
import textwrap
from typing import NamedTuple

from matplotlib.figure import Figure
import numpy as np

from ..writing.png import write_png
from .verdict import Verdict

Array = np.ndarray

BEFORE = 60.0
"""Time before the change that is shown, s."""


class Answer(NamedTuple):
    """What a twin said of a valve that changed."""

    time: Array
    """s"""
    residual: Array
    """Position read less that predicted by the model that ran, m."""
    changed: float
    """s"""
    said: Mapping[str, tuple[float, str]]
    """Alarm, verdict, end of the trial by name: when, s, and the sentence."""
    verdict: Verdict


def draw_answer(answer: Answer, noise: float, path: Path) -> None:
    """Draw into a PNG, replacing it when done; `noise` is that of the position, m."""
    figure = Figure(figsize=(9.0, 5.5), layout='constrained')
    panel = figure.subplots()
    shown = answer.time >= answer.changed - BEFORE
    panel.axhspan(-2e6 * noise, 2e6 * noise, color='tab:green', alpha=0.25, linewidth=0,
                  label='two standard deviations of the noise')
    panel.plot(answer.time[shown], 1e6 * answer.residual[shown], linewidth=1.0,
               label='position read less position predicted')
    colours = iter(('tab:orange', 'tab:red', 'tab:purple'))
    panel.axvline(answer.changed, color='black', linestyle='--',
                  label=f'{answer.changed:.0f} s: the packing begins to rub')
    for name, (moment, sentence) in answer.said.items():
        panel.axvline(moment, color=next(colours), linestyle='--', label='\n'.join(
            textwrap.wrap(f'{moment:.0f} s: {name}: {sentence}', 110)))
    ended = max(moment for moment, _ in answer.said.values())
    panel.axvspan(answer.said['verdict'][0], ended, color='tab:red', alpha=0.08, linewidth=0,
                  label='both models run, the residual is that of the found one')
    panel.set_title('A twin beside a valve that begins to rub')
    panel.set_xlabel('time of the valve, s')
    panel.set_ylabel('residual of the position, µm')
    panel.grid(alpha=0.3)
    figure.legend(loc='outside lower center', frameon=False, fontsize='small')
    write_png(path, figure)
