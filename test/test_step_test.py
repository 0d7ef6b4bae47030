# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The paper's step test: its profile, and its responses found again in a record."""

import numpy as np
import pytest

from booster_ros.model.parameters import from_values
from booster_ros.model.simulation import simulate
from booster_ros.paper.printed import table_3
from booster_ros.paper.step_test import DURATION, DWELL, STEP_CURRENT, levels, upward_steps


def test_the_levels_are_the_papers():
    changes = [levels()[0]]
    for level in levels():
        if level != changes[-1]:
            changes.append(level)
    assert changes == [0.0, STEP_CURRENT, 0.0, STEP_CURRENT]
    assert len(levels()) * DWELL == DURATION


def test_the_model_gives_the_papers_simulated_column():
    rows_per_level = 200
    current = np.repeat(levels(), rows_per_level)
    time = np.arange(len(current)) * (DWELL / rows_per_level)
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
