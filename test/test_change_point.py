# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Records of valves that changed on the way, by a plant of other equations."""

from dataclasses import replace
from functools import cache
import re

from hidden_plant.cases import Case, play
from hidden_plant.currents import KINDS
from hidden_plant.sensors import recorded
from made_diagnosis import diagnosis_of, record_of
import numpy as np
import pytest

from booster_ros.diagnosis.judging import change_point
from booster_ros.diagnosis.judging.change_point import since_change
from booster_ros.diagnosis.pipeline import diagnose
from booster_ros.report.wording import verdict_sentences, verdict_title

SECONDS = 60.0
AT = 20.0
"""When the valve changes, s."""


def columns_of(*effects, seed=5):
    """Return the columns of a record of the hidden plant with these effects."""
    return {name: values.copy() for name, values in played(effects, seed).items()}


@cache
def played(effects, seed):
    """Return such columns, the same ones each time."""
    case = Case('hidden', effects, seed=seed)
    current = KINDS['mixed'](np.random.default_rng([seed, 1]), SECONDS)
    pressure, position = recorded(*play(*case.plant(), current), np.random.default_rng(seed))
    return {'time': 0.01 * np.arange(len(current)), 'control_current': current,
            'chamber_pressure': pressure, 'valve_position': position}


def coarse(columns, every=2):
    """Return every other row, or one of so many."""
    return {name: values[::every] for name, values in columns.items()}


@cache
def knocked(by, at, every=2):
    """Return record and diagnosis of a valve whose position reads this much more, m, from then."""
    columns = coarse(columns_of(), every)
    columns['valve_position'] = columns['valve_position'] + by * (columns['time'] >= at)
    return record_of(columns), diagnosis_of(columns, 'none')


def diagnosed(columns):
    """Return the diagnosis from the change on, after one of the whole that added nothing."""
    return since_change(diagnosis_of(columns, 'none'), record_of(columns), diagnose)


@pytest.fixture(scope='module')
def change():
    """Return what is found of a sensor that is knocked early."""
    return change_point._change(knocked(3e-4, AT)[1])


def meets(found):
    return all(one.after < 1.15 * one.noise for one in found.held_out.values())


@pytest.mark.campaign
def test_a_leak_that_opens_is_told_from_when_it_opened():
    found = diagnosed(columns_of(('late_leak', 5e-8)))
    assert found.change.time == pytest.approx(AT, abs=0.5)
    assert found.change.cut
    assert found.change.met < 1.15
    assert found.change.missed > 25.0
    assert [one.name for one in found.effects] == ['chamber_leak']
    assert found.after.actuator.leak_area == pytest.approx(5e-8, rel=0.1)
    assert found.experiment.begins == pytest.approx(found.change.time)
    assert len(found.experiment.time) == round((SECONDS - found.change.time) / 0.01)
    assert meets(found)


@pytest.mark.campaign
def test_where_a_supply_falls_the_record_is_cut_and_nothing_is_missing_since():
    found = diagnosed(columns_of(('supply_falls', 8e3)))
    assert found.change.time == pytest.approx(AT, abs=0.5)
    assert found.change.cut
    assert found.verdict == 'none'
    assert meets(found)


@pytest.mark.campaign
def test_a_sensor_that_dies_is_said_to_be_silent():
    columns = columns_of()
    columns['valve_position'] = np.where(
        columns['time'] >= AT, -1e-3, columns['valve_position'])
    found = diagnosed(columns)
    assert found.change.time == pytest.approx(AT, abs=0.1)
    assert found.change.cut
    assert found.change.silent == ('valve_position',)
    assert found.verdict == 'unknown'
    assert [(one.location, one.confused_with) for one in found.effects] == [('sensor', ())]
    assert found.experiment.channels == ('chamber_pressure',)
    assert meets(found)
    title, sentences = verdict_title(found), ' '.join(verdict_sentences(found))
    assert re.fullmatch(r'From 20(\.0\d)? s on the valve position stands still', title)
    assert 'the sensor is dead or cut off, or the valve sticks fast' in sentences


def test_what_came_after_is_diagnosed_by_itself(monkeypatch, change):
    record, whole = knocked(3e-4, AT)
    clean = coarse(columns_of())
    after = {name: values[clean['time'] >= AT] for name, values in clean.items()}
    later = diagnosis_of(after, 'none')
    monkeypatch.setattr(change_point, '_change', lambda _: change)
    monkeypatch.setattr(change_point, '_later', lambda *_: later)
    found = since_change(whole, record, diagnose)
    assert found.change.cut
    assert found.verdict == 'none'


def test_of_a_sensor_that_is_knocked_near_the_end_only_the_time_is_told():
    record, whole = knocked(3e-4, 50.0, 1)
    open_yet = replace(whole, held_out={name: replace(error, left_open=9.0, unforeseen=1.0)
                                        for name, error in whole.held_out.items()})
    found = since_change(open_yet, record, diagnose)
    # a refit to the rows after the change as well has not met them
    assert not any(error.foreseen for error in found.held_out.values() if not error.met)
    assert found.change.time == pytest.approx(50.0, abs=0.3)
    assert not found.change.cut
    assert found.verdict == whole.verdict
    assert found.experiment is whole.experiment


@pytest.mark.parametrize('hidden', [
    pytest.param((), id='nothing left to explain, but by the parameters as given'),
    pytest.param((('chamber_leak', 5e-8),), id='a leak from the start'),
])
def test_a_valve_that_stayed_what_it_was_did_not_change(hidden):
    columns = coarse(columns_of(*hidden))
    whole = diagnosis_of(columns, 'none')
    assert since_change(whole, record_of(columns), diagnose) is whole


def leaving(diagnosis, times):
    """Return the diagnosis as if it left so many times the noise of what it was fitted to."""
    return replace(diagnosis, error={
        name: replace(one, after=times * one.noise) for name, one in diagnosis.error.items()})


@pytest.mark.parametrize(('times', 'cut'), [(3.0, False), (2.0, True)])
def test_a_diagnosis_of_the_rest_has_to_leave_half_and_may_still_leave_something(
        times, cut, monkeypatch, change):
    record, whole = knocked(3e-4, AT)
    whole = leaving(whole, 4.0)  # squares: half of 16 is 8
    monkeypatch.setattr(change_point, '_change', lambda _: change)
    monkeypatch.setattr(change_point, '_later', lambda *_: leaving(whole, times))
    found = since_change(whole, record, diagnose)
    assert found.change.cut is cut
    assert found.change.time == pytest.approx(AT, abs=0.3)
    assert found.verdict == 'none'
