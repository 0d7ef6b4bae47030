# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The part of the positioner above its stem, driven by the measured stem.

Packing friction makes a record nearly unpredictable in detail: which slip comes when decides what
follows. A model of the part above the stem, driven by the measured current and the measured
position, knows no friction: it tells what lies above the stem, in a fraction of the time.
"""

from dataclasses import replace

import numpy as np
from scipy.signal import savgol_filter

from booster_ros.diagnosis.experiment.experiment import Experiment
from booster_ros.diagnosis.fitting.fit import Fit
from booster_ros.diagnosis.fitting.freedom import OF_THE_CHAMBER, Free
from booster_ros.diagnosis.fitting.friction_start import best_friction
from booster_ros.diagnosis.searching.candidate import Candidate
from booster_ros.diagnosis.searching.search import EVALUATIONS, Search, as_given, carried
from booster_ros.model.catalogue import EFFECTS
from booster_ros.records.holding import bridged

Array = np.ndarray

WINDOW = 11
"""Rows over which the measured position is smoothed, so that it has a velocity."""

THINNING = 3
"""Fits above the stem use every third row: a position that drives the model needs its rows closer
together than a current that stands."""

_PLACES = ('ep_converter', 'supply', 'booster', 'tubing', 'chamber')
_IMITATES = 'actuator.viscous_friction'


def above_the_stem(experiment: Experiment) -> Experiment | None:
    """
    Return the experiment with position and velocity as drives and the pressure compared.

    None where position or pressure was not measured, where another channel drives the model, in a
    sweep without a clock, or where rows are too few or too far apart for it.
    """
    both = {'chamber_pressure', 'valve_position'} <= set(experiment.measured)
    if not both or experiment.pinned or experiment.quasi_static:
        return None
    if not np.isfinite(experiment.measured['valve_position']).any():
        return None
    interval = np.diff(experiment.time)
    if len(interval) < 10 * WINDOW or np.max(interval) > 4.0 * np.median(interval):
        return None
    position = experiment.measured['valve_position']
    whole = bridged(experiment.time, position)
    step = float(np.median(interval))
    return replace(
        experiment,
        measured={'chamber_pressure': experiment.measured['chamber_pressure']},
        noise={'chamber_pressure': experiment.noise['chamber_pressure']},
        pinned={'valve_position': savgol_filter(whole, WINDOW, 2),
                'stem_velocity': savgol_filter(whole, WINDOW, 2, deriv=1, delta=step)})


def shows_above_the_stem(name: str) -> bool:
    """Tell whether an effect changes the pressure that belongs to a given motion of the stem."""
    effect = EFFECTS[name]
    return effect.location in _PLACES or effect.reading == 'chamber_pressure'


def free_above_the_stem(freedoms: tuple[Free, ...]) -> tuple[Free, ...]:
    """Return the declared parameters that matter above the stem."""
    return tuple(free for free in freedoms if free.knob.parameter in OF_THE_CHAMBER
                 or free.knob.parameter.split('.')[0] in _PLACES)


def search_above(search: Search) -> Search | None:
    """Return the search above the stem, None where the record does not show that part alone."""
    above = above_the_stem(search.experiment)
    return None if above is None else replace(
        search, experiment=above, freedoms=free_above_the_stem(search.freedoms),
        thinning=THINNING)


def search_above_friction(search: Search, fit: Fit) -> Search | None:
    """Return the search above the stem where friction rules the stem, else None."""
    return search_above(search) if fit.sticks else None


def fitted_above(search: Search, candidate: Candidate, roles: tuple[str, ...]) -> Candidate | None:
    """
    Return the part of a model above a stem that sticks, fitted with the measured stem as drive.

    Parameters that were fitted before friction was in the model had imitated it, and a fit of the
    whole leaves them there: which slip comes when makes its cost rough. Above the stem nothing is
    rough.
    """
    above = search_above_friction(search, candidate.fit)
    if above is None:
        return None
    effects = tuple(e for e in candidate.effects if shows_above_the_stem(e))
    upper = above.on(above.joint(above.problem(), effects), roles, above.thinning)
    return above.rate(
        effects, upper, upper.fit(as_given(upper, carried(upper, candidate.fit))))


def as_seen_above(search: Search, candidate: Candidate, z: Array, roles: tuple[str, ...]) -> Array:
    """
    Return z with the parameters of the part above a stem that sticks as fitted in that part.

    Of the stem's own parameters, viscous friction had imitated dry friction: it is set back to the
    declared value, and dry friction is sought anew.
    """
    place = declared_as_seen_above(search, candidate, z, roles)
    thin = search.on(candidate.problem, roles, search.thinning)
    return z if place is z else best_friction(thin, place)


def declared_as_seen_above(search: Search, candidate: Candidate, z: Array, roles: tuple[str, ...]
                           ) -> Array:
    """Return z as `as_seen_above` does, with the dry friction at z; z itself where none is seen."""
    upper = fitted_above(search, candidate, roles)
    if upper is None:
        return z
    place = carried(candidate.problem, replace(candidate.fit, z=z), upper.fit)
    for j, free in enumerate(candidate.problem.freedoms):
        if free.knob.parameter == _IMITATES:
            place[j] = 0.0
    return place


def seen_from_above(search: Search, candidate: Candidate) -> Candidate:
    """Return the model of a stem that sticks, fitted on from what is seen above the stem."""
    problem = candidate.problem
    start = as_seen_above(search, candidate, candidate.fit.z, ('fit',))
    fit = problem.fit_through_slips(start, EVALUATIONS)
    if fit.cost >= candidate.fit.cost:
        return candidate
    return search.refitted(candidate, fit)
