# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The picture of an answer: residual, alarm, verdict, adopted model, residual gone."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
import textwrap
from typing import NamedTuple

from matplotlib.figure import Figure
import numpy as np

from ..writing.replacement import write_file
from .verdict import Verdict

Array = np.ndarray

BEFORE = 60.0
"""Time before the change that is shown, s."""


class Answer(NamedTuple):
    """What a twin said of a valve that changed; times in s, NaN for what did not come to pass."""

    time: Array
    residual: Array
    """Position read less that predicted by the model that ran, m."""
    changed: float
    alarmed: float
    judged: float
    ended: float
    """End of the trial of the found model."""
    alarm: str
    verdict: Verdict
    adoption: str


def draw_answer(answer: Answer, noise: float, path: Path) -> None:
    """Draw into a PNG, replacing it when done; `noise` is that of the position, m."""
    figure = Figure(figsize=(9.0, 5.5), layout='constrained')
    panel = figure.subplots()
    shown = answer.time >= answer.changed - BEFORE
    panel.axhspan(-2e6 * noise, 2e6 * noise, color='tab:green', alpha=0.25, linewidth=0,
                  label='two standard deviations of the noise')
    panel.plot(answer.time[shown], 1e6 * answer.residual[shown], linewidth=1.0,
               label='position read less position predicted')
    moments = ((answer.changed, 'the packing begins to rub', 'black'),
               (answer.alarmed, f'alarm: {answer.alarm}', 'tab:orange'),
               (answer.judged, f'verdict: {answer.verdict.sentence}', 'tab:red'),
               (answer.ended, f'the found model was {answer.adoption}', 'tab:purple'))
    for moment, words, colour in moments:
        if np.isfinite(moment):
            panel.axvline(moment, color=colour, linestyle='--', label='\n'.join(
                textwrap.wrap(f'{moment:.0f} s: {words}', 110)))
    if np.isfinite(answer.judged):
        panel.axvspan(answer.judged, answer.ended if np.isfinite(answer.ended) else (
            answer.time[-1]), color='tab:red', alpha=0.08, linewidth=0,
            label='both models run, the residual is that of the found one')
    panel.set_title('A twin beside a valve that begins to rub')
    panel.set_xlabel('time of the valve, s')
    panel.set_ylabel('residual of the position, µm')
    panel.grid(alpha=0.3)
    figure.legend(loc='outside lower center', frameon=False, fontsize='small')
    with BytesIO() as drawn:
        figure.savefig(drawn, format='png', dpi=120)
        write_file(path, drawn.getvalue())
