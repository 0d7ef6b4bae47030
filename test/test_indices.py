# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The indices of a step response, on responses whose indices are known in closed form."""

from hypothesis import given, strategies
import numpy as np
import pytest

from booster_ros.paper.indices import (
    integral_square_error,
    rise_time,
    settling_time,
    step_indices,
)


def first_order(time: np.ndarray, height: float = 1.0, lag: float = 2.0) -> np.ndarray:
    return height * (1.0 - np.exp(-time / lag))


TIME = np.linspace(0.0, 40.0, 40_001)


def test_first_order_lag():
    response = first_order(TIME, height=3.0, lag=2.0)
    assert rise_time(TIME, response) == pytest.approx(2.0 * np.log(9.0), rel=1e-6)
    assert settling_time(TIME, response) == pytest.approx(2.0 * np.log(20.0), rel=1e-6)
    assert integral_square_error(TIME, response) == pytest.approx(3.0**2 * 2.0 / 2.0, rel=1e-6)


def test_a_straight_line_is_exact_however_coarse_its_rows():
    time = np.array([0.0, 10.0, 20.0])
    response = np.array([0.0, 5.0, 5.0])
    assert rise_time(time, response) == pytest.approx(8.0)
    assert settling_time(time, response) == pytest.approx(9.5)
    assert integral_square_error(time, response) == pytest.approx(5.0**2 * 10.0 / 3.0)


def test_settling_counts_the_last_excursion():
    time = np.arange(6.0)
    response = np.array([0.0, 1.0, 1.0, 1.2, 1.0, 1.0])
    assert settling_time(time, response) == pytest.approx(3.75)


def test_a_known_final_value_is_used_instead_of_the_last_row():
    early = TIME < 8.0
    response = first_order(TIME)
    assert rise_time(TIME[early], response[early], final=1.0) == pytest.approx(
        rise_time(TIME, response), rel=1e-6
    )
    assert rise_time(TIME[early], response[early]) < rise_time(TIME, response) - 0.1


@given(
    height=strategies.floats(1e-3, 1e6) | strategies.floats(-1e6, -1e-3),
    offset=strategies.floats(-1e6, 1e6),
    start=strategies.floats(-1e3, 1e3),
)
def test_times_depend_on_neither_unit_nor_offset_nor_direction(height, offset, start):
    base = first_order(TIME)
    shifted = offset + height * base
    assert rise_time(TIME + start, shifted) == pytest.approx(rise_time(TIME, base), rel=1e-4)
    assert settling_time(TIME + start, shifted) == pytest.approx(
        settling_time(TIME, base), rel=1e-4
    )


def test_table_units():
    indices = step_indices(TIME, first_order(TIME, height=200e3))
    assert indices.final_pressure == pytest.approx(200.0, rel=1e-6)
    assert indices.integral_square_error == pytest.approx(200.0**2, rel=1e-6)


@pytest.mark.parametrize(
    ('response', 'complaint'),
    [
        (np.ones(3), 'ends where it began'),
        (np.array([0.0, 1.0, 0.5, np.nan]), 'ends where it began'),
    ],
)
def test_a_response_without_a_step_is_refused(response, complaint):
    with pytest.raises(ValueError, match=complaint):
        rise_time(np.arange(float(len(response))), response)


def test_a_response_that_still_moves_is_refused():
    with pytest.raises(ValueError, match='not settled'):
        settling_time(np.arange(3.0), np.array([0.0, 0.5, 0.6]), final=1.0)
    with pytest.raises(ValueError, match='does not reach 90'):
        rise_time(np.arange(3.0), np.array([0.0, 0.5, 0.6]), final=1.0)
