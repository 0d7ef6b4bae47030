# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
When commands were given that a record has in the row after, or in the row before.

**Another clock.** One that stamps rows as they arrive does not know when in a row the valve took a
command: with a standard deviation of its length over sqrt(12). What that does is noise.

**A historian.** Commands that were read now and then were given at some moment in the row before.
The record tells so where the valve moves before a jump out of rest. Then

1. the command is taken to run straight from row to row: a command that moves on slowly did so;
2. where commands jump, the declared model is run several times with each jump at either end of its
   row, and rows count once all runs come to the same, within the noise.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from booster_ros.diagnosis.data.experiment import Array, Experiment, Initial
from booster_ros.diagnosis.prepare.plausibility import LITTLE
from booster_ros.model.system import PositionerParameters

EVEN = 1e-3
"""Unevenness of the spacing of rows, relative to their distance, below which rows and drive have
one clock."""

DRAWS = 8
"""Runs, in each of which every command is drawn anew: what they differ by is known to a quarter."""

AHEAD = 0.2
"""Share of what a command does that the valve has done before its row, above which commands were
read now and then; and that a command may do beside a jump, for the valve to be at rest."""

FEWEST = 5
"""Smallest number of jumps that tell: those before which the model moves by less than AHEAD."""


def commands_may_be_late(experiment: Experiment) -> bool:
    """Tell whether rows are stamped by another clock than that of the commands."""
    if (experiment.quasi_static or experiment.ends is not None
            or np.ptp(experiment.current) == 0.0):
        return False
    steps = np.diff(experiment.time)
    usual = np.median(steps)
    return float(np.quantile(np.abs(steps - usual), 0.9)) >= EVEN * usual


def with_late_commands(experiment: Experiment, rng: np.random.Generator) -> Experiment:
    """
    Return the experiment with some of its rows, drawn, commanded as the row before them.

    As many as give the delay the variance of one that is anywhere in a row, 1/12: their share times
    the share of the others.
    """
    late = 0.5 - np.sqrt(1.0 / 6.0)
    before = np.append(experiment.current[:1], experiment.current[:-1])
    return replace(experiment, current=np.where(
        rng.random(len(before)) < late, before, experiment.current))


def drawn_runs(drawn: Callable[[Experiment, np.random.Generator], Experiment],
               experiment: Experiment, parameters: PositionerParameters, initial: Initial
               ) -> list[dict[str, Array]]:
    """Return what the model predicts for several drawn experiments."""
    rng = np.random.default_rng(1)
    return [drawn(experiment, rng).predict(parameters, initial) for _ in range(DRAWS)]


def with_noise_of_timing(experiment: Experiment, declared: PositionerParameters) -> Experiment:
    """Return the experiment with the noise of each channel at least what late commands leave."""
    taken = experiment.predict(declared)
    late = drawn_runs(with_late_commands, experiment, declared, experiment.initial)
    return replace(experiment, noise={
        name: max(level, float(np.sqrt(np.mean([(run[name] - taken[name])**2 for run in late]))))
        for name, level in experiment.noise.items()})


def with_sampled_commands(experiment: Experiment, declared: PositionerParameters) -> Experiment:
    """Return the experiment with commands as read now and then, as it is where they were not."""
    if not _ahead_of_commands(experiment, declared):
        return experiment
    current = experiment.current
    following = np.append(current[1:], current[-1:])
    jumps = np.abs(following - current) > LITTLE * np.ptp(current)

    def taken(one: Experiment, rng: np.random.Generator) -> Experiment:
        given = np.where(rng.random(len(current)) < 0.5, current, following)
        return replace(one, current=np.where(jumps, given, current),
                       ends=np.where(jumps, given, following))

    runs = drawn_runs(taken, experiment, declared, experiment.initial)
    measured = {
        name: np.where(np.ptp([run[name] for run in runs], axis=0) > experiment.noise[name],
                       np.nan, values)
        for name, values in experiment.measured.items()}
    hidden = {name: int(np.isfinite(values).sum() - np.isfinite(measured[name]).sum())
              for name, values in experiment.measured.items()}
    rows = ', '.join(f'{count} of {name}' for name, count in hidden.items())
    return replace(experiment, ends=following, measured=measured, notes=(
        *experiment.notes, 'the valve moves before the rows that have its commands, so these were '
        'read now and then: from row to row it is taken to run straight, and after a jump rows are '
        f'not compared until it no longer matters when it came ({rows}); record commands when they '
        'are given'))


def _ahead_of_commands(experiment: Experiment, declared: PositionerParameters) -> bool:
    """
    Tell whether the valve moves before the row that has its command.

    It shows, and matters, where rows are further apart than the time that the E/P converter takes.
    """
    current = experiment.current
    apart = float(np.median(np.diff(experiment.time)))
    if np.ptp(current) == 0.0 or apart < declared.ep_converter.time_constant:
        return False
    moves = np.pad(np.abs(np.diff(current[:-1])), 1)
    alone = np.maximum(moves[:-2], moves[2:]) < AHEAD * moves[1:-1]
    jumps = 1 + np.flatnonzero(alone & (moves[1:-1] > LITTLE * np.ptp(current)))
    predicted = experiment.predict(declared)
    return any(_ahead(measured, predicted[name], jumps, experiment.noise[name])
               for name, measured in experiment.measured.items())


def _ahead(measured: Array, predicted: Array, jumps: Array, noise: float) -> bool:
    """Tell whether a channel moves ahead, by what it does beyond the model just before jumps."""
    after = predicted[jumps + 1] - predicted[jumps]
    before = predicted[jumps] - predicted[jumps - 1]
    early = measured[jumps] - measured[jumps - 1] - before
    told = np.isfinite(early) & (np.abs(before) < AHEAD * np.abs(after))
    if np.count_nonzero(told) < FEWEST:
        return False
    early, after = early[told], after[told]
    square = float(after @ after)
    return float(early @ after) / square - 3.0 * noise * np.sqrt(2.0 / square) > AHEAD
