# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters: checked one by one and together, with a sentence that names what is wrong."""

from array import array
import math

import numpy as np
import pytest

from booster_ros.model.parameters import (
    DESCRIPTIONS,
    ParameterError,
    from_values,
    to_values,
    unknown_name,
)
from booster_ros.model.system import PositionerParameters

DECLARED = {
    'ep_converter.gain': 244.45e3 / 0.4524e-3,
    'ep_converter.offset': 0.0,
    'ep_converter.time_constant': 0.034,
    'booster.s1': 13.52e-6,
    'booster.s2': 9.28e-6,
    'booster.s3': 3.14e-6,
    'booster.opening_gain': 2.75e-6,
    'booster.max_area': 1.45e-6,
    'booster.critical_pressure_ratio': 0.5283,
    'supply.pressure': 400e3,
    'supply.temperature': 293.15,
    'actuator.effective_area': 0.0796,
    'actuator.dead_volume': 0.185e-3,
    'actuator.polytropic_index': 1.0,
    'actuator.moving_mass': 4.0,
    'actuator.bench_set': (150e3, 300e3),
    'actuator.travel': 0.016,
    'actuator.viscous_friction': 3000.0,
}


def test_defaults_are_the_declared_positioner():
    values = to_values(from_values({}))
    assert {name: values[name] for name in DECLARED} == DECLARED


def test_values_and_parameters_are_inverse():
    changed = {'booster.orifice_law': 'isentropic', 'actuator.bench_set': [1e5, 2e5],
               'supply.pressure': 500_000, 'discrepancy.values': [0.5] * 12,
               'discrepancy.location': 'ep_converter', 'discrepancy.memory': 12.5,
               'discrepancy.variable': 'control_current_change'}
    parameters = from_values(changed)
    assert from_values(to_values(parameters)) == parameters
    values = to_values(parameters)
    assert values['booster.orifice_law'] == 'isentropic'
    assert values['actuator.bench_set'] == (1e5, 2e5)
    assert isinstance(values['supply.pressure'], float)


@pytest.mark.parametrize('name', DESCRIPTIONS)
def test_every_parameter_says_what_it_is(name):
    description = DESCRIPTIONS[name]
    assert description.unit
    assert len(description.meaning) > 5
    assert description.source
    numbers = description.default
    if not isinstance(numbers, tuple):
        numbers = (numbers,)
    for number in numbers:
        if not isinstance(number, str):
            assert description.low <= number <= description.high
    assert from_values({name: description.default}) == PositionerParameters()


NUMBERS = [name for name, description in DESCRIPTIONS.items()
           if not description.choices and not isinstance(description.default, bool)]


@pytest.mark.parametrize('name', NUMBERS)
@pytest.mark.parametrize('value', [math.nan, math.inf, -math.inf, 'many', None, True, np.True_, 1j])
def test_no_parameter_takes_what_is_no_number(name, value):
    if isinstance(DESCRIPTIONS[name].default, tuple):
        value = [value] * len(DESCRIPTIONS[name].default)
    with pytest.raises(ParameterError, match=name) as caught:
        from_values({name: value})
    assert '\n' not in str(caught.value)


@pytest.mark.parametrize(('sign', 'digits'), [(1, 309), (-1, 309), (1, 5000)])
def test_a_whole_number_that_no_float_holds_is_refused_and_not_quoted_at_length(sign, digits):
    value = sign * 10**digits
    for name, wrong in (('supply.pressure', value), ('discrepancy.values', [value] * 12),
                        ('booster.orifice_law', value), ('actuator.bench_set', [value])):
        with pytest.raises(ParameterError, match=name) as caught:
            from_values({name: wrong})
        assert len(str(caught.value)) < 150


@pytest.mark.parametrize('value', [1.0, 'yes', None])
def test_a_switch_takes_true_and_false_alone(value):
    with pytest.raises(ParameterError, match=r'position_controller.enabled'):
        from_values({'position_controller.enabled': value})
    assert from_values({'position_controller.enabled': True}).position_controller.enabled is True


@pytest.mark.parametrize(
    'name', [n for n in NUMBERS if math.isfinite(DESCRIPTIONS[n].high)])
def test_no_parameter_takes_what_is_out_of_its_range(name):
    description = DESCRIPTIONS[name]
    for value in (description.low - 1.0, description.high * 2.0 + 1.0):
        is_list = isinstance(description.default, tuple)
        wrong = [value] * len(description.default) if is_list else value
        with pytest.raises(ParameterError, match=rf'{name} must be between .* {description.unit}'.
                           replace('^', r'\^')):
            from_values({name: wrong})


@pytest.mark.parametrize(
    ('values', 'complaint'),
    [
        ({'booster.s1': 5e-6}, r'booster.s1 \(5e-06 m\^2\) must be greater than booster.s2'),
        ({'actuator.bench_set': array('d', [15e4])},
         r'actuator.bench_set must be a list of 2 numbers, got \[150000.0\]'),
        ({'booster.s3': 9.28e-6}, 'booster.s2 .* must be greater than booster.s3'),
        ({'supply.ripple': 400.1e3},
         r'supply.ripple \(400100 Pa\) must not be greater than supply.pressure \(400000 Pa\)'),
        ({'actuator.bench_set': [300e3, 150e3]}, 'actuator.bench_set must rise'),
        ({'actuator.bench_set': [150e3, 150e3]}, 'actuator.bench_set must rise'),
        ({'actuator.bench_set': [150e3]}, 'list of 2 numbers'),
        ({'actuator.bench_set': 150e3}, 'list of 2 numbers'),
        ({'actuator.added_volume': -0.2e-3}, 'dead_volume plus actuator.added_volume'),
        ({'actuator.lower_travel_lost': 0.4, 'actuator.upper_travel_lost': 0.6},
         'lower_travel_lost plus actuator.upper_travel_lost must be less than 1, got 1'),
        ({'booster.critical_pressure_ratio_shift': -0.6}, 'between 0 and 0.99'),
        ({'booster.orifice_law': 'linear'}, 'one of iso_6358, isentropic'),
        ({'discrepancy.knots': [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 5.0, 7.0, 8.0, 9.0, 10.0, 11.0]},
         'discrepancy.knots must rise from each value to the next'),
        ({'discrepancy.knots': [0.0, 1.0]}, 'discrepancy.knots must be a list of 12 numbers'),
        ({'discrepancy.location': 'supply', 'discrepancy.variable': 'valve_position'},
         'valve_position is nothing that a term in supply can follow'),
        ({'discrepancy.location': 'stem', 'discrepancy.variable': 'booster_force'},
         'booster_force is nothing that a term in stem can follow'),
        ({'discrepancy.location': 'chamber', 'discrepancy.variable': 'booster_force_play'},
         'booster_force_play is nothing that a term in chamber can follow'),
        ({'discrepancy.location': 'ep_converter', 'discrepancy.variable': 'back_pressure_error'},
         'back_pressure_error is nothing that a term in ep_converter can follow'),
        ({'discrepancy.location': 'ep_converter_lag', 'discrepancy.variable': 'time'},
         'time is nothing that a term in ep_converter_lag can follow'),
        ({'booster.s4': 1.0}, 'no parameter booster.s4'),
        ({'actuator.benchset': [1.0, 2.0]}, 'did you mean actuator.bench_set'),
    ],
)
def test_contradictions_and_misspelt_names_are_named(values, complaint):
    with pytest.raises(ParameterError, match=complaint):
        from_values(values)


@pytest.mark.parametrize('kind', [int, np.int64, np.float32, np.float64])
def test_numbers_of_every_kind_are_numbers(kind):
    p = from_values({'supply.pressure': kind(400_000),
                     'actuator.bench_set': np.array([150_000, 300_000], dtype=kind)})
    assert p == PositionerParameters()
    assert {type(p.supply.pressure), *map(type, p.actuator.bench_set)} == {float}


def test_a_name_like_no_other_gets_no_suggestion():
    assert 'did you mean' not in unknown_name('xyzzy', DESCRIPTIONS)
