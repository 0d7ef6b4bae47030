# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The figures of the report that stand still, each a function of a View."""

from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator
import numpy as np

from booster_ros.diagnosis.result import ChannelError
from booster_ros.report.engineering import scale_of
from booster_ros.report.figure_style import blank
from booster_ros.report.names import channel_label
from booster_ros.report.thinning import thin
from booster_ros.report.tones import AFTER, BEFORE, MEASURED, NOISE
from booster_ros.report.view import View, axis_label
from booster_ros.report.unknown_term import UnknownTerm

Array = np.ndarray

_COLOURS = (BEFORE, AFTER)

_SMALLEST_RATIO = 0.3
"""Errors are drawn as at least this many times the noise: less means nothing."""


def error_ladder(errors: list[tuple[str, ChannelError]], labels: dict[str, str]) -> Figure:
    """
    Draw errors as multiples of the noise, a row for each channel and part of the data.

    `labels` holds the words for the stages ('declared', 'before', 'after') to show, worst first.
    """
    figure = blank(0.75 + 0.34 * len(errors))
    axes = figure.subplots()
    styles = (('o', 'white', '#666666'), ('o', BEFORE, BEFORE), ('D', AFTER, AFTER))
    marks = dict(zip(labels, styles[-len(labels):]))
    for row, (_, error) in enumerate(errors):
        ratios = {stage: max(getattr(error, stage) / error.noise, _SMALLEST_RATIO)
                  for stage in labels}
        known = [value for value in ratios.values() if np.isfinite(value)]
        if known:
            axes.plot([min(known), max(known)], [row, row], color='#c8c8c8', linewidth=1.5,
                      zorder=1)
        for stage, ratio in ratios.items():
            marker, face, edge = marks[stage]
            axes.plot(ratio, row, marker, markersize=7.5, markerfacecolor=face,
                      markeredgecolor=edge, zorder=2, clip_on=False,
                      label=labels[stage] if row == 0 else None)
    axes.axvline(1.0, color=NOISE, linewidth=1.2, linestyle=(0, (4, 2)), zorder=0)
    axes.set_xscale('log')
    low, high = axes.get_xlim()
    axes.set_xlim(min(low, 0.8), max(high, 3.0))
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.xaxis.set_major_formatter(lambda ratio, _: f'{ratio:g}')
    axes.xaxis.set_minor_locator(NullLocator())
    axes.set_yticks(range(len(errors)), [label for label, _ in errors])
    axes.set_ylim(len(errors) - 0.5, -0.5)
    axes.tick_params(axis='y', length=0, labelsize=9)
    axes.set_xlabel('error, multiples of the noise (dashed: the noise itself)')
    figure.legend(loc='outside upper left', ncols=len(labels))
    return figure


def valve_signature(view: View) -> Figure:
    """Draw position over pressure, measured beneath each model."""
    figure = blank(4.0)
    grid = figure.subplots(1, 2, sharex=True, sharey=True)
    for axes, stage, label, colour in zip(grid, view.stages, view.stage_labels, _COLOURS):
        pressure, position = _loop(view, None)
        axes.plot(*thin(pressure, position, most=3000), color=MEASURED, linewidth=2.6, alpha=0.4,
                  label='measured')
        axes.plot(*thin(*_loop(view, stage), most=3000), color=colour, label=label)
        axes.set_xlabel(axis_label('chamber_pressure'))
        axes.legend(loc='upper left')
    grid[0].set_ylabel(axis_label('valve_position'))
    return figure


def has_signature(view: View) -> bool:
    """Tell whether the record has pressure and position."""
    known = {*view.channels, *view.diagnosis.experiment.pinned}
    return {'chamber_pressure', 'valve_position'} <= known


def _loop(view: View, stage: str | None) -> tuple[Array, Array]:
    """Return pressure and position, by a model or, without one, as measured."""
    def series(name: str) -> Array:
        if name not in view.channels:
            return view.drive(name)
        return view.measured(name) if stage is None else view.model(stage, name)

    return series('chamber_pressure'), series('valve_position')


def unknown_term(view: View, term: UnknownTerm) -> Figure:
    """Draw a term without a name, dotted beyond what was seen, and how much was seen where."""
    figure = blank(3.3)
    axes, below = figure.subplots(2, sharex=True, height_ratios=(4, 1))
    over, size = scale_of(term.variable_unit), scale_of(term.unit)
    x, y = term.knots * over.factor, term.values * size.factor
    axes.plot(x[1:-1], y[1:-1], 'o-', color=AFTER, markersize=4.5, linewidth=1.6)
    margin = 0.08 * np.ptp(x)
    beyond = (((x[0] - margin, *x[:2]), (0.0, *y[:2])), ((*x[-2:], x[-1] + margin), (*y[-2:], 0.0)))
    for at, values in beyond if term.reach is None else ():  # nothing is beyond a play
        axes.plot(at, values, color=AFTER, linewidth=1.6, linestyle=':')
    axes.axhline(0.0, color=NOISE, linewidth=0.8)
    axes.set_ylabel(f'added, {size.unit}' if size.unit else 'term')
    seen = view.states[term.variable] * over.factor
    below.hist(seen[np.isfinite(seen)], bins=60, range=(x[0], x[-1]), color='#b4c0ca')
    below.set_yticks([])
    below.grid(visible=False)
    below.set_ylabel('rows')
    unit = f', {over.unit}' if over.unit else ''
    below.set_xlabel(f'{channel_label(term.variable)}{unit}')
    return figure
