# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Numbers as a report prints them: their digits and their units."""

import pytest

from booster_ros.report.engineering import digits_apart, number, scale_of, si_text, common_scale


@pytest.mark.parametrize(('value', 'digits', 'text'), [
    (0.0, 3, '0'), (151.26, 3, '151'), (0.99999, 3, '1.00'), (-0.01234, 3, '−0.0123'),
    (123456.7, 4, '123\u202f500'), (2.75e-6, 3, '2.75 × 10⁻⁶'), (5.4034e8, 4, '5.403 × 10⁸'),
    (float('nan'), 3, '–'), (9.996, 3, '10.0'),
])
def test_numbers_have_significant_digits(value, digits, text):
    assert number(value, digits) == text


@pytest.mark.parametrize(('value', 'unit', 'people', 'physics'), [
    (2.703e5, 'Pa', '270 kPa', '270\u202f000 Pa'), (8.1e-6, 'm', '8.10 µm', '8.10 × 10⁻⁶ m'),
    (0.0128, 'm', '12.8 mm', '0.0128 m'), (0.4524e-3, 'A', '0.452 mA', '0.000452 A'),
    (2.75e-6, 'm^2/N', '2.75 mm²/N', '2.75 × 10⁻⁶ m²/N'), (2e7, 'Pa s/kg', '20.0 kPa/(g/s)',
     '2.00 × 10⁷ Pa·s/kg'), (1.3, '-', '1.30', '1.30'), (550.0, 'N', '550 N', '550 N'),
])
def test_units_are_those_of_the_plant_beside_those_of_physics(value, unit, people, physics):
    assert scale_of(unit).text(value) == people
    assert si_text(value, unit) == physics


@pytest.mark.parametrize(('unit', 'values', 'read'), [
    ('m', (5.34e-4, 12e-6, 7.96e-6), ('534 µm', '12.0 µm', '7.96 µm')),
    ('m', (0.0128, 7.96e-6), ('12.8 mm', '7.96 µm')), ('m', (2e-3, 0.0), ('2.00 mm', '0 mm')),
    ('Pa', (5050.0, 149.0), ('5.05 kPa', '0.149 kPa')),
    ('m', (float('nan'),), ('– mm',)),
])
def test_values_that_are_compared_have_one_unit(unit, values, read):
    assert tuple(common_scale(unit, values).text(value) for value in values) == read


def test_the_ends_of_a_narrow_interval_look_different():
    assert digits_apart(480.0, 520.0) == 3
    assert [number(end, digits_apart(192.97, 193.12)) for end in (192.97, 193.12)] == [
        '193.0', '193.1']
    assert digits_apart(1.0, 1.0) == 3
    assert digits_apart(1.0, 1.0 + 1e-9) == 6
