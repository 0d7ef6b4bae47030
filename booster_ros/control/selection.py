# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The profile that the settings of the fake controller ask for."""

import numpy as np

from booster_ros.control import profiles
from booster_ros.control.profiles import Profile, ProfileError
from booster_ros.control.settings import (
    CSV, CURRENT, POSITION, SET_POINT, SINES, STAIRCASE, TRIANGLE, ControllerSettings)
from booster_ros.model.parameters import ParameterError
from booster_ros.records import Record, RecordError, read_record

PLAUSIBLE_CURRENT = 0.1
"""Largest plausible current, A; a larger one is meant in mA."""

PLAUSIBLE_TRAVEL = 0.5
"""Largest plausible position, m; a larger one is meant in mm or %."""

_PLAYED = {CURRENT: 'control_current', POSITION: 'valve_position', SET_POINT: 'set_point'}
"""Column of a record that is played, by mode."""


def select_profile(settings: ControllerSettings) -> Profile:
    """Return the profile; ParameterError where it cannot be made."""
    try:
        profile = _make(settings)
    except ProfileError as error:
        raise ParameterError(str(error)) from None
    return profile.repeated() if settings.loop else profile


def _make(settings: ControllerSettings) -> Profile:
    if settings.profile == CSV:
        return _from_csv(settings)
    _check_plausible(settings)
    if settings.profile == STAIRCASE:
        return profiles.staircase(settings.low, settings.high, settings.stairs, settings.dwell)
    if settings.profile == TRIANGLE:
        return profiles.triangle(settings.low, settings.high, settings.period, settings.cycles)
    if settings.profile == SINES:
        return profiles.sines(settings.low, settings.high, settings.frequencies, settings.cycles)
    return profiles.steps(settings.levels, settings.dwell)


def _check_plausible(settings: ControllerSettings) -> None:
    is_position = settings.mode != CURRENT
    largest = PLAUSIBLE_TRAVEL if is_position else PLAUSIBLE_CURRENT
    for name, value in (
        *(('levels', level) for level in settings.levels),
        ('low', settings.low), ('high', settings.high),
    ):
        if abs(value) > largest:
            unit, other = ('m', 'mm or %') if is_position else ('A', 'mA')
            raise ParameterError(
                f'{name}: {value:g} is not plausible in {unit}; is it in {other}?')


def _from_csv(settings: ControllerSettings) -> Profile:
    column = _PLAYED[settings.mode]
    try:
        record = read_record(settings.csv_file)
    except RecordError as error:
        raise ParameterError(f'csv_file: {error}') from None
    for name in ('time', column):
        if name not in record:
            raise ParameterError(f'csv_file: {settings.csv_file} has no column {name}')
    return _held(record, column)


def _held(record: Record, column: str) -> Profile:
    """Hold the values from row to row; the last one lasts as long as the row before it."""
    known = np.isfinite(record[column])
    time = record['time'][known] - record['time'][known][0]
    if time.size < 2:
        raise ParameterError(f'csv_file: {record.source} has fewer than two rows of {column}')
    return profiles.held(
        time.tolist(), record[column][known].tolist(), float(2.0 * time[-1] - time[-2]))
