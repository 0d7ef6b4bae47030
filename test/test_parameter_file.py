# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameter files in ROS 2's format, read and written without ROS."""

import os
from pathlib import Path
import re

from hypothesis import given, settings, strategies as st
import pytest
import yaml

from booster_ros.model.catalogue import is_of_effect, is_optional
from booster_ros.model.parameters import DESCRIPTIONS, ParameterError, from_values, to_values
from booster_ros.parameters.file import read_parameter_file, write_parameter_file
from booster_ros.parameters.sections import is_for

CONFIG = Path(__file__).parent.parent / 'config' / 'positioner.yaml'


@pytest.fixture
def file(tmp_path):
    """Return a function that writes a parameter file and returns its path."""
    def write(text):
        path = tmp_path / 'p.yaml'
        path.write_text(text)
        return path
    return write


def section(text, node='/**'):
    indented = '\n'.join(f'    {line}' for line in text.splitlines())
    return f'{node}:\n  ros__parameters:\n{indented}\n'


def test_the_shipped_file_is_the_default_positioner():
    read = read_parameter_file(CONFIG)
    assert from_values(read.physical) == from_values({})
    assert read.node == {}
    assert len(read.physical) == 18


def test_every_number_of_the_shipped_file_says_where_it_is_from():
    lines = [line for line in CONFIG.read_text().splitlines() if line[:1] == ' ']
    numbers = [line for line in lines if not line.split('#')[0].rstrip().endswith(':')]
    assert len(numbers) == 18
    assert all(len(line.partition('#')[2].split()) > 1 for line in numbers)


@pytest.mark.parametrize(('text', 'value'), [
    ('400000', 400e3), ('400e3', 400e3), ('4.0E+5', 400e3), ('4e5', 400e3), ('+4.e5', 400e3),
    ('0x10', 16.0), ('+.5', 0.5), ('010', 8.0),
])
def test_numbers_are_read_as_ros_reads_them(file, text, value):
    read = read_parameter_file(file(section(f'supply:\n  pressure: {text}')))
    assert read.physical == {'supply.pressure': value}
    assert isinstance(read.physical['supply.pressure'], float)


def test_dotted_names_lists_and_the_nodes_own_parameters(file):
    read = read_parameter_file(file(section(
        'actuator.bench_set: [140000, 290000]\npublish_rate: 50\ninvalid_current: limit\n'
        'use_sim_time: true\nqos_overrides./clock.subscription.depth: 3')))
    assert read.physical == {'actuator.bench_set': (140e3, 290e3)}
    assert read.node == {'publish_rate': 50.0, 'invalid_current': 'limit'}


def test_a_section_overrides_those_above_it_that_are_for_the_node_as_well(file):
    own = section('publish_rate: 20.0', 'positioner')
    general = section('publish_rate: 10.0\nstep_ticks: 3')
    other = section('anything: 1', 'fake_controller')
    path = file(general + own + other)
    assert read_parameter_file(path).node == {'publish_rate': 20.0, 'step_ticks': 3}
    assert read_parameter_file(path, '/positioner').node['publish_rate'] == 20.0
    assert read_parameter_file(path, '/a/positioner').node['publish_rate'] == 10.0
    assert read_parameter_file(file(own + general)).node['publish_rate'] == 10.0


@pytest.mark.parametrize('text', [
    'max_catch_up: 0.02\npublish_rate: 50', 'publish_rate: 0.01', 'max_catch_up: 0.01',
])
def test_the_longest_gap_that_is_caught_up_may_be_a_tick_or_a_second(file, text):
    assert read_parameter_file(file(section(text))).node


def test_nested_namespaces(file):
    path = file('line_a:\n  positioner:\n    ros__parameters:\n      step_ticks: 7\n')
    assert read_parameter_file(path).node == {'step_ticks': 7}
    assert read_parameter_file(path, '/line_a/positioner').node == {'step_ticks': 7}
    with pytest.raises(ParameterError, match=r'has no section for /line_b/positioner'):
        read_parameter_file(path, '/line_b/positioner')


@pytest.mark.parametrize(('first', 'second'), [
    ('/a/positioner', '/b/positioner'), ('/a/**', '/b/**'), ('/a/positioner', '/b/*'),
    ('/a/positioner', '/positioner'), ('/*', '/a/positioner'), ('/a/**/positioner', '/b/**'),
])
def test_two_positioners_in_one_file_must_be_told_apart(file, first, second):
    path = file(section('publish_rate: 50') + section('step_ticks: 1', first) + section(
        'step_ticks: 2', second))
    told = ', '.join(sorted((first, second)))
    with pytest.raises(ParameterError, match=re.escape(f'for {told}: more than one positioner')):
        read_parameter_file(path)


def test_of_two_positioners_in_one_file_the_full_name_tells_which(file):
    path = file(section('step_ticks: 1', '/a/positioner') + section('step_ticks: 2', '/b/**'))
    assert read_parameter_file(path, '/a/positioner').node == {'step_ticks': 1}
    assert read_parameter_file(path, '/b/positioner').node == {'step_ticks': 2}


@pytest.mark.parametrize('names', [
    ('/a/**', '/a/positioner'), ('/a/*', '/a/**'), ('/*/positioner', '/a/*'),
    ('/a/b/**', '/a/**/positioner', '/**/b/positioner'),
])
def test_sections_that_one_positioner_reads_are_taken_together(file, names):
    text = ''.join(section(f'step_ticks: {k}', name) for k, name in enumerate(names, 1))
    assert read_parameter_file(file(text)).node == {'step_ticks': len(names)}


@pytest.mark.parametrize(('text', 'sentence'), [
    (section('booster:\n  opening_gian: 1e-6'),
     'line 4: there is no parameter booster.opening_gian; did you mean booster.opening_gain?'),
    (section('supply:\n  pressure: 400_000'),
     "line 4: supply.pressure must be a number in Pa, got '400_000'"),
    (section('supply:\n  pressure: 1:30'), 'line 4: supply.pressure must be a number in Pa, got'),
    (section('supply:\n  pressure: 0b1'), 'line 4: supply.pressure must be a number in Pa, got'),
    (section('supply:\n  pressure: "4e5"'), 'line 4: supply.pressure must be a number in Pa, got'),
    (section('supply:\n  pressure: [{a: 1}]'), 'line 4: supply.pressure is a list, which holds'),
    (section('supply:\n  ? [pressure]\n  : 1'), 'line 4: a name must be a word'),
    (section('supply:\n  pressure: four'), 'line 4: supply.pressure must be a number in Pa'),
    (section('supply:\n  pressure: .nan'), 'line 4: supply.pressure must be finite'),
    (section('supply:\n  pressure:'), 'line 4: supply.pressure has no value'),
    (section('actuator:\n  bench_set: [150000, 300e3]'), 'line 4: actuator.bench_set mixes types'),
    (section('actuator:\n  bench_set: [3e5, 1e5]'), 'actuator.bench_set must rise'),
    (section('booster: {s1: 1e-6}'), 'booster.s1'),
    (section('step_ticks: 1.5'), 'line 3: step_ticks must be a whole number'),
    (section('step_ticks: 1000000001'),
     r'line 3: step_ticks must be a whole number from 1 to 1e\+09, got 1000000001'),
    pytest.param(section(f'supply:\n  pressure: {10**309}'),
                 "line 4: supply.pressure must be a number in Pa, got '1000",
                 id='310 digits'),
    pytest.param(section(f'supply:\n  pressure: 0x{"f" * 5000}'),
                 "line 4: supply.pressure must be a number in Pa, got '0xff",
                 id='thousands of digits'),
    pytest.param(section(f'start_paused: {10**309}'),
                 "line 3: start_paused must be true or false, got '1000.{55}[.]{3}$",
                 id='310 digits for a truth value'),
    (section('step_ticks: 1\nstep_ticks: 2'), 'line 4: step_ticks is given again, first in line 3'),
    (section('start_paused: 1'), 'line 3: start_paused must be true or false'),
    (section('invalid_current: clip'), 'invalid_current must be one of refuse, limit'),
    (section('publish_rate: 2000'), 'integration_step'),
    (section('max_catch_up: 0'), 'line 3: max_catch_up must be between 0.0001 and'),
    (section('max_catch_up: 0.019\npublish_rate: 50'),
     r'max_catch_up \(0.019 s\) must not be shorter than 0.02 s at a publish_rate of 50 Hz: '),
    (section('current_limits: [0.002, 0.0]'), 'current_limits must rise'),
    (section('initial_state: {control_current: 0.1}'), 'initial_state.control_current'),
    (section('initial_state: {valve_position: 0.1}'), 'initial_state.valve_position'),
    (section('step_ticks: 1', 'fake_controller'),
     r'has no section for positioner \(sections: /fake_controller\)'),
    ('supply:\n  pressure: 1\n', 'line 2: a ROS 2 parameter file has'),
    ('ros__parameters:\n  step_ticks: 1\n', 'line 1: `ros__parameters:` belongs below a node'),
    ('/**:\n  ros__parameters: 3\n', 'line 2: `ros__parameters:` holds no parameters'),
    ('', 'a ROS 2 parameter file has'),
    ('a: [1, 2\n', 'not YAML'),
    ('a: "\x01"', 'not YAML'),
    ('a: &x\n  b: *x\n', r'line 2: ROS 2 reads no aliases \(\*name\)'),
])
def test_what_is_wrong_is_said_in_one_sentence_with_its_place(file, text, sentence):
    path = file(text)
    with pytest.raises(ParameterError, match=sentence) as caught:
        read_parameter_file(path)
    assert str(caught.value).startswith(f'{path}')
    assert '\n' not in str(caught.value)


def test_a_file_that_is_not_there_or_not_text(tmp_path):
    with pytest.raises(ParameterError, match='No such file'):
        read_parameter_file(tmp_path / 'none.yaml')
    (tmp_path / 'b.yaml').write_bytes(b'\xff\xfe\x00')
    with pytest.raises(ParameterError, match='UTF-8'):
        read_parameter_file(tmp_path / 'b.yaml')


@given(st.dictionaries(
    st.sampled_from([n for n in DESCRIPTIONS if n.startswith('sensors.')]),
    st.floats(0.0, 1.0, allow_subnormal=False)))
@settings(max_examples=50, deadline=None)
def test_what_is_written_is_read_back_exactly(tmp_path_factory, values):
    path = tmp_path_factory.mktemp('written') / 'p.yaml'
    parameters = from_values(values)
    write_parameter_file(path, parameters)
    assert from_values(read_parameter_file(path).physical) == parameters


def test_what_is_too_small_for_ros_to_read_is_written_as_zero(tmp_path):
    path = tmp_path / 'p.yaml'
    write_parameter_file(path, from_values({'actuator.leak_area': 5e-324}))
    assert read_parameter_file(path).physical['actuator.leak_area'] == 0.0


@pytest.mark.parametrize(('values', 'comments', 'names'), [
    ({}, {}, set()),
    ({'actuator.stribeck_velocity': 2e-3}, {}, {'actuator.stribeck_velocity'}),
    ({}, {'actuator.presliding_stiffness': 'ADDED'}, {'actuator.presliding_stiffness'}),
])
def test_of_effects_what_is_as_by_default_is_not_written_unless_there_is_a_comment_on_it(
        tmp_path, values, comments, names):
    path = tmp_path / 'p.yaml'
    write_parameter_file(path, from_values(values), comments=comments)
    written = set(read_parameter_file(path).physical)
    assert {name for name in written if is_of_effect(name)} == names
    assert written - names == {name for name in DESCRIPTIONS if not is_optional(name)}


def test_a_written_file_is_plain_yaml_with_floats_that_every_reader_takes_for_floats(tmp_path):
    path = tmp_path / 'p.yaml'
    parameters = from_values({'booster.s3': 1e-6, 'actuator.leak_area': 2e-9,
                              'booster.orifice_law': 'isentropic'})
    write_parameter_file(path, parameters, heading='found\nby hand', comments={
        'actuator.leak_area': 'chamber_leak'})
    text = path.read_text()
    assert text.startswith('# found\n# by hand\n/**:\n  ros__parameters:\n')
    assert '      leak_area: 2.0e-09  # m^2; chamber_leak\n' in text
    assert 'coulomb_friction' not in text
    plain = yaml.safe_load(text)['/**']['ros__parameters']
    assert plain['booster']['s3'] == 1e-6
    assert plain['booster']['orifice_law'] == 'isentropic'
    assert plain['actuator']['bench_set'] == [150e3, 300e3]
    assert to_values(from_values(read_parameter_file(path).physical)) == to_values(parameters)


def test_a_file_is_written_completely_or_not_at_all(tmp_path, monkeypatch):
    path = tmp_path / 'p.yaml'
    path.write_text('as it was')

    def fail(*names):
        raise KeyboardInterrupt

    monkeypatch.setattr(os, 'replace', fail)
    with pytest.raises(KeyboardInterrupt):
        write_parameter_file(path, from_values({}))
    assert path.read_text() == 'as it was'
    assert os.listdir(tmp_path) == ['p.yaml']


@pytest.mark.parametrize(('name', 'node', 'matches'), [
    ('/**', '/positioner', True), ('/**', '/a/b/positioner', True),
    ('/*', '/positioner', True), ('/*', '/a/positioner', False),
    ('/*/positioner', '/a/positioner', True), ('/**/positioner', '/a/b/positioner', True),
    ('/**/positioner', '/positioner', True), ('/positioner', '/positioner', True),
    ('positioner', '/positioner', True), ('/positioner', '/a/positioner', False),
    ('/a/positioner', '/a/positioner2', False),
])
def test_which_sections_are_for_a_node(name, node, matches):
    assert is_for(name, node) is matches


@pytest.mark.parametrize(('text', 'sentence'), [
    ('# ' + 'x' * 1_000_000, 'has more than 1000000 bytes, which no parameter file has'),
    ('\n'.join(f'n{k}: {{ros__parameters: {{}}}}' for k in range(1001)), 'has 1001 sections'),
    (section('a: 1', '/**' * 335), 'line 1: a name is longer than 1000 characters'),
    (section(f'{"a" * 900}: 1'), r'line 3: there is no parameter a{60}\.\.\.$'),
], ids=['bytes', 'sections', 'section', 'name'])
def test_what_would_take_for_ever_to_read_is_refused(file, text, sentence):
    with pytest.raises(ParameterError, match=sentence):
        read_parameter_file(file(text))


def test_a_file_without_end_is_refused():
    with pytest.raises(ParameterError, match='/dev/zero: has more than 1000000 bytes'):
        read_parameter_file('/dev/zero')


def test_many_wildcards_are_matched_at_once():
    """Tried one way after the other they would take longer than anybody waits."""
    name = '/' + '/'.join('a' * 40) + '/positioner'
    assert not is_for('/**/a' * 20 + '/b', name)
    assert is_for('/**/a' * 20 + '/**', name)
