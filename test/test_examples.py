# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What `examples` shows beside the tests of a controller: names there are names here."""

import ast
import json
from xml.etree import ElementTree

import pytest
from ros_process import ROOT

EXAMPLES = ROOT / 'examples'
PLOTTED = {'control_current', 'chamber_pressure', 'valve_position'}


def test_layouts_show_topics_of_the_positioner():
    curves = ElementTree.parse(EXAMPLES / 'plotjuggler.xml').getroot().iter('curve')
    assert {curve.get('name') for curve in curves} == {f'/{name}/data' for name in PLOTTED}
    panels = json.loads((EXAMPLES / 'foxglove.json').read_text())['configById'].values()
    assert {path['value'] for panel in panels for path in panel.get('paths', [])} == {
        f'/{name}.data' for name in PLOTTED}


def test_the_page_lists_every_example():
    page = (EXAMPLES / 'README.md').read_text()
    listed = {path.name for path in EXAMPLES.iterdir() if path.is_file()} - {'README.md'}
    assert [name for name in listed if f'`{name}`' not in page] == []


@pytest.mark.parametrize('path', sorted(EXAMPLES.glob('*.py')), ids=lambda path: path.name)
def test_an_example_is_python_with_a_purpose(path):
    assert ast.get_docstring(ast.parse(path.read_text()))
