# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Experiments and tasks made of short simulations, for tests of the steps of a diagnosis."""

from dataclasses import replace

import numpy as np

from booster_ros.diagnosis.data.blocks import split
from booster_ros.diagnosis.data.experiment import Experiment, Initial
from booster_ros.diagnosis.estimation.parametrisation import declared_freedom
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.diagnosis.hypotheses.compose import with_effects
from booster_ros.diagnosis.selection.task import Task
from booster_ros.model.memory import Departure
from booster_ros.model.simulation import simulate
from booster_ros.model.system import PositionerParameters

P = PositionerParameters()
TIME = np.arange(0.0, 30.0, 0.02)
CURRENT = np.interp(TIME, [0.0, 5.0, 15.0, 20.0, 30.0], [3.6e-4, 3.6e-4, 4.4e-4, 3.8e-4, 3.8e-4])
START_PRESSURE = 1.7e5
RAMPS_TIME = np.arange(0.0, 120.0, 0.02)
RAMPS = np.interp(
    RAMPS_TIME, np.arange(0.0, 121.0, 6.0),
    1e-4 * np.array([4.0, 4.3, 4.1, 4.5, 4.2, 4.0, 4.4, 4.3, 4.6, 4.1, 4.2, 4.5, 4.0, 4.4, 4.2, 4.5,
                     4.3, 4.1, 4.4, 4.2, 4.3]))
STEPS = np.array([3.6, 4.0, 4.4, 4.1, 3.7, 3.5, 3.8, 4.2, 4.4, 4.2, 3.9, 3.6, 3.9, 4.3, 4.0, 3.7])


def seen(parameters, departure=None, pressure=START_PRESSURE, current=CURRENT, seed=1, time=TIME):
    """Return the experiment that a plant with these parameters would give, with its noise."""
    run = simulate(parameters, time, current, {'chamber_pressure': pressure},
                   departure=departure or Departure())
    rng = np.random.default_rng(seed)
    noise = {'chamber_pressure': 150.0, 'valve_position': 8e-6}
    measured = {name: run[f'measured_{name}'] + level * rng.standard_normal(len(time))
                for name, level in noise.items()}
    return Experiment(time, current, measured, noise, {}, Initial(pressure))


def steps_seen(parameters, levels, pressure, seed):
    """Return the experiment of steps to these currents (0.1 mA), 5 s each."""
    time = np.arange(0.0, 5.0 * len(levels), 0.02)
    current = 1e-4 * levels[(time // 5.0).astype(int)]
    return seen(parameters, None, pressure, current, seed, time)


def too_quiet(experiment, share=0.6):
    """Return the experiment with noise that is said to be less than it is."""
    return replace(experiment, noise={
        name: share * level for name, level in experiment.noise.items()})


def everywhere(experiment):
    """Return a mark on every row."""
    return np.ones(len(experiment.time), dtype=bool)


def task_of(experiment, names=(), freedoms=None):
    """Return the task of explaining an experiment by these effects."""
    free = tuple(declared_freedom(P, experiment)) if freedoms is None else freedoms
    return Task(experiment, split(experiment.time, experiment.current), P, free, tuple(names))


def problem_of(experiment, *effects, freedoms=None):
    """Return the problem of an experiment, every row of it, with these effects."""
    free = tuple(declared_freedom(P, experiment)) if freedoms is None else freedoms
    return with_effects(Problem(experiment, everywhere(experiment), P, free), effects)


def place_of(problem, parameter):
    """Return which variable of a problem a parameter is."""
    return [free.knob.parameter for free in problem.freedoms].index(parameter)


def z_of(problem, values):
    """Return z where parameters have these values, shapes are typical, and all else is as given."""
    z = problem.start()
    for j, free in enumerate(problem.freedoms):
        if free.knob.parameter in values:
            z[j] = free.variable(values[free.knob.parameter])
        elif free.knob.shape:
            z[j] = free.without_size
    return z
