# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Diagnoses made by hand from short simulations, for tests of what is made of a diagnosis.

Each is made once and shared by the tests of a process: nothing in it may be changed in place.
"""

from dataclasses import replace
from functools import cache

import numpy as np

from booster_ros.diagnosis.data.experiment import UNITS, rmse
from booster_ros.diagnosis.data.blocks import rows_of, split, split_sweep
from booster_ros.diagnosis.prepare.preparation import prepare
from booster_ros.diagnosis.result import (
    ChannelError,
    Diagnosis,
    FoundEffect,
    Interval,
    Refitted,
    Refused,
    Suspect,
)
from booster_ros.diagnosis.judging.validation import validated
from booster_ros.model import discrepancy
from booster_ros.model.simulation import simulate
from booster_ros.model.system import PositionerParameters
from booster_ros.records.cleaning import clean

DECLARED = PositionerParameters()
STICKING = DECLARED._replace(
    actuator=DECLARED.actuator._replace(coulomb_friction=500.0, stiction=150.0))
KNOTS = np.linspace(0.0, 0.016, discrepancy.KNOTS)
TABLE = np.r_[0.0, 900.0 * np.sin(np.linspace(0.3, 3.0, discrepancy.KNOTS - 2)), 0.0]
BENT = DECLARED._replace(discrepancy=discrepancy.Discrepancy(
    discrepancy.STEM, discrepancy.VALVE_POSITION, tuple(KNOTS), tuple(TABLE)))
NOISE = {'chamber_pressure': 150.0, 'valve_position': 8e-6}


def timed_columns(plant=DECLARED, seconds=60.0, seed=1):
    """Return the columns of a noisy triangle of currents played to a plant."""
    time = np.arange(0.0, seconds, 0.05)
    current = 0.44e-3 + 0.02e-3 * np.abs((time / 15.0) % 2.0 - 1.0)
    run = simulate(plant, time, current, {'chamber_pressure': 230e3})
    rng = np.random.default_rng(seed)
    return {
        'time': time, 'control_current': current,
        **{name: run[name] + level * rng.standard_normal(len(time))
           for name, level in NOISE.items()},
    }


def swept_columns(plant=STICKING):
    """Return a quasi-static sweep of the pressure, up and down."""
    pressure = np.r_[np.linspace(100e3, 330e3, 30), np.linspace(320e3, 110e3, 30)]
    run = simulate(plant, np.arange(60.0), np.zeros(60), None, {'chamber_pressure': pressure})
    return {'chamber_pressure': pressure, 'valve_position': run['valve_position']}


def record_of(columns, source='plant.csv'):
    """Return the columns as a cleaned record."""
    rows = np.arange(2, len(next(iter(columns.values()))) + 2)
    return clean(dict(columns), rows, source)


def diagnosis_of(columns, verdict, after=DECLARED, effects=(), unknown=None):
    """Return a diagnosis that says `verdict` of these columns, with true errors."""
    record = record_of(columns)
    experiment = prepare(record, DECLARED)
    driver = next(iter(experiment.pinned.values()), experiment.current)
    segments = split_sweep(len(experiment.time)) if experiment.quasi_static else split(
        experiment.time, driver)
    runs = {'declared': experiment.predict(DECLARED), 'before': experiment.predict(DECLARED),
            'after': experiment.predict(after)}

    def errors(role):
        rows = rows_of(segments, role, len(experiment.time))
        return {
            name: ChannelError(UNITS[name], *(rmse(measured, runs[stage][name], rows)
                                              for stage in ('declared', 'before', 'after')),
                               experiment.noise[name])
            for name, measured in experiment.measured.items()}

    chosen = tuple(effect.name for effect in effects)
    suspects = (
        Suspect(chosen, 1.02, 'chosen'),
        Suspect(('position_backlash',), 41.7, '41 times the squared error of the choice'),
        Suspect((), 388.0, 'the declared model, refitted'),
    )
    refitted = (
        Refitted('ep_converter.gain', 'Pa/A', 5.4034e8, 5.41e8, 5.402e8, 1.08e7,
                 0.061, -0.013),
        Refitted('actuator.bench_set[0]', 'Pa', 150e3, 150.4e3, 149.9e3, 600.0,
                 0.67, -0.17),
    )
    return Diagnosis(
        verdict, tuple(effects), unknown, errors('train'), errors('test'), suspects,
        refitted, DECLARED, DECLARED, after, experiment, tuple(segments), runs,
        (*record.notes, *experiment.notes))


FRICTION = FoundEffect(
    'stem_friction', 'stem',
    {'actuator.coulomb_friction': Interval(500.0, 480.0, 520.0, 'N'),
     'actuator.stiction': Interval(150.0, 90.0, 210.0, 'N')},
    ('position_backlash',), 'slow triangle with dither',
    {'misfit_without': 388.0, 'misfit_with': 1.02, 'log_evidence': 4e4, 'gain': 3.9e4,
     'gain_standard_error': 2e3, 'dispersion': 1.3}, 'confirmed', 0.99)

TERM = BENT.discrepancy


@cache
def friction_found():
    """Return a diagnosis that has found friction."""
    return diagnosis_of(timed_columns(STICKING), 'effect', STICKING, (FRICTION,))


def judged_on(columns, diagnosis):
    """Return the diagnosis with its errors on a record of these columns."""
    return validated(diagnosis, prepare(record_of(columns, 'other.csv'), DECLARED))


@cache
def friction_judged():
    """Return a diagnosis that has found friction, judged on another record."""
    return judged_on(timed_columns(STICKING, seed=2), friction_found())


@cache
def nothing_found():
    """Return a diagnosis of a plant that is as declared."""
    return diagnosis_of(timed_columns(), 'none')


@cache
def unknown_found():
    """Return a diagnosis that has found a bent spring without a name for it."""
    effect = FoundEffect('unknown', 'stem', {}, (), '', {'misfit_with': 1.1})
    return diagnosis_of(timed_columns(BENT), 'unknown', BENT, (effect,), TERM)


@cache
def refused_found():
    """Return a diagnosis of which the term without a name did not stand."""
    found = diagnosis_of(timed_columns(BENT), 'unknown', DECLARED, (
        FoundEffect('unknown', 'stem', {}, (), '', {'misfit_with': 1.1}),))
    return replace(found, decided=True, refused=Refused(
        'stem', 'valve_position',
        {name: 2.0 * error.before for name, error in found.held_out.items()}, 0.04))


@cache
def friction_found_in_a_sweep():
    """Return a diagnosis of a record without time."""
    return diagnosis_of(swept_columns(), 'effect', STICKING, (FRICTION,))


@cache
def without(column):
    """Return a diagnosis of a record that lacks a column."""
    columns = timed_columns(STICKING)
    del columns[column]
    return diagnosis_of(columns, 'effect', STICKING, (FRICTION,))


def off_by(diagnosis, part, before, after, name=None):
    """Return the diagnosis with these errors, in noises, in one or every channel of a part."""
    errors = {channel: replace(error, before=before * error.noise, after=after * error.noise)
              if name in (None, channel) else error
              for channel, error in getattr(diagnosis, part).items()}
    return replace(diagnosis, **{part: errors})


MADE = {
    'effect': friction_found,
    'judged': friction_judged,
    'none': nothing_found,
    'unknown': unknown_found,
    'sweep': friction_found_in_a_sweep,
    'pressure only': lambda: without('valve_position'),
    'position only': lambda: without('chamber_pressure'),
}
