# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Scoring the models of a diagnosis on another record, which no step of it has seen."""

from dataclasses import replace

import numpy as np

from booster_ros.diagnosis.data.experiment import Experiment, Initial
from booster_ros.diagnosis.estimation.fit import fit
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.diagnosis.judging.prediction_uncertainty import with_left_open
from booster_ros.diagnosis.judging.perturbation import chance
from booster_ros.diagnosis.prepare.start_state import FIRST_SECONDS
from booster_ros.diagnosis.result import WORTH_SAYING, Diagnosis, errors_of
from booster_ros.diagnosis.hypotheses.discrepancy import beyond
from booster_ros.model.booster import largest_exhaust_area
from booster_ros.model.system import PositionerParameters, depends_on_time

Array = np.ndarray


def validated(
    diagnosis: Diagnosis, experiment: Experiment, notes: tuple[str, ...] = ()
) -> Diagnosis:
    """Return the diagnosis with the errors of its models on this experiment, and notes on it."""
    stages = (diagnosis.declared, diagnosis.before, diagnosis.after)
    starts = [_start(experiment, parameters) for parameters in stages]
    runs = {stage: experiment.predict(*one) for stage, one in zip(
        ('declared', 'before', 'after'), zip(stages, starts))}
    rows = np.ones(len(experiment.time), dtype=bool)
    errors = with_left_open(errors_of(experiment, runs, rows), experiment, runs['after'],
                            diagnosis.alike, rows, starts[-1])
    return replace(diagnosis, validation=errors, notes=(
        *diagnosis.notes, *(f'the other record: {note}' for note in notes),
        *_of_other_channels(diagnosis.experiment, experiment),
        *_beyond(diagnosis, experiment, starts[-1]), *_in_another_phase(diagnosis),
        *_opened_further(diagnosis, experiment, starts[-1]),
        *chance(experiment, diagnosis.after, starts[-1], 'the other record')))


def _of_other_channels(first: Experiment, other: Experiment) -> tuple[str, ...]:
    """Return a sentence where the records are not driven by, or compared in, the same channels."""
    if set(first.drives) == set(other.drives) and set(first.channels) == set(other.channels):
        return ()
    this, that = (f'driven by {" and ".join(one.drives) or "nothing"} and compared in '
                  f'{" and ".join(one.channels)}' for one in (other, first))
    return (f'the other record is {this}, the first is {that}',)


def _beyond(diagnosis: Diagnosis, experiment: Experiment, start: Initial) -> tuple[str, ...]:
    """Return a sentence where a term without a name is asked beyond the range that it has seen."""
    unknown = diagnosis.unknown
    if unknown is None:
        return ()
    share = float(np.mean(beyond(unknown.seen, experiment, diagnosis.after, start)))
    if share < WORTH_SAYING:
        return ()
    variable = unknown.variable.replace('_', ' ')
    return (f'{100.0 * share:.0f} % of the other record lies beyond the {variable} in which the '
            'term without a name was seen: it fades to zero there',)


def _in_another_phase(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Return a sentence where what was added depends on the time since the record began."""
    if not depends_on_time(diagnosis.after) or depends_on_time(diagnosis.declared):
        return ()
    return ('what was added goes by the time since the record began: the other record is judged '
            'as if it began like the first, the supply in the same phase, the converter as cold',)


def _opened_further(
    diagnosis: Diagnosis, experiment: Experiment, start: Initial
) -> tuple[str, ...]:
    """Return a sentence for each seat that is fully open in this record but never in the first."""
    if not {'control_current', 'back_pressure'} & set(experiment.drives):
        return ()  # nothing says how far the booster is open
    fitted = _fully_open(diagnosis.experiment, diagnosis.after, diagnosis.start)
    judged = _fully_open(experiment, diagnosis.after, start)
    return tuple(
        f'{100.0 * judged[seat]:.0f} % of the other record has the {seat} open as far as it goes, '
        'which the first record never had: its largest area follows from the declared one, and '
        'shows as an error if that is wrong'
        for seat in judged if judged[seat] >= WORTH_SAYING and fitted[seat] == 0.0)


def _fully_open(
    experiment: Experiment, parameters: PositionerParameters, start: Initial | None
) -> dict[str, float]:
    """Return the share of rows in which each seat of the booster is open as far as it goes."""
    run = experiment.simulate(parameters, start)
    largest = {'intake': parameters.booster.max_area,
               'exhaust': largest_exhaust_area(parameters.booster)}
    return {seat: float(np.mean(np.isclose(run[f'{seat}_area'], area))) if area else 0.0
            for seat, area in largest.items()}


def _start(experiment: Experiment, parameters: PositionerParameters) -> Initial:
    """Return the start that suits the first seconds of the record best."""
    rows = experiment.time <= experiment.time[0] + FIRST_SECONDS
    problem = Problem(experiment, rows, parameters, ())
    start = fit(problem).z if problem.nuisances and not experiment.quasi_static else (
        problem.start())
    return problem.initial(start, parameters)
