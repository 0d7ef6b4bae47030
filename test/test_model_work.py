# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How often the solver evaluates the equations: counts, not times, guard its speed."""

import numpy as np
import pytest

from booster_ros.benchmark import cases
from booster_ros.model import dormand_prince, rodas3, solver
from booster_ros.model.parameters import DESCRIPTIONS, from_values
from booster_ros.model.simulation import simulate


@pytest.fixture
def evaluations(monkeypatch):
    """Return a function that simulates a case and returns evaluations per row."""
    derivatives = rodas3.derivatives

    def per_row(case: cases.Case) -> float:
        count = 0

        def counting(*arguments):
            nonlocal count
            count += 1
            return derivatives(*arguments)

        for module in (solver, rodas3, dormand_prince):
            monkeypatch.setattr(module, 'derivatives', counting)
        run = simulate(
            case.parameters, case.time, case.control_current, case.initial, compiled=False)
        assert run['valve_position'].max() - run['valve_position'].min() > 0.5e-3
        return count / len(case.time)

    return per_row


def test_a_row_with_a_new_current_takes_one_step(evaluations):
    """Its rates, 4 more for the Jacobian, 2 stages; a few rows need more than one step."""
    assert 7.0 <= evaluations(cases.moving_command(4.0)) < 9.0


def test_while_the_current_stands_a_step_takes_several_rows(evaluations):
    assert evaluations(cases.paper_test(4.0)) < 0.5 * 7.0


def test_a_sliding_stem_takes_several_rows_a_step_too(evaluations):
    case = cases.paper_test(4.0)
    dry = from_values({'actuator.coulomb_friction': 200.0})
    assert evaluations(case._replace(parameters=dry)) < 0.5 * 7.0


def test_stick_slip_costs_less_than_twice_as_much(evaluations):
    """Four jumps per second at 130 evaluations each; rows at rest take 5."""
    assert evaluations(cases.stick_slip(20.0)) < 2.0 * 7.0


def test_the_hardest_stops_cost_little_more_than_usual_ones(evaluations):
    """The stem runs onto its seat in the fourth second."""
    hardest = from_values({'actuator.stop_stiffness': DESCRIPTIONS['actuator.stop_stiffness'].high})
    case = cases.paper_test(8.0)
    closing = case._replace(
        control_current=np.where(case.time < 3.0, case.control_current[-1], 0.3e-3))
    usual = evaluations(closing)
    assert evaluations(closing._replace(parameters=hardest)) < 3.0 * usual
