# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
What a controller makes of noise in its feedback, which no record has.

Where a pulse ends, and whether another one comes, hangs near the dead zone on less than any sensor
resolves; until the next move the valve stands where the last pulse has left it. A model that is
right in every parameter still leaves that of a record. It is noise which stays the same for
seconds.
"""

from dataclasses import replace

import numpy as np

from booster_ros.diagnosis.data.experiment import Array, Chance, Experiment
from booster_ros.diagnosis.prepare.timing import drawn_runs
from booster_ros.model.position_controller import FINEST, PULSES
from booster_ros.model.system import PositionerParameters
from booster_ros.signals.dispersion import autocorrelation_time


def with_noise_of_feedback(experiment: Experiment, declared: PositionerParameters) -> Experiment:
    """Return the experiment with what noise in the feedback adds to that of its channels."""
    c = declared.position_controller
    on_its_own = c.output == PULSES or c.dead_zone > 0.0
    if not experiment.in_loop or experiment.is_slow or not on_its_own:  # slow rows hide it
        return experiment
    level = max(FINEST * declared.actuator.travel, c.feedback_resolution)

    def seen(one: Experiment, rng: np.random.Generator) -> Experiment:
        # to the controller an error of the position is one of the set point
        return replace(one, current=one.current + level * rng.standard_normal(len(one.current)))

    several = drawn_runs(seen, experiment, declared, experiment.initial)
    # the mean square difference of two runs is twice the variance between all of them
    added = {name: float(np.sqrt(2.0 * np.mean(np.var([run[name] for run in several], axis=0,
                                                      ddof=1)))) for name in several[0]}
    noise = {name: float(np.hypot(one, added[name])) for name, one in experiment.noise.items()}
    usual = {name: np.mean([run[name] for run in several], axis=0) for name in noise}
    return replace(experiment, noise=noise, chance={
        name: Chance((added[name] / noise[name])**2, _carried_over(experiment.time, [
            run[name] - usual[name] for run in several])) for name in noise})


def _carried_over(time: Array, departures: list[Array]) -> float:
    """Return for how long, s, departures carry over, as those of a first-order process do."""
    rows = float(np.mean([autocorrelation_time(one) for one in departures]))
    return 0.5 * rows * float(np.median(np.diff(time)))
