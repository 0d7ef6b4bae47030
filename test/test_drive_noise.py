# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The noise of a measured drive, and what it adds to what is compared."""

from made_diagnosis import DECLARED
from made_record import BACK, CHAMBER, FLOW, ROWS, misfits, misses, record_of, step_test
import numpy as np
import pytest

from booster_ros.diagnosis.data.experiment import DriveNoise
from booster_ros.signals.noise_autocorrelation import Noise
from booster_ros.diagnosis.prepare.preparation import prepare
from booster_ros.model.simulation import simulate


def test_noise_of_a_measured_drive_counts_as_noise_of_what_it_drives():
    columns = step_test()
    del columns['control_current']
    experiment = prepare(record_of(**columns), DECLARED)
    spring = DECLARED.actuator.travel / 150e3  # m/Pa
    assert experiment.noise['valve_position'] > 0.8 * np.hypot(8e-6, 150.0 * spring)


def driven_by_its_back_pressure(noise, seed=1):
    """Return two minutes of stairs of which the current was not recorded, its drive with noise."""
    rng = np.random.default_rng(seed)
    time = 0.01 * np.arange(12_000)
    current = rng.uniform(0.34e-3, 0.46e-3, 20)[(time // 6.0).astype(int)]
    run = simulate(DECLARED, time, current, {'chamber_pressure': 170e3})
    return {'time': time, 'back_pressure': noise.added_to(run['back_pressure'], rng),
            'chamber_pressure': run['chamber_pressure'] + 150.0 * rng.standard_normal(len(time)),
            'valve_position': run['valve_position'] + 8e-6 * rng.standard_normal(len(time))}


@pytest.mark.parametrize('noise', [Noise(400.0), Noise(150.0, 0.5), Noise(150.0, 0.9)])
def test_noise_of_a_drive_is_as_loud_and_as_coloured_as_it_is(noise):
    """Loud noise shifts what two unlike seats settle to, slow noise reaches the chamber."""
    experiment = prepare(record_of(**driven_by_its_back_pressure(noise)), DECLARED)
    drive = experiment.drive_noise['back_pressure']
    assert drive.level == pytest.approx(noise.level, rel=0.05)
    assert drive.correlation == pytest.approx(noise.correlation, abs=0.05)
    for miss in misses(experiment).values():
        assert 0.9 < miss**2 < 1.3


def test_thinned_rows_let_no_more_of_the_noise_of_a_drive_through():
    columns = driven_by_its_back_pressure(Noise(150.0))
    experiment = prepare(
        record_of(**{name: values[:6000] for name, values in columns.items()}), DECLARED)
    thin, _ = experiment.thinned(8)
    left = thin.measured['chamber_pressure'] - thin.predict(DECLARED)['chamber_pressure']
    assert np.mean((left / thin.noise['chamber_pressure'])**2) < 1.3


@pytest.mark.parametrize(('every', 'correlation'), [(1, 0.0), (8, 0.0), (1, 0.9)])
def test_noise_of_a_drive_that_is_drawn_is_that_of_its_samples(every, correlation):
    drawn = DriveNoise(100.0, every, correlation).draw(40_000, np.random.default_rng(1))
    assert len(drawn) == 40_000
    samples = drawn[::every]
    assert np.std(samples) == pytest.approx(100.0, rel=0.05)
    assert np.corrcoef(samples[1:], samples[:-1])[0, 1] == pytest.approx(correlation, abs=0.05)
    if every > 1:
        halfway = drawn[every // 2::every]
        assert halfway[:-1] == pytest.approx(0.5 * (samples[1:] + samples[:-1])[:len(halfway) - 1])


@pytest.mark.parametrize('every', [1, 2, 5])
def test_a_drive_slower_than_the_rows_is_as_noisy_as_it_is(every):
    columns = step_test()
    del columns['control_current']
    columns['chamber_pressure'][np.arange(ROWS) % every > 0] = np.nan
    (misfit,) = misfits(columns).values()
    assert 0.6 < misfit < 1.7


def test_levels_between_which_a_drive_steps_are_no_noise():
    supply = np.full(ROWS, 400e3)
    constant = prepare(record_of(**step_test(), supply_pressure=supply), DECLARED)
    supply[ROWS // 2:] = 410e3
    stepped = prepare(record_of(**step_test(), supply_pressure=supply), DECLARED)
    assert stepped.noise == pytest.approx(constant.noise, rel=1e-3)
    assert stepped.drive_noise == constant.drive_noise


def test_drives_of_a_sweep_have_no_noise_that_could_be_told():
    """On a bench supply and back pressure stand at a few levels each."""
    levels = np.repeat([100e3, 150e3, 200e3], ROWS // 3)
    rows = {name: values[:len(levels)] for name, values in (BACK | CHAMBER | FLOW).items()}
    assert prepare(record_of(**rows, supply_pressure=levels), DECLARED).drive_noise == {}
