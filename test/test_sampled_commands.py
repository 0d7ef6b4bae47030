# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Commands that were read now and then, and those that were recorded as they were given."""

from functools import cache

from made_diagnosis import DECLARED
from made_record import misses, record_of
import numpy as np
import pytest

from booster_ros.diagnosis.prepare.timing import commands_may_be_late
from booster_ros.diagnosis.prepare.preparation import prepare
from booster_ros.model.simulation import simulate


@cache
def recorded():
    """Return the columns of a valve in rows of 10 ms, which are simulated once."""
    rng = np.random.default_rng(1)
    time = 0.01 * np.arange(15000)
    steps = np.repeat(rng.choice(np.linspace(0.40e-3, 0.45e-3, 9), 20), 1507)[:len(time)]
    current = steps + 5e-6 * np.sin(time / 10.0)
    run = simulate(DECLARED, time, current, {'chamber_pressure': 215e3})
    noise = {'chamber_pressure': 150.0, 'valve_position': 8e-6}
    return {'time': time, 'control_current': current} | {
        name: run[name] + level * rng.standard_normal(len(time)) for name, level in noise.items()}


def read_now_and_then(every):
    """Return the columns of that valve of which a row in `every` is kept."""
    return {name: values[::every] for name, values in recorded().items()}


@pytest.mark.parametrize('every', [20, 50, 100])
def test_commands_that_were_read_now_and_then_are_taken_as_what_they_may_have_been(every):
    experiment = prepare(record_of(**read_now_and_then(every)), DECLARED)
    assert max(misses(experiment).values()) < 1.15
    compared = [np.isfinite(values).mean() for values in experiment.measured.values()]
    assert 0.1 < min(compared) <= max(compared) < 0.5
    assert 'were read now and then' in experiment.notes[-1]


@pytest.mark.parametrize('jitter', [2e-3, 0.05])
def test_they_are_so_where_rows_are_not_quite_evenly_spaced_as_well(jitter):
    columns = read_now_and_then(50)
    moved = np.random.default_rng(3).uniform(-jitter, jitter, len(columns['time']))
    columns['time'] = columns['time'] + np.r_[0.0, moved[1:]] * 0.01
    experiment = prepare(record_of(**columns), DECLARED)
    assert 'were read now and then' in experiment.notes[-1]
    assert experiment.noise['chamber_pressure'] < 300.0
    assert not commands_may_be_late(experiment)  # to a calibration, to the report
    assert max(misses(experiment).values()) < 1.3


def test_thinned_rows_of_commands_that_were_read_now_and_then_meet_the_noise_as_well():
    thin, kept = prepare(record_of(**read_now_and_then(20)), DECLARED).thinned(4)
    assert len(kept) < 300
    assert max(misses(thin).values()) < 1.15


@pytest.mark.parametrize('every', [1, 50, 100])
def test_commands_that_were_recorded_when_they_were_given_stand(every):
    columns = read_now_and_then(every)
    if every == 1:  # some jumps are enough
        columns = {name: values[:5000] for name, values in columns.items()}
    else:  # play them as they are recorded
        held = columns['control_current']
        run = simulate(DECLARED, columns['time'], held, {'chamber_pressure': 215e3})
        rng = np.random.default_rng(2)
        columns['chamber_pressure'] = run['chamber_pressure'] + 150.0 * rng.standard_normal(
            len(held))
        columns['valve_position'] = run['valve_position'] + 8e-6 * rng.standard_normal(len(held))
    experiment = prepare(record_of(**columns), DECLARED)
    assert np.array_equal(experiment.current, columns['control_current'])
    assert experiment.ends is None
    assert all(np.isfinite(values).all() for values in experiment.measured.values())


@pytest.mark.parametrize('seed', [1, 2, 3])
def test_a_valve_that_is_quicker_than_the_model_is_not_ahead_of_commands_that_never_rest(seed):
    rng = np.random.default_rng(seed)
    time = 0.05 * np.arange(801)
    angles = 2.0 * np.pi * rng.uniform(0.1, 0.9, (3, 1)) * time
    current = 0.433e-3 + 6e-6 * np.sin(angles).sum(axis=0)
    weak = DECLARED.ep_converter._replace(gain=0.85 * DECLARED.ep_converter.gain)
    run = simulate(DECLARED._replace(ep_converter=weak), time, current,
                   {'chamber_pressure': 190e3})
    experiment = prepare(record_of(
        time=time, control_current=current,
        chamber_pressure=run['chamber_pressure'] + 150.0 * rng.standard_normal(len(time)),
        valve_position=run['valve_position'] + 8e-6 * rng.standard_normal(len(time))), DECLARED)
    assert experiment.ends is None
