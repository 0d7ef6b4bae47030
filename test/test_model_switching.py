# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Effects that are switched on while the plant runs: it goes on from where it is."""

from positioner_runs import positioner
import pytest

from booster_ros.model.simulation import Plant

GAIN = 244.45e3 / 0.4524e-3
HYSTERESIS = {'ep_converter.hysteresis': 4e-6}
MIDDLE, FAR = 0.45e-3, 0.02e-3


@pytest.mark.parametrize('before', [{}, HYSTERESIS], ids=['never on', 'on and off again'])
@pytest.mark.parametrize('side', [-1.0, 1.0], ids=['after a rise', 'after a fall'])
def test_a_hysteresis_begins_where_the_current_stands(before, side):
    """What comes then lags by half its width, whatever was before it was switched on."""
    plant = Plant(positioner(before))
    plant.reset(control_current=MIDDLE + side * FAR)
    plant.advance(MIDDLE + side * FAR, 100)
    plant.parameters = positioner()
    plant.advance(MIDDLE, 1000)
    assert plant.outputs().back_pressure == pytest.approx(GAIN * MIDDLE, abs=1.0)
    plant.parameters = positioner(HYSTERESIS)
    plant.advance(MIDDLE, 1000)
    assert plant.outputs().back_pressure == pytest.approx(GAIN * MIDDLE, abs=1.0)
    plant.advance(MIDDLE + side * 3e-6, 1000)
    assert plant.outputs().back_pressure == pytest.approx(
        GAIN * (MIDDLE + side * 1e-6), abs=1.0)
