# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Scoring the models of a diagnosis on another record, which no step of it has seen."""

from dataclasses import replace

import numpy as np

from booster_ros.diagnosis.data.experiment import Experiment, Initial
from booster_ros.diagnosis.estimation.fit import fit
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.diagnosis.judging.prediction_uncertainty import with_left_open
from booster_ros.diagnosis.prepare.start_state import FIRST_SECONDS
from booster_ros.diagnosis.result import STAGES, Diagnosis, OtherRecord, errors_of
from booster_ros.diagnosis.hypotheses.discrepancy import beyond
from booster_ros.model.discrepancy import covered
from booster_ros.model.system import PositionerParameters


def validated(diagnosis: Diagnosis, experiment: Experiment, notes: tuple[str, ...] = ()
              ) -> Diagnosis:
    """Return the diagnosis with the errors of its models on this experiment, and the rest."""
    models = [getattr(diagnosis, stage) for stage in STAGES]
    starts = [_start(experiment, parameters) for parameters in models]
    runs = {stage: experiment.predict(*one) for stage, one in zip(STAGES, zip(models, starts))}
    rows = np.ones(len(experiment.time), dtype=bool)
    errors = with_left_open(errors_of(experiment, runs, rows), experiment, runs['after'],
                            diagnosis.alike, rows, starts[-1])
    unknown = diagnosis.unknown
    outside = beyond(covered(unknown), experiment, diagnosis.after, starts[-1]) if unknown else 0.0
    return replace(diagnosis, validation=errors, other=OtherRecord(
        notes, experiment.drives, experiment.channels, float(np.mean(outside))))


def _start(experiment: Experiment, parameters: PositionerParameters) -> Initial:
    """Return the start that suits the first seconds of the record best."""
    rows = experiment.time <= experiment.time[0] + FIRST_SECONDS
    problem = Problem(experiment, rows, parameters, ())
    start = fit(problem).z if problem.nuisances and not experiment.quasi_static else (
        problem.start())
    return problem.initial(start, parameters)
