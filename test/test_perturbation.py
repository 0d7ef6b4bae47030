# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What is chance in a record: stick-slip that grows from whatever disturbs the stem."""

import numpy as np
import pytest

from booster_ros.diagnosis.data.experiment import Experiment, Initial
from booster_ros.diagnosis.judging.perturbation import chance, differences
from booster_ros.model.parameters import from_values
from booster_ros.model.simulation import simulate

NOISE = {'chamber_pressure': 150.0, 'valve_position': 8e-6}
PACKING = {'actuator.coulomb_friction': 550.0, 'actuator.stiction': 190.0}
YIELDING = from_values(PACKING | {'actuator.presliding_stiffness': 2e7})
RIGID = from_values(PACKING)
DRY_FREE = from_values({})


def ramps() -> Experiment:
    """Return 40 s of ramps at which a packing makes the stem slip some ten times a second."""
    time = np.arange(4000) * 0.01
    current = np.interp(time, [0.0, 3.0, 3.0, 13.0, 15.0, 25.0, 27.0, 37.0, 40.0],
                        [0.36e-3, 0.36e-3, 0.39e-3, 0.44e-3, 0.44e-3, 0.38e-3, 0.38e-3, 0.45e-3,
                         0.45e-3])
    measured = {name: np.zeros(len(time)) for name in NOISE}
    return Experiment(time, current, measured, NOISE, {}, Initial(0.0))


def test_a_packing_that_yields_slips_when_chance_will_have_it():
    experiment = ramps()
    found = differences(experiment, YIELDING, experiment.initial)
    loose, tight = (simulate(YIELDING, experiment.time, experiment.current, tolerance=tolerance)
                    for tolerance in (1.0, 1e-3))
    for name in NOISE:  # that is no matter of the disturbance: solvers disagree as much
        solvers = float(np.sqrt(np.mean((loose[name] - tight[name])**2)))
        assert solvers > 0.2 * NOISE[name]
        assert found[name] == pytest.approx(solvers, rel=0.7)
    assert chance(experiment, YIELDING, experiment.initial) == {
        name: found[name] / noise for name, noise in NOISE.items()}


@pytest.mark.parametrize('parameters', [RIGID, DRY_FREE], ids=['rigid', 'without friction'])
def test_what_the_parameters_settle_is_no_chance(parameters):
    experiment = ramps()
    found = differences(experiment, parameters, experiment.initial)
    assert all(found[name] < 0.1 * NOISE[name] for name in NOISE)
    assert chance(experiment, parameters, experiment.initial) == {}


def test_a_measured_drive_is_disturbed_as_well():
    experiment = ramps()
    slow = simulate(RIGID, experiment.time, experiment.current)['chamber_pressure']
    driven = Experiment(experiment.time, np.zeros(len(slow)),
                        {'valve_position': np.zeros(len(slow))}, {'valve_position': 8e-6},
                        {'chamber_pressure': slow}, Initial(0.0))
    assert 0.0 < differences(driven, YIELDING, driven.initial)['valve_position'] < 1e-3
