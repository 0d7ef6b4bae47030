# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The paper's step test: its profile, and its responses found again in a record."""

import numpy as np
import pytest

from booster_ros.model.parameters import from_values
from booster_ros.model.simulation import simulate
from booster_ros.paper.printed import table_3
from booster_ros.paper.step_test import STEP_CURRENT, profile, upward_steps


def test_profile_is_the_papers():
    time, current = profile()
    assert list(current[:4]) == [0.0, STEP_CURRENT, 0.0, STEP_CURRENT]
    assert np.all(np.diff(time) > 0.0)


def test_the_model_gives_the_papers_simulated_column():
    corners, currents = profile()
    time = np.arange(0.0, corners[-1], 0.01)
    current = currents[np.searchsorted(corners, time, side='right') - 1]
    run = simulate(from_values({}), time, current)
    responses = upward_steps(time, current, run['chamber_pressure'])
    assert len(responses) == 2
    for response in responses:
        for name, value in response.indices()._asdict().items():
            assert value == pytest.approx(table_3()[name].simulated, rel=0.01), name


def test_rows_that_hold_only_some_of_the_columns():
    nan = np.nan
    time = np.array([0.0, 1.0, 1.5, 2.0, 3.0, 4.0])
    current = np.array([0.0, nan, 1e-3, nan, 1e-3, 0.0])
    pressure = np.array([nan, 5.0, nan, 7.0, 8.0, 2.0])
    (response,) = upward_steps(time, current, pressure)
    assert response.time.tolist() == [1.5, 2.0, 3.0]
    assert response.pressure.tolist() == [5.0, 7.0, 8.0]


def test_a_step_before_any_pressure_is_refused():
    with pytest.raises(ValueError, match=r'before the step at 1\.000 s'):
        upward_steps(np.array([0.0, 1.0, 2.0]), np.array([0.0, 1.0, 1.0]), np.array([np.nan] * 3))
