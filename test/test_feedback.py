# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What noise in the feedback of a controller does to a record, which no record tells."""

from dataclasses import replace

from made_task import everywhere
import numpy as np
import pytest

from booster_ros.diagnosis.data.experiment import Experiment, Initial
from booster_ros.diagnosis.estimation.parametrisation import declared_freedom
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.diagnosis.prepare.feedback import with_noise_of_feedback
from booster_ros.model.parameters import from_values
from booster_ros.model.position_controller import FINEST

TIME = np.arange(0.0, 48.0, 0.05)
SET_POINT = 1e-3 * np.array([8.0, 10.0, 9.0, 9.3, 6.0, 6.1, 11.0, 10.8])[(TIME // 6.0).astype(int)]
NOISE = {'chamber_pressure': 150.0, 'valve_position': 8e-6}
PULSES = {'output': 'pulses', 'gain': 0.005, 'integral_time': 0.0, 'derivative_time': 0.2,
          'dead_zone': 20e-6, 'least_pulse': 2e-4}


def valve(values):
    return from_values({f'position_controller.{name}': value
                        for name, value in {'enabled': True, **values}.items()})


def held(p, seed, noisy):
    """Return the experiment of a valve whose controller sees the stem with noise, or without."""
    rng = np.random.default_rng(seed)
    seen = noisy * FINEST * p.actuator.travel * rng.standard_normal(len(TIME))
    whole = Experiment(
        TIME, SET_POINT + seen, {name: np.zeros(len(TIME)) for name in NOISE}, NOISE, {},
        Initial(225e3, valve_position=8e-3), command='set_point')
    measured = {name: values + NOISE[name] * rng.standard_normal(len(TIME))
                for name, values in whole.predict(p).items()}
    return replace(whole, current=SET_POINT, measured=measured)


def test_of_a_controller_without_a_dead_zone_next_to_no_noise_comes_back():
    p = valve({})
    experiment = held(p, 1, noisy=False)
    assert with_noise_of_feedback(experiment, p) is experiment


def test_an_open_loop_has_no_feedback():
    p = valve(PULSES)
    experiment = replace(held(p, 1, noisy=False), command='control_current')
    assert with_noise_of_feedback(experiment, p) is experiment


def test_what_pulses_leave_to_chance_counts_as_noise_that_stays_for_a_while():
    p = valve(PULSES)
    quiet = held(p, 1, noisy=False)
    found = with_noise_of_feedback(quiet, p)
    apart = [held(p, seed, noisy=True) for seed in range(2, 22)]
    for name in NOISE:
        assert found.noise[name] > 1.2 * NOISE[name]
        assert 0.05 < found.chance[name].seconds < 8.0
        # other valves of the very same parameters are off by what is said
        off = np.sqrt(np.mean([(one.measured[name] - quiet.predict(p)[name])**2 for one in apart]))
        assert off == pytest.approx(found.noise[name], rel=0.5)
        share = 1.0 - (NOISE[name] / found.noise[name])**2
        assert found.chance[name].share == pytest.approx(share)


def test_steps_of_differences_reach_across_what_is_chance():
    p = valve(PULSES)
    plain = held(p, 1, noisy=True)
    problems = {}
    for experiment in (plain, with_noise_of_feedback(plain, p)):
        free = tuple(one for one in declared_freedom(p, experiment)
                     if one.knob.parameter in ('ep_converter.gain', 'actuator.viscous_friction'))
        problem = Problem(experiment, everywhere(experiment), p, free)
        z = problem.start()
        columns = [problem.jacobian(z + shift, problem.residuals(z + shift))[:problem.observed, 1]
                   for shift in 1e-3 * np.random.default_rng(1).standard_normal((6, len(z)))]
        usual = np.mean(columns, axis=0)
        problems[bool(experiment.chance)] = np.mean(
            [np.linalg.norm(one - usual) for one in columns])
    # a slope that hangs on the next pulse is none
    assert problems[True] < 0.2 * problems[False]
