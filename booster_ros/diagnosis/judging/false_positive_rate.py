# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
How often the whole procedure adds something to a model that lacks nothing.

The declared model, refitted to the record, takes the place of the valve, at the times and with the
drives of the record, with noise of the same level, colour and resolution. Every such repeat goes
through the whole diagnosis.
"""

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from booster_ros.signals.stationary_segments import calm_pieces
from booster_ros.diagnosis.data.experiment import Experiment
from booster_ros.signals.noise_autocorrelation import noise_of
from booster_ros.diagnosis.prepare.timing import commands_may_be_late, with_late_commands
from booster_ros.diagnosis.prepare.start_state import first_value
from booster_ros.diagnosis.result import Diagnosis, FalseAdd
from booster_ros.diagnosis.selection.stepwise import Progress
from booster_ros.model.system import PositionerParameters

Diagnose = Callable[[Experiment, PositionerParameters, Progress], Diagnosis]


def calibrated(diagnosis: Diagnosis, runs: int, seed: int, judge: Diagnose,
               progress: Progress | None = None) -> Diagnosis:
    """
    Return the diagnosis with its false-add rate, counted over `runs` simulated records.

    `judge` is the procedure that is checked; `progress` is called with a phrase and the share
    done. ValueError where `runs` is less than 1.
    """
    from scipy.stats import binomtest  # takes a second to import

    if runs < 1:
        raise ValueError(f'a calibration needs at least one run, got {runs}')
    tell = progress or (lambda phrase, share: None)
    names: Counter[str] = Counter()
    gained = 0
    for run, experiment in enumerate(repeats(diagnosis, runs, seed)):
        def tell_run(phrase: str, share: float, run: int = run) -> None:
            tell(f'calibration {run + 1} of {runs}: {phrase}', (run + share) / runs)

        found = judge(experiment, diagnosis.declared, tell_run)
        gained += found.verdict != 'none'
        names.update(effect.name for effect in found.effects)
    interval = binomtest(gained, runs).proportion_ci(0.95, 'exact')
    return replace(diagnosis, false_add=FalseAdd(
        runs, gained, float(interval.low), float(interval.high), dict(names)))


def repeats(diagnosis: Diagnosis, runs: int, seed: int) -> Iterator[Experiment]:
    """Yield experiments in which the refitted declared model takes the place of the valve."""
    experiment, model = diagnosis.experiment, diagnosis.before
    drives = [experiment.current, *experiment.pinned.values()]
    calm = [] if experiment.quasi_static else calm_pieces(experiment.time, drives)
    noise = {name: noise_of(values, calm) for name, values in experiment.measured.items()}
    late = commands_may_be_late(experiment)
    still = experiment.predict(model) if experiment.drive_noise or late else {}
    for run in range(runs):
        rng = np.random.default_rng([seed, run])
        truth, driven = dict(diagnosis.runs['before']), experiment
        if experiment.drive_noise:
            # the readings drive the model; what drove the valve is the readings less their noise
            driven = driven.shaken(experiment.drive_noise, rng)
        if late:
            # the valve took each command at some moment before the next row
            driven = with_late_commands(driven, rng)
        if still:
            moved = driven.predict(model)
            truth = {name: values + moved[name] - still[name] for name, values in truth.items()}
        measured = {
            name: np.where(np.isfinite(values), noise[name].added_to(truth[name], rng), np.nan)
            for name, values in experiment.measured.items()}
        start: dict[str, Any] = {
            name: first_value(measured[name], experiment.noise[name])
            for name in ('chamber_pressure', 'valve_position') if name in measured}
        # start and noise level are told anew by each repeat, as they were by the record itself
        yield replace(experiment, measured=measured, initial=replace(experiment.initial, **{
            name: value for name, value in start.items() if value is not None}), noise={
            name: level * noise_of(measured[name], calm).level / noise[name].level
            if noise[name].level > 0.0 else level for name, level in experiment.noise.items()})
