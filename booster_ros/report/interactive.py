# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Figures over time and of residuals, to be zoomed and hovered, each a function of a View."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from plotly.graph_objects import Figure, Scatter
from plotly.subplots import make_subplots

from booster_ros.diagnosis.data.experiment import COMMANDS
from booster_ros.report.explanation import binned_mean
from booster_ros.report.names import channel_label
from booster_ros.report.thinning import branches, over_time, thin
from booster_ros.report.tones import (
    AFTER, BEFORE, GRID, INK, LOCKED, MEASURED, NOISE, ROLE_SHADES)
from booster_ros.report.view import View, axis_label, scale

Array = np.ndarray

POINTS = 120_000
"""Points of all lines of a figure together: what keeps a page small, and is much to zoom into."""

_COLOURS = (BEFORE, AFTER)
_TOP, _BOTTOM = 46, 46
_MARGINS = {'l': 84, 'r': 8, 't': _TOP, 'b': _BOTTOM}


def measured_and_models(view: View) -> Figure:
    """Draw each compared channel, measured and by both models, over time under the drive."""
    drives, channels = view.drives, view.channels
    heights = [14.0] + [90.0] * len(drives) + [190.0] * len(channels)
    figure = panels(heights, shared=True)
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
    figure.update_layout(shapes=[*strips, *_locked(view, range(2, len(heights) + 1))])
    figure.update_yaxes(visible=False, fixedrange=True, range=[0, 1], row=1, col=1)
    figure.update_xaxes(showgrid=False, ticks='', row=1, col=1)
    return _over_time(figure, view, len(heights))


def residuals_over_time(view: View) -> Figure:
    """Draw measured minus model of both models over time, with the band that noise fills."""
    figure = panels([170.0] * len(view.channels), shared=True)
    most = POINTS // (2 * len(view.channels))
    shapes = _locked(view, range(1, len(view.channels) + 1))
    for row, name in enumerate(view.channels, 1):
        shapes += noise_band(view, name, row)
        for stage, label, colour in zip(view.stages, view.stage_labels, _COLOURS):
            _line(figure, row, *over_time(view.time, view.residual(stage, name), most), colour,
                  label, name, shown=row == 1, width=1.0)
        _title(figure, row, _residual_label(name))
    figure.update_layout(shapes=shapes)
    return _over_time(figure, view, len(view.channels))


def residuals_over_variable(view: View, variables: dict[str, str]) -> Figure:
    """Draw both models' residuals of each channel over the variable that explains it best."""
    figure = panels([230.0] * len(variables), columns=2, titles=view.stage_labels)
    shapes = []
    for row, (name, variable) in enumerate(variables.items(), 1):
        x = view.state(variable)
        for column, stage, label, colour in zip((1, 2), view.stages, view.stage_labels, _COLOURS):
            residual = view.residual(stage, name)
            shapes += noise_band(view, name, 2 * row - 2 + column)
            some = thin(x, residual, most=POINTS // (8 * len(variables)))
            figure.add_trace(Scatter(
                x=_light(some[0]), y=_light(some[1]), mode='markers', name=label,
                marker={'size': 3, 'color': colour, 'opacity': 0.5}), row, column)
            middles, means, _ = binned_mean(x, residual)
            figure.add_trace(Scatter(
                x=_light(middles), y=_light(means), mode='lines', name='mean',
                line={'color': 'black', 'width': 1.6}), row, column)
            figure.update_xaxes(title_text=axis_label(variable), row=row, col=column)
        figure.update_yaxes(matches=f'y{2 * row - 1}' if row > 1 else 'y', row=row)
        _title(figure, row, _residual_label(name))
    figure.update_layout(shapes=shapes, showlegend=False, hovermode='closest')
    return figure


def sweep(view: View) -> Figure:
    """Draw each compared channel of a quasi-static sweep, and its residuals, over the driver."""
    driver = view.driver
    assert driver is not None  # a sweep has a drive
    figure = panels([300.0] * len(view.channels), columns=2)
    x, shapes = view.drive(driver), []
    parts = branches([view.drive(name) for name in view.drives if name != driver], len(x))
    for row, name in enumerate(view.channels, 1):
        for rows, face, label in ((~view.locked, MEASURED, 'measured'),
                                  (view.locked, 'white', 'measured, held out')):
            figure.add_trace(Scatter(
                x=_light(x[rows]), y=_light(view.measured(name)[rows]), mode='markers', name=label,
                legendgroup=label, showlegend=row == 1,
                marker={'size': 6, 'color': face, 'opacity': 0.7,
                        'line': {'color': MEASURED, 'width': 1}}), row, 1)
        shapes += noise_band(view, name, 2 * row)
        for stage, label, colour in zip(view.stages, view.stage_labels, _COLOURS):
            for column, values in ((1, view.model(stage, name)), (2, view.residual(stage, name))):
                for part in parts:
                    figure.add_trace(Scatter(
                        x=_light(x[part]), y=_light(values[part]), name=label, legendgroup=label,
                        mode='lines' if column == 1 else 'lines+markers', marker={'size': 4},
                        showlegend=row == column == 1 and part.start == 0,
                        line={'color': colour, 'width': 1.3}), row, column)
        _title(figure, row, axis_label(name))
        figure.update_yaxes(title_text=_residual_label(name), row=row, col=2)
        figure.update_xaxes(title_text=axis_label(driver), row=row)
    figure.update_layout(shapes=shapes, hovermode='closest')
    return figure


def series_over_time(x: Array, series: Sequence[tuple[str, Array]], label: str) -> Figure:
    """Draw series of numbers, each in a panel of its own, over what they have in common."""
    figure = panels([100.0] * len(series), shared=True)
    for row, (name, values) in enumerate(series, 1):
        _line(figure, row, *over_time(x, values, POINTS // len(series)), MEASURED, name, name,
              shown=False, unit='')
        _title(figure, row, '')
        figure.add_annotation(text=name, x=0.0, y=1.0, xref='x domain' if row == 1 else
                              f'x{row} domain', yref='y domain' if row == 1 else f'y{row} domain',
                              xanchor='left', yanchor='bottom', showarrow=False)
    figure.update_layout(hovermode='x unified', hoversubplots='axis')
    figure.update_xaxes(title_text=label, row=len(series), col=1)
    return figure


def panels(heights: list[float], columns: int = 1, shared: bool = False,
           titles: Sequence[str] = ()) -> Figure:
    """Return an empty figure of rows of these heights, in pixels."""
    gap = 24.0 if shared else 62.0
    whole = sum(heights) + gap * (len(heights) - 1)
    figure = make_subplots(
        len(heights), columns, shared_xaxes=shared, row_heights=heights,
        vertical_spacing=gap / whole if len(heights) > 1 else None, horizontal_spacing=0.11,
        column_titles=list(titles) or None)
    figure.update_layout(
        height=whole + _TOP + _BOTTOM, margin=_MARGINS, template='none', plot_bgcolor='white',
        font={'family': 'system-ui, sans-serif', 'size': 12, 'color': INK}, dragmode='zoom',
        legend={'orientation': 'h', 'x': 0, 'xanchor': 'left', 'yref': 'container', 'y': 1,
                'yanchor': 'top'}, hoverlabel={'namelength': -1})
    figure.update_annotations(font_size=12)
    figure.update_xaxes(showgrid=True, gridcolor=GRID, zeroline=False, linecolor=NOISE)
    figure.update_yaxes(showgrid=True, gridcolor=GRID, zeroline=False, linecolor=NOISE,
                        nticks=6)
    return figure


def noise_band(view: View, name: str, panel: int) -> list[dict[str, Any]]:
    """Return the part of a residual that noise fills, twice its level to either side."""
    level = 2.0 * view.noise(name)
    axes = {'xref': f'x{_place(panel)} domain', 'yref': f'y{_place(panel)}'}
    return [{'type': 'rect', **axes, 'x0': 0, 'x1': 1, 'y0': -level, 'y1': level, 'opacity': 0.22,
             'fillcolor': NOISE, 'line': {'width': 0}, 'layer': 'below'},
            {'type': 'line', **axes, 'x0': 0, 'x1': 1, 'y0': 0, 'y1': 0, 'layer': 'below',
             'line': {'color': NOISE, 'width': 1}}]


def _line(figure: Figure, row: int, x: Array, y: Array, colour: str, label: str, name: str,
          shown: bool, width: float = 1.3, opacity: float = 1.0, shape: str = 'linear',
          unit: str | None = None) -> None:
    """Add a line to a panel; the legend has one entry for all panels."""
    unit = scale(name).unit if unit is None else unit
    figure.add_trace(Scatter(
        x=x, y=_light(y), mode='lines', name=label, legendgroup=label, showlegend=shown,
        opacity=opacity, line={'color': colour, 'width': width, 'shape': shape},
        hovertemplate=f'%{{y:.5~g}}{f" {unit}" if unit else ""}'), row, 1)


def _over_time(figure: Figure, view: View, last: int) -> Figure:
    """Return a figure whose panels have one time, zoomed together and read together."""
    begins = view.diagnosis.experiment.begins
    label = f'time from {begins:.9g} s on, s' if begins else 'time, s'
    figure.update_layout(hovermode='x unified', hoversubplots='axis')
    figure.update_xaxes(range=[float(view.time[0]), float(view.time[-1])],
                        hoverformat='.6~g', unifiedhovertitle={'text': '%{x} s'})
    figure.update_xaxes(title_text=label, row=last, col=1)
    return figure


def _locked(view: View, rows: range) -> list[dict[str, Any]]:
    """Return the shade over the part of the record that was held out, in each of these panels."""
    return [_rectangle(row, *_span(view, segment), LOCKED, 'below')
            for segment in view.diagnosis.segments if segment.role == 'test' for row in rows]


def _span(view: View, segment: Any) -> tuple[float, float]:
    last = min(segment.last, len(view.time) - 1)
    return float(view.time[segment.first]), float(view.time[last])


def _rectangle(panel: int, first: float, last: float, colour: str, layer: str) -> dict[str, Any]:
    return {'type': 'rect', 'xref': f'x{_place(panel)}', 'yref': f'y{_place(panel)} domain',
            'x0': first, 'x1': last, 'y0': 0, 'y1': 1, 'fillcolor': colour, 'layer': layer,
            'line': {'width': 1, 'color': 'white'} if layer == 'above' else {'width': 0}}


def _place(panel: int) -> str:
    """Return the number by which an axis is called: the first has none."""
    return '' if panel == 1 else str(panel)


def _title(figure: Figure, row: int, text: str) -> None:
    figure.update_yaxes(title_text=text, title_font_size=11, row=row, col=1)


def _residual_label(name: str) -> str:
    return f'{channel_label(name)}:<br>measured − model, {scale(name).unit}'


def _light(values: Array) -> Array:
    """Return values in 32 bits, which a screen does not tell from 64, for a page half as large."""
    return np.asarray(values, dtype=np.float32)
