# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The positioner above its stem, driven by the measured stem.

Packing friction makes a record nearly unpredictable in detail: which slip comes when decides what
follows. A model of all that is driven by the measured current and the measured position knows no
friction: it says what lies above the stem, in a fraction of the time.
"""

from dataclasses import replace

import numpy as np
from scipy.signal import savgol_filter

from booster_ros.diagnosis.experiment import Experiment
from booster_ros.diagnosis.fit import Free
from booster_ros.model.catalogue import EFFECTS

WINDOW = 11
"""Rows over which the measured position is smoothed to have a velocity."""

THINNING = 3
"""A driving position needs its rows closer together than a current that stands."""

_PLACES = ('ep_converter', 'supply', 'booster', 'tubing', 'chamber')
_PARAMETERS = ('actuator.dead_volume',)


def above_the_stem(experiment: Experiment) -> Experiment | None:
    """
    Return the experiment with position and velocity as drives and the pressure compared.

    None where position or pressure was not measured, or rows are too few or too far apart for it.
    """
    both = {'chamber_pressure', 'valve_position'} <= set(experiment.measured)
    if not both or experiment.pinned or experiment.quasi_static:
        return None
    interval = np.diff(experiment.time)
    if len(interval) < 10 * WINDOW or np.max(interval) > 4.0 * np.median(interval):
        return None
    position = experiment.measured['valve_position']
    seen = np.isfinite(position)
    whole = np.interp(experiment.time, experiment.time[seen], position[seen])
    step = float(np.median(interval))
    return replace(
        experiment,
        measured={'chamber_pressure': experiment.measured['chamber_pressure']},
        noise={'chamber_pressure': experiment.noise['chamber_pressure']},
        pinned={'valve_position': savgol_filter(whole, WINDOW, 2),
                'stem_velocity': savgol_filter(whole, WINDOW, 2, deriv=1, delta=step)})


def shows_above_the_stem(name: str) -> bool:
    """Tell whether an effect changes the pressure that belongs to a given motion of the stem."""
    return EFFECTS[name].location in _PLACES or name.startswith('pressure_sensor')


def free_above_the_stem(freedoms: tuple[Free, ...]) -> tuple[Free, ...]:
    """Return the declared parameters that matter above the stem."""
    return tuple(free for free in freedoms if free.knob.parameter in _PARAMETERS
                 or free.knob.parameter.split('.')[0] in _PLACES)
