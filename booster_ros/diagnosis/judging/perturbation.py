# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
How well a model repeats itself: what is chance in a record, so that no model can foretell it.

Steady sliding loses its stability where friction falls with velocity, and a stick-slip cycle grows
from whatever disturbance there is, however small: when the cycle starts, and so when each slip
comes, is not in the parameters. (Stability of steady sliding: B. Armstrong-Hélouvry, P. Dupont,
C. Canudas de Wit, Automatica 30 (1994) 1083.)
"""

from dataclasses import replace

import numpy as np

from booster_ros.diagnosis.data.experiment import DriveNoise, Experiment, Initial
from booster_ros.diagnosis.prepare.feedback import apart
from booster_ros.diagnosis.prepare.timing import drawn_runs
from booster_ros.model.actuator import has_dry_friction
from booster_ros.model.system import PositionerParameters

DISTURBANCE = 1e-6
"""Standard deviation of what disturbs each drive, as a share of its range: far below what any
converter or sensor resolves."""

WORTH_SAYING = 0.3
"""Difference between two runs, as a share of the noise, from which on it is said: it then adds 4 %
to the error."""


def differences(experiment: Experiment, parameters: PositionerParameters, initial: Initial
                ) -> dict[str, float]:
    """Return by how much two runs with nearly the same drives differ: RMS of each channel, SI."""
    return apart(drawn_runs(_disturbed, experiment, parameters, initial))


def chance(experiment: Experiment, parameters: PositionerParameters, initial: Initial
           ) -> dict[str, float]:
    """Return `differences` in multiples of the noise where a stem sticks and they matter, or {}."""
    if not has_dry_friction(parameters.actuator):
        return {}
    shares = {name: value / experiment.noise[name] for name, value in differences(
        experiment, parameters, initial).items()}
    return shares if max(shares.values()) >= WORTH_SAYING else {}


def _disturbed(experiment: Experiment, rng: np.random.Generator) -> Experiment:
    """Return the experiment with its drives, commanded and measured, disturbed."""
    size = DISTURBANCE * float(np.ptp(experiment.current))
    commanded = experiment.current + size * rng.standard_normal(len(experiment.current))
    shaken = experiment.shaken(
        {name: DriveNoise(DISTURBANCE * float(np.ptp(values)))
         for name, values in experiment.pinned.items()}, rng)
    return replace(shaken, current=commanded)
