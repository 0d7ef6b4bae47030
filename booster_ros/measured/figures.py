# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The figures of the page: measured, before, after, and what each leaves."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure
import numpy as np

from ..diagnosis.data.blocks import Segment
from ..model.booster import diaphragm_force
from ..paper.flow_bench import OUTLET
from ..paper.printed import FLOW_UNIT
from ..report.figure_style import blank
from ..report.names import channel_label
from ..report.thinning import envelope
from ..report.tones import AFTER, BEFORE, LOCKED, MEASURED, NOISE
from ..report.view import View, axis_label, scale

_COLOURS = (BEFORE, AFTER)


def flow_over_force(view: View) -> Figure:
    """Draw flow over diaphragm force, and what is left of it, a column for each supply."""
    experiment, locked = view.diagnosis.experiment, view.locked
    supply = experiment.pinned['supply_pressure']
    booster = view.diagnosis.declared.booster
    force = np.array([diaphragm_force(booster, back, OUTLET, at) for back, at in zip(
        experiment.pinned['back_pressure'].tolist(), supply.tolist())])
    supplies = np.unique(supply)
    figure = blank(5.2)
    grid = figure.subplots(2, len(supplies), sharex='col', sharey='row', height_ratios=(2, 1),
                           squeeze=False)
    measured = experiment.measured['mass_flow'] / FLOW_UNIT
    for (above, below), at in zip(grid.T, supplies):
        for rows, face, label in ((~locked, MEASURED, 'measured'),
                                  (locked, 'white', 'measured, held out')):
            here = rows & (supply == at)
            above.plot(force[here], measured[here], 'o', markersize=4.5, markeredgecolor=MEASURED,
                       markerfacecolor=face, label=label)
        here = supply == at
        for stage, label, colour in zip(view.stages, view.stage_labels, _COLOURS):
            model = view.diagnosis.runs[stage]['mass_flow'] / FLOW_UNIT
            above.plot(force[here], model[here], color=colour, label=label)
            below.plot(force[here], (measured - model)[here], '.-', color=colour, linewidth=0.8)
        below.axhline(0.0, color=MEASURED, linewidth=0.6)
        above.set_title(f'supply {at / 1e3:.0f} kPa')
        below.set_xlabel('diaphragm force, N')
    grid[0][0].set_ylabel('mass flow, 1e-4 kg/s')
    grid[1][0].set_ylabel('measured − model')
    handles, labels = grid[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc='outside upper left', ncols=4)
    return figure


def loop(view: View) -> Figure:
    """Draw stem over pressure, up and down, and what is left of it."""
    pressure, position = view.drive('chamber_pressure'), view.measured('valve_position')
    figure = blank(3.9)
    left, right = figure.subplots(1, 2)
    _measured_points(left, pressure, position, view.locked)
    _noise_band(right, view, 'valve_position')
    for stage, label, colour in zip(view.stages, view.stage_labels, _COLOURS):
        left.plot(pressure, view.model(stage, 'valve_position'), color=colour, label=label)
        right.plot(pressure, view.residual(stage, 'valve_position'), '.-', color=colour,
                   linewidth=0.8)
    left.set_ylabel(axis_label('valve_position'))
    _residual_label(right, 'valve_position')
    for axes in (left, right):
        axes.set_xlabel(axis_label('chamber_pressure'))
    handles, labels = left.get_legend_handles_labels()
    figure.legend(handles, labels, loc='outside upper left', ncols=4)
    return figure


def decay(view: View) -> Figure:
    """Draw pressure over time, and what is left of it; the held-out end is shaded."""
    name = 'chamber_pressure'
    figure = blank(4.6)
    above, below = figure.subplots(2, sharex=True, height_ratios=(3, 2))
    above.plot(*envelope(view.time, view.measured(name)), '.', color=MEASURED, markersize=2.5,
               alpha=0.5, label='measured')
    _noise_band(below, view, name)
    for stage, label, colour in zip(view.stages, view.stage_labels, _COLOURS):
        above.plot(*envelope(view.time, view.model(stage, name)), color=colour, label=label)
        below.plot(*envelope(view.time, view.residual(stage, name)), color=colour, linewidth=0.8)
    for axes in (above, below):
        _shade_locked(axes, view.time, view.diagnosis.segments)
    above.set_ylabel(axis_label(name))
    _residual_label(below, name)
    below.set_xlabel('time, s')
    handles, labels = above.get_legend_handles_labels()
    figure.legend(handles, labels, loc='outside upper left', ncols=3)
    return figure


def _shade_locked(axes: Axes, time: np.ndarray, segments: tuple[Segment, ...]) -> None:
    """Shade the part of the record that was locked until the end."""
    for segment in segments:
        if segment.role == 'test':
            last = min(segment.last, len(time) - 1)
            axes.axvspan(time[segment.first], time[last], color=LOCKED, linewidth=0, zorder=0)


def _measured_points(axes: Axes, x: np.ndarray, y: np.ndarray, locked: np.ndarray) -> None:
    """Draw the points of a sweep, hollow where they were held out."""
    axes.plot(x[~locked], y[~locked], 'o', color=MEASURED, markersize=4.5, alpha=0.6,
              label='measured')
    axes.plot(x[locked], y[locked], 'o', markerfacecolor='white', markeredgecolor=MEASURED,
              markersize=4.5, label='measured, held out')


def _noise_band(axes: Axes, view: View, name: str) -> None:
    """Shade the part of a residual that noise fills, twice its level to either side."""
    level = 2.0 * view.noise(name)
    axes.axhspan(-level, level, color=NOISE, alpha=0.22, linewidth=0, label='± 2 × noise')
    axes.axhline(0.0, color=NOISE, linewidth=0.6)


def _residual_label(axes: Axes, name: str) -> None:
    """Label the y axis with the channel that the residual is of."""
    axes.set_ylabel(f'{channel_label(name)}:\nmeasured − model, {scale(name).unit}')
