# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Thinned rows of an experiment hold what all of its rows do."""

from made_diagnosis import DECLARED
from made_record import ROWS, record_of, step_test
import numpy as np

from booster_ros.diagnosis.prepare.preparation import prepare
from booster_ros.model.simulation import simulate


def test_thinned_rows_hold_the_jumps_of_a_measured_drive():
    time = 0.01 * np.arange(4000)
    current = np.where(time % 8.0 < 4.0, 0.43e-3, 0.45e-3)
    declared = DECLARED._replace(ep_converter=DECLARED.ep_converter._replace(time_constant=1e-3))
    run = simulate(declared, time, current, {'chamber_pressure': 215e3})
    back = run['back_pressure'] + 100.0 * np.random.default_rng(2).standard_normal(len(time))
    experiment = prepare(record_of(
        time=time, back_pressure=back, chamber_pressure=run['chamber_pressure'],
        valve_position=run['valve_position']), declared)
    thin, kept = experiment.thinned(8)
    assert len(kept) < len(time) / 7
    whole, fewer = experiment.predict(declared), thin.predict(declared)
    for name, apart in (('chamber_pressure', 100.0), ('valve_position', 10e-6)):
        assert np.std(fewer[name] - whole[name][kept]) < apart


def test_thinned_rows_hold_every_channel_wherever_its_samples_are():
    columns = step_test()
    columns['chamber_pressure'][1::2] = np.nan
    columns['valve_position'][0::2] = np.nan
    columns['chamber_pressure'][0] = 0.0
    thin, kept = prepare(record_of(**columns), DECLARED).thinned(8)
    assert kept[0] == 0
    assert len(kept) < ROWS / 7
    for values in thin.measured.values():
        assert np.isfinite(values).sum() > 0.4 * len(kept)


def test_what_the_solver_leaves_is_noise_in_a_record_without_noise():
    time = 0.02 * np.arange(1500)
    current = np.where(time % 8.0 < 4.0, 0.43e-3, 0.45e-3)
    run = simulate(DECLARED, time, current, {'chamber_pressure': 215e3})
    experiment = prepare(record_of(
        time=time, control_current=current, chamber_pressure=run['chamber_pressure'].round(3),
        valve_position=run['valve_position'].round(9)), DECLARED)
    thin, _ = experiment.thinned(8)
    predicted = thin.predict(DECLARED)
    for name, values in thin.measured.items():
        assert np.mean(((values - predicted[name]) / thin.noise[name])**2) < 0.5
    assert experiment.notes == ()
