# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Scoring the models of a diagnosis on another record, which no step of it has seen."""

from dataclasses import replace

import numpy as np

from booster_ros.diagnosis.experiment import UNITS, Experiment, rmse
from booster_ros.diagnosis.fit import Problem
from booster_ros.diagnosis.result import ChannelError, Diagnosis
from booster_ros.model.system import PositionerParameters

Array = np.ndarray

START = 5.0
"""Time from the beginning of the record that says where it starts, s."""


def validated(diagnosis: Diagnosis, experiment: Experiment) -> Diagnosis:
    """Return the diagnosis with the errors of its models on this experiment."""
    stages = (diagnosis.declared, diagnosis.before, diagnosis.after)
    runs = [predicted_from_start(experiment, parameters) for parameters in stages]
    everywhere = np.ones(len(experiment.time), dtype=bool)
    errors = {}
    for name, measured in experiment.measured.items():
        declared, before, after = (rmse(measured, run[name], everywhere) for run in runs)
        errors[name] = ChannelError(UNITS[name], declared, before, after, experiment.noise[name])
    return replace(diagnosis, validation=errors)


def predicted_from_start(
    experiment: Experiment, parameters: PositionerParameters
) -> dict[str, Array]:
    """Return what the model reads when nothing but its start is fitted, to the first seconds."""
    rows = experiment.time <= experiment.time[0] + START
    problem = Problem(experiment, rows, parameters, ())
    start = problem.fit().z if problem.nuisances and not experiment.quasi_static else (
        problem.start())
    return experiment.predict(parameters, problem.initial(start, parameters))
