# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The figures of the report, each a function of a View."""

from itertools import pairwise

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator
import numpy as np

from booster_ros.diagnosis.result import ChannelError, UnknownTerm
from booster_ros.report.engineering import scale_of
from booster_ros.report.explanation import binned_mean
from booster_ros.report.figure_style import (
    AFTER, BEFORE, MEASURED, NOISE, blank, over_time, role_strip, shade_locked, thin)
from booster_ros.report.view import View, axis_label, scale
from booster_ros.report.names import channel_label

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


def measured_and_models(view: View) -> Figure:
    """Draw each compared channel, measured and by both models, over time under the drive."""
    drives = view.drives
    heights = [0.12] + [0.9] * len(drives) + [2.0] * len(view.channels)
    figure = blank(0.7 + 1.05 * sum(heights))
    panels = figure.subplots(len(heights), sharex=True, height_ratios=heights)
    time, segments = view.time, view.diagnosis.segments
    role_strip(panels[0], time, segments)
    for axes, name in zip(panels[1:], drives):
        style = 'steps-post' if name == 'control_current' else 'default'
        axes.plot(*over_time(time, view.drive(name)), color=MEASURED, drawstyle=style)
        axes.set_ylabel(axis_label(name).replace(', ', ',\n'))
    for axes, name in zip(panels[1 + len(drives):], view.channels):
        axes.plot(*over_time(time, view.measured(name)), color=MEASURED, linewidth=2.4, alpha=0.45,
                  label='measured')
        for stage, label, colour in zip(view.stages, view.stage_labels, _COLOURS):
            axes.plot(*over_time(time, view.model(stage, name)), color=colour, label=label)
        axes.set_ylabel(axis_label(name))
    for axes in panels[1:]:
        shade_locked(axes, time, segments)
    panels[-1].set_xlabel(_time_label(view))
    panels[-1].set_xlim(time[0], time[-1])
    handles, labels = panels[-1].get_legend_handles_labels()
    figure.legend(handles, labels, loc='outside upper left', ncols=3)
    return figure


def _time_label(view: View) -> str:
    begins = view.diagnosis.experiment.begins
    return f'time from {begins:.9g} s on, s' if begins else 'time, s'


def residuals_over_time(view: View) -> Figure:
    """Draw measured minus model of both models over time, with the band that noise fills."""
    figure = blank(0.6 + 1.9 * len(view.channels))
    panels = np.atleast_1d(figure.subplots(len(view.channels), sharex=True))
    for axes, name in zip(panels, view.channels):
        shade_locked(axes, view.time, view.diagnosis.segments)
        noise_band(axes, view, name)
        for stage, label, colour in zip(view.stages, view.stage_labels, _COLOURS):
            axes.plot(*over_time(view.time, view.residual(stage, name)), color=colour, label=label,
                      linewidth=0.9)
        residual_label(axes, name)
    panels[-1].set_xlabel(_time_label(view))
    panels[-1].set_xlim(view.time[0], view.time[-1])
    handles, labels = panels[-1].get_legend_handles_labels()
    figure.legend(handles, labels, loc='outside upper left', ncols=3)
    return figure


def residuals_over_variable(view: View, variables: dict[str, str]) -> Figure:
    """Draw both models' residuals of each channel over the variable that explains it best."""
    figure = blank(0.5 + 2.5 * len(variables))
    grid = figure.subplots(len(variables), 2, squeeze=False, sharey='row')
    for row, (name, variable) in zip(grid, variables.items()):
        x = view.state(variable)
        for axes, stage, label, colour in zip(row, view.stages, view.stage_labels, _COLOURS):
            residual = view.residual(stage, name)
            noise_band(axes, view, name)
            axes.plot(*thin(x, residual), '.', color=colour, markersize=3.0, alpha=0.5,
                      markeredgewidth=0, rasterized=True)
            middles, means, _ = binned_mean(x, residual)
            axes.plot(middles, means, color='black', linewidth=1.4)
            axes.set_title(label)
            axes.set_xlabel(axis_label(variable))
        residual_label(row[0], name)
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


def sweep(view: View) -> Figure:
    """Draw each compared channel of a quasi-static sweep, and its residuals, over the driver."""
    driver = view.driver
    assert driver is not None  # a sweep has a drive
    figure = blank(0.6 + 3.3 * len(view.channels))
    grid = figure.subplots(len(view.channels), 2, squeeze=False)
    x = view.drive(driver)
    for row, name in zip(grid, view.channels):
        measured_points(row[0], x, view.measured(name), view.locked)
        noise_band(row[1], view, name)
        for stage, label, colour in zip(view.stages, view.stage_labels, _COLOURS):
            for part in _branches(view, driver):
                row[0].plot(x[part], view.model(stage, name)[part], color=colour,
                            label=label if part.start == 0 else None)
                row[1].plot(x[part], view.residual(stage, name)[part], '.-', color=colour,
                            linewidth=0.8, markersize=5)
        row[0].set_ylabel(axis_label(name))
        residual_label(row[1], name)
        for axes in row:
            axes.set_xlabel(axis_label(driver))
    handles, labels = grid[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc='outside upper left', ncols=4)
    return figure


def measured_points(axes: Axes, x: Array, y: Array, locked: Array) -> None:
    """Draw the points of a sweep, hollow where they were held out."""
    axes.plot(x[~locked], y[~locked], 'o', color=MEASURED, markersize=4.5, alpha=0.6,
              label='measured')
    axes.plot(x[locked], y[locked], 'o', markerfacecolor='white', markeredgecolor=MEASURED,
              markersize=4.5, label='measured, held out')


def _branches(view: View, driver: str) -> list[slice]:
    """Return the slices of a sweep during which nothing but the driver moves."""
    others = [view.drive(name) for name in view.drives if name != driver]
    jumps = np.zeros(max(len(view.time) - 1, 0), dtype=bool)
    for values in others:
        jumps |= np.abs(np.diff(values)) > 0.02 * np.ptp(values)
    edges = [0, *(np.flatnonzero(jumps) + 1).tolist(), len(view.time)]
    return [slice(first, last) for first, last in pairwise(edges)]


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


def noise_band(axes: Axes, view: View, name: str) -> None:
    """Shade the part of a residual that noise fills, twice its level to either side."""
    level = 2.0 * view.noise(name)
    axes.axhspan(-level, level, color=NOISE, alpha=0.22, linewidth=0, label='± 2 × noise')
    axes.axhline(0.0, color=NOISE, linewidth=0.6)


def residual_label(axes: Axes, name: str) -> None:
    """Label the y axis with the channel that the residual is of."""
    axes.set_ylabel(f'{channel_label(name)}:\nmeasured − model, {scale(name).unit}')
