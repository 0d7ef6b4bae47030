# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Friction that a fit may begin with, wherever an earlier fit had got stuck."""

from made_diagnosis import NOISE
import numpy as np
import pytest

from booster_ros.diagnosis.experiment import Experiment, Initial
from booster_ros.diagnosis.fit import Problem
from booster_ros.diagnosis.friction_start import best_friction
from booster_ros.diagnosis.screening import with_effect
from booster_ros.model.catalogue import EFFECTS
from booster_ros.model.parameters import from_values
from booster_ros.model.simulation import simulate
from booster_ros.model.system import PositionerParameters

TIME = np.arange(0.0, 60.0, 0.04)
CURRENT = 0.41e-3 + 0.03e-3 * np.abs((TIME / 12.0) % 2.0 - 1.0) + 0.015e-3 * (TIME % 17.0 > 9.0)


def problem_of(values, effect='stem_friction'):
    """Return the fit of friction alone to a noisy record of a valve with this friction."""
    start = {'chamber_pressure': 250e3}
    run = simulate(from_values(values), TIME, CURRENT, start)
    rng = np.random.default_rng(5)
    measured = {name: run[name] + level * rng.standard_normal(len(TIME))
                for name, level in NOISE.items()}
    initial = Initial(start['chamber_pressure'], valve_position=float(run['valve_position'][0]))
    experiment = Experiment(TIME, CURRENT, measured, NOISE, {}, initial)
    rows = np.ones(len(TIME), dtype=bool)
    return with_effect(Problem(experiment, rows, PositionerParameters(), ()), EFFECTS[effect])


def far_off(problem):
    """Return z of friction that is a fraction of what it was, on a packing that yields."""
    z = problem.start()
    far = {'actuator.coulomb_friction': 120.0, 'actuator.presliding_stiffness': 5e7,
           'actuator.stribeck_velocity': 0.004}
    for j, free in enumerate(problem.freedoms):
        if free.knob.parameter in far:
            z[j] = free.variable(far[free.knob.parameter])
    return z


RIGID = {'actuator.coulomb_friction': 380.0, 'actuator.stiction': 130.0}


@pytest.mark.parametrize('values', [
    RIGID, RIGID | {'actuator.presliding_stiffness': 2e7}, {'actuator.coulomb_friction': 900.0},
], ids=['sticks', 'yields', 'no stiction'])
def test_friction_is_found_from_far_off(values):
    problem = problem_of(values)
    found = problem.parameters(best_friction(problem, far_off(problem))).actuator
    assert found.coulomb_friction == pytest.approx(values['actuator.coulomb_friction'], rel=0.15)
    assert found.stiction == pytest.approx(values.get('actuator.stiction', 0.0), abs=100.0)
    assert found.presliding_stiffness <= 2e7 or 'actuator.presliding_stiffness' in values


def test_a_fit_from_there_ends_where_one_from_far_off_does_not_come():
    problem = problem_of(RIGID)
    stuck = problem.fit(far_off(problem), 10)
    found = problem.fit_through_slips(best_friction(problem, stuck.z), 10)
    missed, left = (float(np.sum(problem.means(fit.z)**2)) for fit in (stuck, found))
    assert left < 0.7 * missed
    assert abs(stuck.parameters.actuator.coulomb_friction - 380.0) > 50.0
    assert abs(found.parameters.actuator.coulomb_friction - 380.0) < 20.0


def test_of_friction_along_the_travel_the_gradient_stays():
    problem = problem_of({'actuator.coulomb_friction': 400.0, 'actuator.friction_gradient': 300.0},
                         'position_dependent_friction')
    names = [free.knob.parameter for free in problem.freedoms]
    z = far_off(problem)
    z[names.index('actuator.friction_gradient')] = 0.4
    moved = best_friction(problem, z)
    assert moved[names.index('actuator.friction_gradient')] == 0.4
    assert moved[names.index('actuator.coulomb_friction')] != z[0]


def test_where_no_friction_is_free_nothing_is_tried(monkeypatch):
    problem = problem_of(RIGID, 'chamber_leak')
    monkeypatch.setattr(Problem, 'means', None)
    z = problem.start() + 0.1
    assert best_friction(problem, z) is z
