# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What ROS 2 gives the node of a parameter file is what the programs without ROS read in it."""

from __future__ import annotations

from positioner_here import context_here, positioner_here
import pytest
from rclpy.node import Node

from booster_ros.model.parameters import ParameterError
from booster_ros.parameters.file import read_parameter_file
from booster_ros.parameters.sections import read_sections

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


SCALARS = """
400000 400_000 4_0.5 1_000 1:30 1:30.5 0b1 0x10 0X1f -0x10 0o17 017 09 08.5 0 00 -0 +5 -5 5. .5 +.5
-.5 . + 1e5 1E5 1.e5 1.0e+5 1e-5 e5 .e5 1e 1.5.5 1e5.5 ++5 --5 5f 5L 1,5 0x 0xG 0x.8p1 0x1P+3 0x1.8
9223372036854775807 9223372036854775808 -9223372036854775809 0xffffffffffffffff
17777777777777777777777 1e308 1e400 1e-307 1e-310 1e-400 0e-999 5e-324 0x1p5000
inf .inf -.inf +.Inf .iNf infinity -Infinity
nan .nan .NaN -nan -.nan NaN nan(12) y n Y yes No on OFF true True TRUE tRUE ~ null Null 2020-01-01
= << "400000" '5.0' "yes" !!str&5 !!str&true !!float&5 !!int&5.5 !!bool&"true" !foo&5 [1,2]
[1.0,1e5] [yes,off] [a,b] [+.5,.5] [0x10,010]
"""


def test_ros_reads_the_same_values_in_a_file(tmp_path):
    texts = SCALARS.split()
    path = tmp_path / 'p.yaml'
    path.write_text('/**:\n  ros__parameters:\n' + ''.join(
        f'    p{k}: {text.replace("&", " ")}\n' for k, text in enumerate(texts)))
    with context_here('--params-file', str(path)):
        node = Node('any', automatically_declare_parameters_from_overrides=True)
        values = [node.get_parameter(f'p{k}').value for k in range(len(texts))]
        node.destroy_node()
    ours = [entry.value for section in read_sections(path) for entry in section.entries]
    for text, value, our in zip(texts, values, ours, strict=True):
        value = list(value) if isinstance(our, list) else value
        assert (text, repr(our)) == (text, repr(value))


@pytest.mark.parametrize('text', ['400_000', '1:30', '1e400'])
def test_what_is_no_number_to_ros_is_refused_by_all_in_the_same_words(tmp_path, text):
    path = tmp_path / 'p.yaml'
    path.write_text(sections(('/**', text)))
    with pytest.raises(ParameterError, match=r'line 3: supply\.pressure must be') as without_ros:
        read_parameter_file(path)
    with pytest.raises(ParameterError) as refused, positioner_here('--params-file', str(path)):
        pass
    assert str(refused.value) == str(without_ros.value)
