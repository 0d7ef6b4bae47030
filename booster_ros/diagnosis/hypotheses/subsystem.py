# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The upstream subsystem: the positioner above its stem, driven by the measured stem.

Packing friction makes a record nearly unpredictable in detail. A model of the part above the stem,
driven by the measured current and position, knows no friction: it tells what lies above the stem
(identification of a subsystem with a measured interface variable).
"""

from dataclasses import replace

import numpy as np

from booster_ros.diagnosis.data.experiment import Experiment
from booster_ros.diagnosis.estimation.parametrisation import OF_THE_CHAMBER, Free
from booster_ros.model.catalogue import EFFECTS
from booster_ros.records.holding import bridged
from booster_ros.signals.savitzky_golay import smoothed

WINDOW = 11
"""Rows over which the measured position is smoothed, so that it has a velocity."""

APART = 0.05
"""Distance of the rows that are fitted, s: a position that drives needs them closer than others."""

_PLACES = ('ep_converter', 'supply', 'booster', 'tubing', 'chamber')


def upstream(experiment: Experiment) -> Experiment | None:
    """
    Return the experiment with position and velocity as drives and the pressure compared.

    None where position or pressure was not measured, where a channel within drives the model, in a
    sweep, or where rows are too few or too far apart; nor behind a position controller, of which
    nothing beside a measured stem takes back what its integral part adds up.
    """
    position = experiment.measured.get('valve_position', np.empty(0))
    if ('chamber_pressure' not in experiment.measured or not np.isfinite(position).any()
            or experiment.pinned_within or experiment.quasi_static or experiment.in_loop):
        return None
    interval = np.diff(experiment.time)
    if len(interval) < 10 * WINDOW or np.max(interval) > 4.0 * np.median(interval):
        return None
    whole = bridged(experiment.time, position)
    stem, velocity = smoothed(whole, WINDOW, float(np.median(interval)))
    return replace(
        experiment,
        measured={'chamber_pressure': experiment.measured['chamber_pressure']},
        noise={'chamber_pressure': experiment.noise['chamber_pressure']},
        pinned={'valve_position': stem, 'stem_velocity': velocity})


def is_upstream(name: str) -> bool:
    """Tell whether an effect changes the pressure that belongs to a given motion of the stem."""
    effect = EFFECTS[name]
    return effect.location in _PLACES or effect.reading == 'chamber_pressure'


def free_upstream(freedoms: tuple[Free, ...]) -> tuple[Free, ...]:
    """Return the declared parameters that matter above the stem."""
    return tuple(free for free in freedoms if free.knob.parameter in OF_THE_CHAMBER
                 or free.knob.parameter.split('.')[0] in _PLACES)
