# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
A valve that changed while it was recorded: a fitting that comes loose, a sensor that is knocked.

A model of a valve that changed is a compromise between before and after. So where a diagnosis
leaves much:

1. refit the declared model to the beginning of the record, which it has to meet to the noise;
2. lengthen this beginning, segment by segment, as far as the refit still meets it (by bisection);
3. run the model refitted to it over the rest: the valve changed where this model begins to miss;
4. if enough of the record is left from there on, diagnose that rest as a record of its own;
5. where nothing is missing in the rest, a declared parameter has changed, or a sensor, if a channel
   no longer says anything of the valve.

An effect that the record excites for the first time looks the same, and is found the same way.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from booster_ros.diagnosis.data.experiment import AVERAGED, Array, Experiment
from booster_ros.diagnosis.hypotheses.applicable import free_to_refit
from booster_ros.diagnosis.estimation.fit import Fit, fit
from booster_ros.diagnosis.estimation.problem import Problem
from booster_ros.diagnosis.prepare.preparation import prepare
from booster_ros.diagnosis.result import FAR_OFF, Change, ChannelError, Diagnosis, FoundEffect
from booster_ros.diagnosis.selection.decide import NOISE
from booster_ros.diagnosis.selection.stepwise import Progress
from booster_ros.diagnosis.selection.task import THINNING, thinned
from booster_ros.model.system import PositionerParameters
from booster_ros.records import Record, RecordError

MUCH = FAR_OFF * FAR_OFF
"""Mean square, in the noise's, that a diagnosis has to leave before a change is looked for; for the
record to be cut, so much has to be left of the used rows."""

A_RECORD = 0.25
"""Smallest share that tells as a record of its own, of the beginning and of what is left after a
change: a refit to less may imitate what has been missing from the start."""

WORTH_CUTTING = 0.5
"""Largest mean square that the diagnosis of the rest may leave, relative to that of the whole."""


def since_change(diagnosis: Diagnosis, record: Record, judge: Callable[..., Diagnosis],
                 progress: Progress | None = None) -> Diagnosis:
    """
    Return the diagnosis of the record from where the valve changed, the given one if it did not.

    Where the record is not cut there, return the given one with the time of the change. The test
    set does not decide whether to cut. `judge` is the procedure that diagnoses the rest.
    """
    left = _left(diagnosis.error)
    if diagnosis.experiment.quasi_static or not (
            left > MUCH or _left(diagnosis.held_out) > MUCH):
        return diagnosis
    tell = progress or (lambda phrase, share: None)
    tell('looking for a change of the valve', 0.99)
    change = _change(diagnosis)
    if change is None:
        return diagnosis
    # the declared model has not met the missed rows even where it was refitted to them as well
    diagnosis = replace(diagnosis, change=change, held_out={
        name: replace(error, left_open=np.nan, unforeseen=np.nan)
        for name, error in diagnosis.held_out.items()})
    later = _later(record, change, diagnosis.declared, tell, judge) if left > MUCH else None
    if later is None:
        return diagnosis
    silent = tuple(name for name in diagnosis.experiment.channels
                   if name not in later.experiment.channels)
    change = replace(change, silent=silent)
    if not (later.verdict == 'none' if silent else _left(later.error) <= WORTH_CUTTING * left):
        return replace(diagnosis, change=change)
    later = replace(later, change=replace(change, cut=True))
    if not silent:
        return later
    # a stuck stem shows in the pressure as well
    met = all(one.met for one in (*later.error.values(), *later.held_out.values())
              if np.isfinite(one.after))
    return replace(later, verdict='unknown', effects=(
        FoundEffect('unknown', 'sensor' if met else 'stem', {}, (), '', {}),))


def _left(errors: Mapping[str, ChannelError]) -> float:
    """Return the mean square that the last model leaves, in the noise's; NaN of no channel."""
    squares = [(one.after / one.noise)**2 for one in errors.values() if np.isfinite(one.after)]
    return float(np.mean(squares)) if squares else np.nan


def _change(diagnosis: Diagnosis) -> Change | None:
    """Return when the valve changed, None if it did not, or was not met before."""
    experiment = diagnosis.experiment
    met = _longest_met(diagnosis)
    if met is None:
        return None
    end, fit = met
    squares = _squares(experiment, fit)
    row = _first_missed(squares, max(end - AVERAGED, 0))  # a change may lie in the last rows met
    if row is None:
        return None
    return Change(
        experiment.begins + float(experiment.time[row]), float(np.nanmean(squares[:row])),
        float(np.nanmean(squares[row:])))


def _first_missed(squares: Array, begin: int) -> int | None:
    """
    Return the row from which on a model misses, sought from row `begin` on; None if there is none.

    A mean of rows tells whether, a cumulative sum when (E. S. Page, Biometrika 41 (1954) 100).
    """
    known = begin + np.flatnonzero(np.isfinite(squares[begin:]))
    if len(known) < AVERAGED:
        return None
    missed = np.convolve(squares[known], np.full(AVERAGED, 1.0 / AVERAGED), 'valid') > MUCH
    if not missed.any():
        return None
    until = int(np.argmax(missed)) + AVERAGED
    walk = np.cumsum(np.append(0.0, squares[known[:until]] - MUCH))
    return int(known[np.argmin(walk[:until])])


def _squares(experiment: Experiment, fit: Fit) -> Array:
    """Return the mean square by which the model misses each row, in multiples of the noise's."""
    predicted = experiment.predict(fit.parameters, fit.initial)
    scaled = np.array([(measured - predicted[name]) / experiment.noise[name]
                       for name, measured in experiment.measured.items()])
    known = np.isfinite(scaled)
    return np.where(known.any(axis=0), np.sum(np.where(known, scaled, 0.0)**2, axis=0)
                    / np.maximum(known.sum(axis=0), 1), np.nan)


def _longest_met(diagnosis: Diagnosis) -> tuple[int, Fit] | None:
    """Return up to which row the declared model, refitted, meets the noise, and that fit."""
    experiment, declared = diagnosis.experiment, diagnosis.declared
    ends = [segment.last for segment in diagnosis.segments
            if segment.last >= A_RECORD * len(experiment.time)]
    thin, kept = thinned(experiment, THINNING)
    whole = Problem(thin, np.ones(len(kept), dtype=bool), declared,
                    free_to_refit(declared, experiment))
    met: tuple[int, Fit] | None = None
    low, middle, high = 0, 0, len(ends)  # the first, then by bisection
    while low < high:
        problem = replace(whole, rows=kept < ends[middle])
        found = fit(problem, () if met is None else [met[1].z])
        if found.cost < NOISE * problem.observed:
            low, met = middle + 1, (ends[middle], found)
        elif met is None:
            return None
        else:
            high = middle
        middle = (low + high) // 2
    return met


def _later(record: Record, change: Change, declared: PositionerParameters, tell: Progress,
           judge: Callable[..., Diagnosis]) -> Diagnosis | None:
    """Return the diagnosis of the record from the change on, None where too little is left."""
    rest = record.since(change.time)
    if len(rest) < A_RECORD * len(record):
        return None
    try:
        experiment = prepare(rest, declared)
        return judge(
            experiment, declared, lambda phrase, share: tell(
                f'from {change.time:.9g} s on: {phrase}', share),
            (*rest.notes, *experiment.notes))
    except RecordError:
        return None
