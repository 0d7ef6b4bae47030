# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Air through an orifice: both laws, their symmetry, and where there must be no flow."""

import math

from hypothesis import given, strategies
import numpy as np
import pytest

from booster_ros.model.gas import (
    CHOKED_FLOW_FACTOR,
    ISENTROPIC,
    ISENTROPIC_CRITICAL_RATIO,
    ISO_6358,
    flow_function,
    isentropic_flow_function,
    iso_6358_flow_function,
    orifice_flow,
)

LAWS = [ISO_6358, ISENTROPIC]
pressures = strategies.floats(50e3, 2e6)
temperatures = strategies.floats(200.0, 400.0)
laws = strategies.sampled_from(LAWS)
ratios = strategies.floats(0.05, 0.9)


def test_constants_are_the_corrected_ones():
    """The paper's exponent (k+1)/k would make the factor 48 % larger."""
    assert pytest.approx(0.040418, abs=1e-6) == CHOKED_FLOW_FACTOR
    assert pytest.approx(0.52828, abs=1e-5) == ISENTROPIC_CRITICAL_RATIO


def test_choked_flow_by_hand():
    flow = orifice_flow(1.45e-6, 501_325.0, 101_325.0, 293.15, 293.15, 0.5283, ISO_6358)
    assert flow == pytest.approx(0.040418 * 1.45e-6 * 501_325.0 / math.sqrt(293.15), rel=1e-4)


@given(area=strategies.floats(1e-9, 1e-3), pressure=pressures, temperature=temperatures, law=laws)
def test_no_flow_at_equal_pressures(area, pressure, temperature, law):
    assert orifice_flow(area, pressure, pressure, temperature, 300.0, 0.5283, law) == 0.0


@given(one=pressures, other=pressures, law=laws)
def test_no_flow_without_an_area(one, other, law):
    assert orifice_flow(0.0, one, other, 293.15, 293.15, 0.5283, law) == 0.0


@given(
    one=pressures, other=pressures, t_one=temperatures, t_other=temperatures, b=ratios, law=laws
)
def test_turning_an_orifice_round_turns_the_flow_round(one, other, t_one, t_other, b, law):
    forth = orifice_flow(1e-6, one, other, t_one, t_other, b, law)
    back = orifice_flow(1e-6, other, one, t_other, t_one, b, law)
    assert forth == -back
    assert forth * (one - other) >= 0.0


@given(one=pressures, other=pressures, b=ratios, law=laws, scale=strategies.floats(0.1, 10.0))
def test_flow_is_proportional_to_area_and_to_all_pressures(one, other, b, law, scale):
    flow = orifice_flow(1e-6, one, other, 293.15, 293.15, b, law)
    wider = orifice_flow(scale * 1e-6, one, other, 293.15, 293.15, b, law)
    denser = orifice_flow(1e-6, scale * one, scale * other, 293.15, 293.15, b, law)
    assert wider == pytest.approx(scale * flow, rel=1e-12)
    # pressures may be equal but for their last bit, where a ratio has no more digits
    assert denser == pytest.approx(scale * flow, rel=1e-6, abs=1e-15)


@pytest.mark.parametrize('law', LAWS)
def test_flow_function_falls_steadily_to_zero(law):
    values = np.array([flow_function(r, 0.5283, law) for r in np.linspace(0.0, 1.0, 20_001)])
    assert values[0] == 1.0
    assert values[-1] == 0.0
    assert np.all(np.diff(values) <= 1e-12)
    assert np.all(np.diff(values[10_600:]) < 0.0)


@pytest.mark.parametrize('law', LAWS)
def test_continuation_near_ratio_1_is_smooth_where_it_begins(law):
    def slope(at: float, by: float) -> float:
        return (flow_function(at + by, 0.5283, law) - flow_function(at, 0.5283, law)) / by

    assert slope(0.999, 1e-7) == pytest.approx(slope(0.999, -1e-7), rel=2e-3)
    # and finite where both laws themselves are infinitely steep
    assert abs(slope(1.0, -1e-9)) < 100.0


def test_both_laws_agree():
    """Largest relative distance between the ellipse and the isentropic nozzle: 0.3 %."""
    subsonic = np.linspace(0.53, 0.999, 4_000)
    ellipse = np.array([iso_6358_flow_function(r, ISENTROPIC_CRITICAL_RATIO) for r in subsonic])
    exact = np.array([isentropic_flow_function(r) for r in subsonic])
    distance = np.abs(ellipse / exact - 1.0)
    assert distance.max() == pytest.approx(0.003, abs=1e-4)
    assert np.abs(ellipse - exact).max() < 1.6e-3
