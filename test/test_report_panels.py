# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Panels as plotly.js takes them: where they lie, what they share, how numbers are packed."""

import base64
import json

import numpy as np
import pytest

from booster_ros.report.panels import GAP, Panels


def test_rows_lie_below_each_other_in_their_heights():
    layout = json.loads(Panels([100.0, 300.0]).to_json())['layout']
    inside = 400.0 + GAP
    assert layout['yaxis']['domain'] == pytest.approx([1.0 - 100.0 / inside, 1.0])
    assert layout['yaxis2']['domain'] == pytest.approx([0.0, 300.0 / inside])
    assert layout['xaxis']['domain'] == layout['xaxis2']['domain'] == [0.0, 1.0]
    assert layout['height'] > inside


def test_columns_lie_beside_each_other_under_their_titles():
    figure = Panels([100.0, 100.0], columns=2, titles=['before', 'after'])
    layout = json.loads(figure.to_json())['layout']
    first, second = (layout[name]['domain'] for name in ('xaxis3', 'xaxis4'))
    assert 0.0 == first[0] < first[1] < second[0] < second[1] == 1.0
    assert first[1] - first[0] == pytest.approx(second[1] - second[0])
    for title, axis in zip(layout['annotations'], (first, second)):
        assert title['x'] == pytest.approx(sum(axis) / 2)


def test_shared_panels_are_zoomed_together_and_only_the_lowest_has_numbers():
    layout = json.loads(Panels([100.0] * 3, shared=True).to_json())['layout']
    assert layout['xaxis']['matches'] == layout['xaxis2']['matches'] == 'x3'
    assert not layout['xaxis']['showticklabels']
    assert 'showticklabels' not in layout['xaxis3']
    assert 'matches' not in json.loads(Panels([100.0] * 3).to_json())['layout']['xaxis']


def test_a_trace_is_drawn_in_its_panel_and_settings_change_that_panel_alone():
    figure = Panels([100.0, 100.0], columns=2)
    figure.draw(2, 1, x=np.zeros(2), y=np.ones(2))
    figure.y_axis(2, 1, title={'text': 'travel'})
    told = json.loads(figure.to_json())
    assert (told['data'][0]['xaxis'], told['data'][0]['yaxis']) == ('x3', 'y3')
    assert told['layout']['yaxis3']['title'] == {'text': 'travel'}
    assert all('title' not in told['layout'][name] for name in ('yaxis', 'yaxis2', 'yaxis4'))


@pytest.mark.parametrize('kind', ['>f8', '<f8', '<f4', '>f4'])
def test_numbers_are_packed_bit_by_bit_with_holes(kind):
    values = np.array([1.5, np.nan, -2e30, np.inf]).astype(kind)
    figure = Panels([100.0])
    figure.draw(1, x=values[::-1], y=values)
    packed = json.loads(figure.to_json())['data'][0]
    assert packed['y']['dtype'] == kind[1:]
    for name, expected in (('x', values[::-1]), ('y', values)):
        told = np.frombuffer(base64.b64decode(packed[name]['bdata']), '<' + packed[name]['dtype'])
        np.testing.assert_array_equal(told, expected)
