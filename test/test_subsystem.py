# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What is seen above the stem, with its measured position as what drives the chamber."""

from dataclasses import replace
from types import SimpleNamespace

from made_effect import add_effect
from made_task import P, problem_of, seen, task_of
import numpy as np
import pytest

from booster_ros.diagnosis.estimation.parametrisation import declared_freedom
from booster_ros.diagnosis.hypotheses.subsystem import free_upstream, is_upstream, upstream
from booster_ros.diagnosis.selection.neighbours import BEST, neighbours, refitted
from booster_ros.diagnosis.selection.task import lacks_nothing, upstream_task


def test_above_the_stem_friction_does_not_matter_but_a_leak_shows():
    rubbing = P._replace(actuator=P.actuator._replace(coulomb_friction=400.0, stiction=150.0))
    leaking = rubbing._replace(actuator=rubbing.actuator._replace(leak_area=4e-8))

    def misfit(plant, model):
        above = upstream(seen(plant))
        assert set(above.measured) == {'chamber_pressure'}
        predicted = above.predict(model)['chamber_pressure']
        difference = above.measured['chamber_pressure'] - predicted
        return float(np.mean((difference[100:] / 150.0) ** 2))  # without the first rush

    settled = seen(rubbing)
    whole = settled.predict(P)['chamber_pressure'] - settled.measured['chamber_pressure']
    blurred = np.mean((whole[100:] / 150.0) ** 2)
    blameless = misfit(rubbing, P)
    assert blameless < blurred / 20.0
    assert misfit(leaking, P) > 20.0 * blameless


def test_a_record_without_position_has_nothing_above_its_stem():
    experiment = seen(P)
    del experiment.measured['valve_position']
    assert upstream(experiment) is None


@pytest.mark.parametrize(('effect', 'shows'), [
    ('supply_droop', True), ('chamber_leak', True), ('pressure_sensor_lag', True),
    ('stem_friction', False), ('position_backlash', False)])
def test_effects_upstream(effect, shows):
    assert is_upstream(effect) is shows


@pytest.mark.parametrize(('reading', 'shows'), [
    ('chamber_pressure', True), ('valve_position', False)])
def test_a_new_effect_of_a_sensor_shows_above_the_stem_by_its_reading(monkeypatch, reading, shows):
    add_effect(monkeypatch, 'loose_screw', 'sensor', reading=reading)
    assert is_upstream('loose_screw') is shows


def test_above_the_stem_no_parameter_of_the_stem_is_fitted():
    names = {free.knob.parameter for free in free_upstream(problem_of(seen(P)).freedoms)}
    assert {'ep_converter.gain', 'booster.max_area', 'actuator.dead_volume'} <= names
    assert not {'actuator.bench_set', 'actuator.viscous_friction'} & names


@pytest.mark.parametrize('rows', [
    np.arange(50), np.r_[0:200, 900:1200]], ids=['few', 'with a gap'])
def test_rows_that_tell_no_velocity_drive_nothing(rows):
    experiment = seen(P)
    measured = {name: values[rows] for name, values in experiment.measured.items()}
    short = replace(experiment, time=experiment.time[rows], current=experiment.current[rows],
                    measured=measured)
    assert upstream(short) is None


def test_the_task_above_the_stem_tries_what_lies_there():
    task = task_of(seen(P), ('chamber_leak', 'stem_friction', 'ep_hysteresis'))
    above = upstream_task(task)
    assert above.names == ('chamber_leak', 'ep_hysteresis')
    assert above.experiment.channels == ('chamber_pressure',)
    assert upstream_task(above) is None  # its position drives it already


def waved(plant, step, seconds):
    """Return a record of steps and a wave of the current, with rows so far apart, s."""
    time = np.arange(0.0, seconds, step)
    current = 0.012 + 0.004 * np.sign(np.sin(0.6 * time)) + 0.002 * np.sin(2.0 * time)
    return seen(plant, current=current, time=time)


@pytest.mark.parametrize('step', [0.01, 0.02])
def test_thinned_rows_of_a_stem_that_drives_say_nearly_what_all_rows_say(step):
    task = upstream_task(task_of(waved(P, step, 60.0), ()))
    above = task.experiment
    thin, kept = above.thinned(task.thinning)
    assert len(kept) < 0.6 * len(above.time)
    single = replace(thin, pinned={name: values[kept] for name, values in above.pinned.items()})
    whole = above.predict(P)['chamber_pressure'][kept]
    off, off_single = (float(np.sqrt(np.mean((one.predict(P)['chamber_pressure'] - whole)**2)))
                       for one in (thin, single))
    assert off < 0.5 * above.noise['chamber_pressure']
    assert off < 0.7 * off_single


@pytest.mark.parametrize(('left', 'whole', 'said'), [
    (1.0, 50.0, True), (1.9, 50.0, True), (2.1, 50.0, False), (3.4, 1000.0, True),
    (3.6, 1000.0, False)])
def test_a_smoothed_stem_may_leave_more_than_noise(left, whole, said):
    assert lacks_nothing(*(SimpleNamespace(reduced_chi2=one) for one in (left, whole))) is said


def test_where_one_effect_is_all_that_is_missing_above_no_others_are_fitted_to_their_end():
    leaking = P._replace(actuator=P.actuator._replace(leak_area=4e-7))
    names = ('chamber_leak', 'ep_hysteresis', 'ep_gain_loss', 'supply_droop', 'heat_transfer')
    experiment = waved(leaking, 0.02, 20.0)
    few = tuple(free for free in declared_freedom(P, experiment)
                if free.knob.parameter.startswith(('ep_converter.', 'actuator.')))
    above = upstream_task(task_of(experiment, names, few))
    parent = refitted(above)
    found = neighbours(above, parent, names)
    assert found.near[0].effects == ('chamber_leak',)
    assert lacks_nothing(found.near[0], parent)
    assert len(found.near) + len(found.far) == BEST < len(names)
