# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Effects that are switched on while the plant runs: it goes on from where it is."""

import numpy as np
from positioner_runs import current_for, positioner
import pytest

from booster_ros.model.simulation import Plant, simulate

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


UP = float(current_for(330e3))
COAST = {'actuator.moving_mass': 200.0, 'actuator.viscous_friction': 100.0}
SLIGHT = {'actuator.coulomb_friction': 5.0}
FRICTION = {'actuator.coulomb_friction': 400.0}
YIELDING = FRICTION | {'actuator.presliding_stiffness': 1e7}


def moving(values):
    """Return a plant whose stem moves upwards by some mm/s."""
    plant = Plant(positioner(values))
    plant.reset(170e3, None, float(current_for(170e3)))
    plant.advance(UP, 2000)
    assert plant.outputs().stem_velocity > 2e-3
    return plant


@pytest.mark.parametrize('side', [1.0, -1.0], ids=['upwards', 'downwards'])
def test_a_slight_friction_slows_a_moving_stem_and_does_not_stop_it(side):
    """By F t/m against the present motion, whichever way it slid before."""
    plants = [moving(COAST | SLIGHT), moving(COAST | SLIGHT)]
    current = UP if side > 0.0 else 0.0
    for plant in plants:
        plant.parameters = positioner(COAST)
        plant.advance(current, 1000)
        assert side * plant.outputs().stem_velocity > 1e-3
    plants[0].parameters = positioner(COAST | SLIGHT)
    for plant in plants:
        plant.advance(current, 2)
    slowed, free = (plant.outputs().stem_velocity for plant in plants)
    assert free - slowed == pytest.approx(side * 5.0 * 2e-3 / 200.0, rel=0.05)


def test_a_packing_that_begins_to_yield_under_a_sliding_stem_holds_it_back_as_before():
    plant, rigid = moving(FRICTION), moving(FRICTION)
    plant.parameters = positioner(YIELDING)
    for one in (plant, rigid):
        one.advance(UP, 20)
    assert plant.outputs().stem_velocity == pytest.approx(rigid.outputs().stem_velocity, rel=0.01)


def test_a_friction_that_the_drive_cannot_overcome_ends_the_motion():
    plant = moving({})
    plant.parameters = positioner({'actuator.coulomb_friction': 4000.0})
    position = plant.outputs().valve_position
    plant.advance(UP, 10)
    assert plant.outputs().stem_velocity == 0.0
    assert 0.0 < plant.outputs().valve_position - position < 10e-6


@pytest.mark.parametrize(('before', 'after'), [
    (FRICTION, YIELDING), (YIELDING, FRICTION), ({}, FRICTION), ({}, YIELDING)],
    ids=['stuck, then yielding', 'yielding, then stuck', 'free, then stuck', 'free, then yielding'])
def test_a_stem_at_rest_stays_where_it_is(before, after):
    """As far from its balance as a friction that was there holds it."""
    held = before.get('actuator.coulomb_friction', 0.0)
    pressure = 150e3 + 75e3 + 0.9 * held / 0.0796
    plant = Plant(positioner(before))
    plant.reset(pressure, 8e-3, float(current_for(pressure)))
    plant.advance(float(current_for(pressure)), 200)
    plant.parameters = positioner(after)
    position = plant.outputs().valve_position
    plant.advance(float(current_for(pressure)), 200)
    assert plant.outputs().valve_position == pytest.approx(position, abs=0.2e-6)


def test_a_run_that_begins_with_a_sliding_stem_slides_on():
    time = np.array([0.0, 1e-4])
    start = {'chamber_pressure': 225e3, 'valve_position': 8e-3, 'stem_velocity': 2e-3}
    run = simulate(positioner(COAST | SLIGHT), time,
                   np.full(2, current_for(225e3)), start, compiled=False)
    assert run['stem_velocity'][1] == pytest.approx(2e-3, rel=0.01)
