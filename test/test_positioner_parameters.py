# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of a running positioner: described, checked together, changed between ticks."""

from __future__ import annotations

import re

from diagnostic_msgs.msg import DiagnosticArray
from positioner_process import Bench, details, report_of, start, with_parameters
import pytest
from rcl_interfaces.srv import DescribeParameters, GetParameters, ListParameters, SetParameters
from rclpy.parameter import Parameter
from ros_client import RosClient
from std_msgs.msg import Float64

from booster_ros.model.parameters import from_values
from booster_ros.model.simulation import Plant
from booster_ros.nodes.declaration import effective_values
from booster_ros.parameters.schema import ALL_DESCRIPTIONS


@pytest.fixture(scope='module')
def shared_bench():
    with start(*with_parameters(start_paused='true')) as node, RosClient() as client:
        yield Bench(client)
        assert node.interrupt() == 0, node.output
        assert 'Traceback' not in node.output


@pytest.fixture
def bench(shared_bench):
    shared_bench.trigger('reset')
    yield shared_bench
    shared_bench.client.forget()


def value_of(bench, name):
    request = GetParameters.Request(names=[name])
    value = bench.client.call('positioner/get_parameters', GetParameters, request).values[0]
    return value.double_value


def test_every_parameter_is_declared_with_unit_meaning_and_range(bench):
    listed = bench.client.call(
        'positioner/list_parameters', ListParameters, ListParameters.Request()).result.names
    assert set(ALL_DESCRIPTIONS) <= set(listed)
    request = DescribeParameters.Request(names=list(ALL_DESCRIPTIONS))
    described = bench.client.call(
        'positioner/describe_parameters', DescribeParameters, request).descriptors
    for descriptor, description in zip(described, ALL_DESCRIPTIONS.values(), strict=True):
        assert descriptor.description == f'{description.meaning} [{description.unit}]'
        assert descriptor.additional_constraints
    supply = described[list(ALL_DESCRIPTIONS).index('supply.pressure')]
    limits = ALL_DESCRIPTIONS['supply.pressure']
    assert supply.floating_point_range[0].from_value == limits.low
    assert supply.floating_point_range[0].to_value == limits.high


@pytest.mark.parametrize(('values', 'reason'), [
    ({'actuator__bench_set': [3e5, 1e5]}, 'actuator.bench_set must rise'),
    ({'booster__s2': 2e-5}, 'booster.s1 .* must be greater than booster.s2'),
    ({'supply__pressure': float('nan')}, 'supply.pressure'),
    ({'supply__pressure': 'much'}, "expected 'Type.DOUBLE'"),
    ({'supply__pressure': '4_0_0'}, "expected 'Type.DOUBLE'"),
    ({'supply__pressure': True}, "expected 'Type.DOUBLE'"),
    ({'supply__pressure': 'yes'}, "expected 'Type.DOUBLE'"),
    ({'current_limits': [False, True]}, "expected 'Type.DOUBLE_ARRAY'"),
    ({'current_limits': ['0', '1e-3']}, "expected 'Type.DOUBLE_ARRAY'"),
    ({'current_limits': [b'0', b'1']}, "expected 'Type.DOUBLE_ARRAY'"),
    ({'publish_rate': 50.0}, 'read-only parameter: publish_rate'),
    ({'integration_step': 1e-4}, 'read-only parameter: integration_step'),
    ({'current_limits': [0.0, 0.0]}, 'current_limits must rise'),
    ({'max_catch_up': 0.0}, 'max_catch_up'),
    ({'max_catch_up': 9e-3}, r'max_catch_up \(0.009 s\) must not be shorter than 0.01 s'),
    ({'booster__orifice_law': 'linear'}, 'booster.orifice_law must be one of'),
    ({'supply__pressure': 3e5, 'booster__s2': 2e-5}, 'booster.s1'),
])
def test_a_bad_change_is_refused_with_the_reason_and_nothing_is_changed(bench, values, reason):
    result = bench.set(**values)
    assert not result.successful
    assert re.search(reason, result.reason), result.reason
    assert value_of(bench, 'supply.pressure') == 400e3
    assert value_of(bench, 'booster.s2') == 9.28e-6


@pytest.mark.parametrize('value', [410_000, 410e3, '410e3', '4.1e5'])
def test_numbers_are_taken_as_they_are_typed(bench, value):
    assert bench.set(supply__pressure=value).successful
    assert value_of(bench, 'supply.pressure') == 410e3
    assert bench.set(supply__pressure=400e3).successful


def test_the_log_names_parameters_of_effects_only_where_they_are_other_than_by_default():
    values = {name: description.default for name, description in ALL_DESCRIPTIONS.items()}
    text = effective_values(values)
    assert 'stop_damping 100000.0' in text
    assert not any(name.rpartition('.')[2] in re.split(r'\W+', text) for name in (
        'actuator.presliding_stiffness', 'ep_converter.nonlinearity_centre', 'discrepancy.reach'))
    assert '*stribeck_velocity 0.002' in effective_values(
        values | {'actuator.stribeck_velocity': 2e-3})


def test_values_that_only_fit_together_are_set_together(bench):
    assert not bench.set(booster__s1=8e-6).successful
    assert bench.set(booster__s1=8e-6, booster__s2=5e-6).successful
    assert value_of(bench, 'booster.s1') == 8e-6
    assert bench.set(booster__s1=13.52e-6, booster__s2=9.28e-6).successful


def test_a_change_of_the_physics_keeps_the_state_and_acts_from_the_next_tick(bench):
    diagnostics = bench.client.listen('/diagnostics', DiagnosticArray)
    pressures, = bench.listen(chamber_pressure=Float64)
    bench.command(4e-4)
    bench.step(20)
    assert bench.set(actuator__leak_area=1e-6, actuator__bench_set=[140_000, 290_000]).successful
    bench.step(20)
    bench.client.spin_until(lambda: len(pressures) >= 40)
    bench.client.spin_until(lambda: any(
        'actuator.leak_area = 1e-06' in report_of(message, 'parameters').message
        for message in diagnostics))
    assert bench.set(actuator__leak_area=0.0, actuator__bench_set=[150e3, 300e3]).successful

    plant = Plant(from_values({}))
    for _ in range(20):
        plant.advance(4e-4, 10)
    plant.parameters = from_values(
        {'actuator.leak_area': 1e-6, 'actuator.bench_set': (140e3, 290e3)})
    for _ in range(20):
        plant.advance(4e-4, 10)
    assert pressures[-1].data == plant.outputs().measured_chamber_pressure


def set_all(bench, values):
    """Set parameters as `ros2 param load` does, and return the results."""
    request = SetParameters.Request(parameters=[
        Parameter(name, value=value).to_parameter_msg() for name, value in values.items()])
    return bench.client.call('positioner/set_parameters', SetParameters, request).results


def test_a_file_is_loaded_as_a_whole_or_not_at_all(bench):
    other = {'booster.s1': 2e-5, 'booster.s2': 1.5e-5, 'booster.s3': 1.6e-5, 'publish_rate': 100.0}
    results = set_all(bench, other)
    assert [result.successful for result in results] == [False, False, False, True]
    assert 'booster.s2 (1.5e-05 m^2) must be greater than booster.s3' in results[0].reason
    assert results[0].reason.endswith('(none of 3 changed parameters has been set)')
    assert [value_of(bench, f'booster.s{n}') for n in (1, 2, 3)] == [13.52e-6, 9.28e-6, 3.14e-6]
    assert all(result.successful for result in set_all(bench, other | {'booster.s3': 1e-5}))
    assert value_of(bench, 'booster.s3') == 1e-5
    assert all(result.successful for result in set_all(
        bench, {'booster.s1': 13.52e-6, 'booster.s2': 9.28e-6, 'booster.s3': 3.14e-6}))


def test_values_that_are_in_force_are_no_change(bench):
    diagnostics = bench.client.listen('/diagnostics', DiagnosticArray)

    def changes():
        diagnostics.clear()
        bench.client.spin_until(lambda: len(diagnostics) > 1)
        return details(report_of(diagnostics[-1], 'parameters'))['changes']

    before = changes()
    assert bench.set(
        supply__pressure=400_000, current_limits=[0.0, 2e-3], publish_rate=100.0).successful
    assert bench.set(publish_rate=100.0).successful
    assert changes() == before
    assert bench.set(supply__pressure=410e3).successful
    assert changes() == str(int(before) + 1)
    assert bench.set(supply__pressure=400e3).successful
