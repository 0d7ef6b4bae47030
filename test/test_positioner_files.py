# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What ROS 2 gives the node of a parameter file is what the programs without ROS read in it."""

from __future__ import annotations

from positioner_here import positioner_here
import pytest

from booster_ros.parameters.file import read_parameter_file

PRESSURE = 'supply.pressure'


def sections(*named):
    """Return a file that gives one pressure in Pa after the other, each in a section so named."""
    return '\n'.join(
        f'{name}:\n  ros__parameters:\n    {PRESSURE}: {pressure}' for name, pressure in named)


@pytest.mark.parametrize('names', [
    ('positioner', '/**'),
    ('/**', 'positioner'),
    ('/**/positioner', '/**'),
    ('/**', '/*'),
    ('/*', '/positioner', '/**'),
    ('/**', '/positioner', '/**'),  # the last one stands where the first one does
    ('positioner', '/**', 'positioner'),
    ('positioner', '/**', '/positioner'),  # and these two are not written alike
    ('/positioner', '/**', 'positioner'),
])
def test_the_last_section_that_is_for_the_node_counts(tmp_path, names):
    path = tmp_path / 'p.yaml'
    path.write_text(sections(*((name, 4e5 + k) for k, name in enumerate(names))))
    with positioner_here('--params-file', str(path)) as node:
        in_force = node.get_parameter(PRESSURE).value
    assert read_parameter_file(path).physical[PRESSURE] == in_force
    assert read_parameter_file(path, '/positioner').physical[PRESSURE] == in_force


def test_it_counts_in_a_namespace_as_well(tmp_path):
    path = tmp_path / 'p.yaml'
    path.write_text(
        sections(('/a/**', 4e5), ('/**', 4.1e5)) + '\na:\n  ' + sections(
            ('positioner', 4.2e5)).replace('\n', '\n  ') + '\n' + sections(('/a/*', 4.3e5)))
    with positioner_here('-r', '__ns:=/a', '--params-file', str(path)) as node:
        in_force = node.get_parameter(PRESSURE).value
    assert in_force == 4.3e5
    assert read_parameter_file(path).physical[PRESSURE] == in_force
    assert read_parameter_file(path, '/a/positioner').physical[PRESSURE] == in_force
