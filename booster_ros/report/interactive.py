# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Figures over time and of residuals, to be zoomed and hovered, each a function of a View."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from booster_ros.diagnosis.data.experiment import COMMANDS
from booster_ros.report.explanation import binned_mean
from booster_ros.report.names import channel_label
from booster_ros.report.panels import Panels, axis
from booster_ros.report.thinning import branches, over_time, thin
from booster_ros.report.tones import (
    AFTER, BEFORE, LOCKED, MEASURED, NOISE, ROLE_SHADES)
from booster_ros.report.view import View, axis_label, scale

Array = np.ndarray

POINTS = 120_000
"""Points of all lines of a figure together: what keeps a page small, and is much to zoom into."""

_COLOURS = (BEFORE, AFTER)


def measured_and_models(view: View) -> Panels:
    """Draw each compared channel, measured and by both models, over time under the drive."""
    drives, channels = view.drives, view.channels
    heights = [14.0] + [90.0] * len(drives) + [190.0] * len(channels)
    figure = Panels(heights, shared=True)
    most = POINTS // (len(drives) + 3 * len(channels))
    for row, name in enumerate(drives, 2):
        _line(figure, row, *over_time(view.time, view.drive(name), most), MEASURED, 'drive',
              name, shown=False, shape='hv' if name in COMMANDS else 'linear')
        _title(figure, row, axis_label(name).replace(', ', ',<br>'))
    for row, name in enumerate(channels, 2 + len(drives)):
        first = row == 2 + len(drives)
        _line(figure, row, *over_time(view.time, view.measured(name), most), MEASURED, 'measured',
              name, shown=first, width=2.6, opacity=0.45)
        for stage, label, colour in zip(view.stages, view.stage_labels, _COLOURS):
            _line(figure, row, *over_time(view.time, view.model(stage, name), most), colour, label,
                  name, shown=first)
        _title(figure, row, axis_label(name))
    strips = [_rectangle(1, *_span(view, segment), ROLE_SHADES[segment.role], 'above')
              for segment in view.diagnosis.segments]
    figure.layout['shapes'] = [*strips, *_locked(view, range(2, len(heights) + 1))]
    figure.y_axis(1, visible=False, fixedrange=True, range=[0, 1])
    figure.x_axis(1, showgrid=False, ticks='')
    return _over_time(figure, view, len(heights))


def residuals_over_time(view: View) -> Panels:
    """Draw measured minus model of both models over time, with the band that noise fills."""
    figure = Panels([170.0] * len(view.channels), shared=True)
    most = POINTS // (2 * len(view.channels))
    shapes = _locked(view, range(1, len(view.channels) + 1))
    for row, name in enumerate(view.channels, 1):
        shapes += noise_band(view, name, row)
        for stage, label, colour in zip(view.stages, view.stage_labels, _COLOURS):
            _line(figure, row, *over_time(view.time, view.residual(stage, name), most), colour,
                  label, name, shown=row == 1, width=1.0)
        _title(figure, row, _residual_label(name))
    figure.layout['shapes'] = shapes
    return _over_time(figure, view, len(view.channels))


def residuals_over_variable(view: View, variables: dict[str, str]) -> Panels:
    """Draw both models' residuals of each channel over the variable that explains it best."""
    figure = Panels([230.0] * len(variables), columns=2, titles=view.stage_labels)
    shapes = []
    for row, (name, variable) in enumerate(variables.items(), 1):
        x = view.state(variable)
        for column, stage, label, colour in zip((1, 2), view.stages, view.stage_labels, _COLOURS):
            residual = view.residual(stage, name)
            shapes += noise_band(view, name, 2 * row - 2 + column)
            some = thin(x, residual, most=POINTS // (8 * len(variables)))
            figure.draw(
                row, column, x=_light(some[0]), y=_light(some[1]), mode='markers', name=label,
                marker={'size': 3, 'color': colour, 'opacity': 0.5})
            middles, means, _ = binned_mean(x, residual)
            figure.draw(
                row, column, x=_light(middles), y=_light(means), mode='lines', name='mean',
                line={'color': 'black', 'width': 1.6})
            figure.x_axis(row, column, title={'text': axis_label(variable)})
        figure.y_axis(row, 2, matches=f'y{axis(figure.number(row))}')
        _title(figure, row, _residual_label(name))
    figure.layout |= {'shapes': shapes, 'showlegend': False, 'hovermode': 'closest'}
    return figure


def sweep(view: View) -> Panels:
    """Draw each compared channel of a quasi-static sweep, and its residuals, over the driver."""
    driver = view.driver
    assert driver is not None  # a sweep has a drive
    figure = Panels([300.0] * len(view.channels), columns=2)
    x, shapes = view.drive(driver), []
    parts = branches([view.drive(name) for name in view.drives if name != driver], len(x))
    for row, name in enumerate(view.channels, 1):
        for rows, face, label in ((~view.locked, MEASURED, 'measured'),
                                  (view.locked, 'white', 'measured, held out')):
            figure.draw(
                row, x=_light(x[rows]), y=_light(view.measured(name)[rows]), mode='markers',
                name=label, legendgroup=label, showlegend=row == 1,
                marker={'size': 6, 'color': face, 'opacity': 0.7,
                        'line': {'color': MEASURED, 'width': 1}})
        shapes += noise_band(view, name, 2 * row)
        for stage, label, colour in zip(view.stages, view.stage_labels, _COLOURS):
            for column, values in ((1, view.model(stage, name)), (2, view.residual(stage, name))):
                for part in parts:
                    figure.draw(
                        row, column, x=_light(x[part]), y=_light(values[part]), name=label,
                        legendgroup=label, mode='lines' if column == 1 else 'lines+markers',
                        marker={'size': 4}, showlegend=row == column == 1 and part.start == 0,
                        line={'color': colour, 'width': 1.3})
        _title(figure, row, axis_label(name))
        figure.y_axis(row, 2, title={'text': _residual_label(name)})
        for column in (1, 2):
            figure.x_axis(row, column, title={'text': axis_label(driver)})
    figure.layout |= {'shapes': shapes, 'hovermode': 'closest'}
    return figure


def series_over_time(x: Array, series: Sequence[tuple[str, Array]], label: str) -> Panels:
    """Draw series of numbers, each in a panel of its own, over what they have in common."""
    figure = Panels([100.0] * len(series), shared=True)
    for row, (name, values) in enumerate(series, 1):
        _line(figure, row, *over_time(x, values, POINTS // len(series)), MEASURED, name, name,
              shown=False, unit='')
        _title(figure, row, '')
        figure.layout['annotations'].append({
            'text': name, 'x': 0.0, 'y': 1.0, 'xref': f'x{axis(row)} domain',
            'yref': f'y{axis(row)} domain', 'xanchor': 'left', 'yanchor': 'bottom',
            'showarrow': False})
    figure.layout |= {'hovermode': 'x unified', 'hoversubplots': 'axis'}
    figure.x_axis(len(series), title={'text': label})
    return figure


def noise_band(view: View, name: str, panel: int) -> list[dict[str, Any]]:
    """Return the part of a residual that noise fills, twice its level to either side."""
    level = 2.0 * view.noise(name)
    axes = {'xref': f'x{axis(panel)} domain', 'yref': f'y{axis(panel)}'}
    return [{'type': 'rect', **axes, 'x0': 0, 'x1': 1, 'y0': -level, 'y1': level, 'opacity': 0.22,
             'fillcolor': NOISE, 'line': {'width': 0}, 'layer': 'below'},
            {'type': 'line', **axes, 'x0': 0, 'x1': 1, 'y0': 0, 'y1': 0, 'layer': 'below',
             'line': {'color': NOISE, 'width': 1}}]


def _line(figure: Panels, row: int, x: Array, y: Array, colour: str, label: str, name: str,
          shown: bool, width: float = 1.3, opacity: float = 1.0, shape: str = 'linear',
          unit: str | None = None) -> None:
    """Add a line to a panel; the legend has one entry for all panels."""
    unit = scale(name).unit if unit is None else unit
    figure.draw(
        row, x=x, y=_light(y), mode='lines', name=label, legendgroup=label, showlegend=shown,
        opacity=opacity, line={'color': colour, 'width': width, 'shape': shape},
        hovertemplate=f'%{{y:.5~g}}{f" {unit}" if unit else ""}')


def _over_time(figure: Panels, view: View, last: int) -> Panels:
    """Return a figure whose panels have one time, zoomed together and read together."""
    begins = view.diagnosis.experiment.begins
    label = f'time from {begins:.9g} s on, s' if begins else 'time, s'
    figure.layout |= {'hovermode': 'x unified', 'hoversubplots': 'axis'}
    for row in range(1, last + 1):
        figure.x_axis(row, range=[float(view.time[0]), float(view.time[-1])], hoverformat='.6~g',
                      unifiedhovertitle={'text': '%{x} s'})
    figure.x_axis(last, title={'text': label})
    return figure


def _locked(view: View, rows: range) -> list[dict[str, Any]]:
    """Return the shade over the part of the record that was held out, in each of these panels."""
    return [_rectangle(row, *_span(view, segment), LOCKED, 'below')
            for segment in view.diagnosis.segments if segment.role == 'test' for row in rows]


def _span(view: View, segment: Any) -> tuple[float, float]:
    last = min(segment.last, len(view.time) - 1)
    return float(view.time[segment.first]), float(view.time[last])


def _rectangle(panel: int, first: float, last: float, colour: str, layer: str) -> dict[str, Any]:
    return {'type': 'rect', 'xref': f'x{axis(panel)}', 'yref': f'y{axis(panel)} domain',
            'x0': first, 'x1': last, 'y0': 0, 'y1': 1, 'fillcolor': colour, 'layer': layer,
            'line': {'width': 1, 'color': 'white'} if layer == 'above' else {'width': 0}}


def _title(figure: Panels, row: int, text: str) -> None:
    figure.y_axis(row, title={'text': text, 'font': {'size': 11}})


def _residual_label(name: str) -> str:
    return f'{channel_label(name)}:<br>measured − model, {scale(name).unit}'


def _light(values: Array) -> Array:
    """Return values in 32 bits, which a screen does not tell from 64, for a page half as large."""
    return np.asarray(values, dtype=np.float32)
