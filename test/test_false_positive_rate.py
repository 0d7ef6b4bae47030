# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The false-add calibration: the noise it adds, the records it makes, what it counts."""

from dataclasses import replace
import json

from made_diagnosis import (
    friction_found,
    friction_found_in_a_sweep,
    nothing_found,
    record_of,
)
import numpy as np
import pytest

from booster_ros.diagnosis.judging.false_positive_rate import calibrated, repeats
from booster_ros.diagnosis.data.experiment import DriveNoise
from booster_ros.signals.noise_autocorrelation import Noise
from booster_ros.diagnosis.prepare.preparation import prepare
from booster_ros.model.simulation import simulate
from booster_ros.model.system import PositionerParameters
from booster_ros.parameters.file import write_parameter_file
from booster_ros.programs.close_loop import main
from booster_ros.records import CsvWriter
from booster_ros.report.json_report import report_values
from booster_ros.report.provenance import Provenance
from booster_ros.report.wording import verdict_sentences

TIME = 0.01 * np.arange(12000)
STEPS = 0.4e-3 + 0.01e-3 * (np.floor(TIME / 8.0) % 3.0)


def test_repeats_of_rows_stamped_by_another_clock_have_late_commands():
    rng = np.random.default_rng(3)
    time = np.sort(0.02 * np.arange(3000) + 0.008 * rng.random(3000))
    current = 0.40e-3 + 0.03e-3 * (np.floor(time / 2.0) % 2.0)
    run = simulate(PositionerParameters(), time, current, {'chamber_pressure': 160e3})
    sensor = {'chamber_pressure': 20.0, 'valve_position': 1e-6}
    experiment = prepare(record_of({'time': time, 'control_current': current, **{
        name: run[name] + level * rng.standard_normal(3000) for name, level in sensor.items()}}),
        PositionerParameters())
    plain = experiment.predict(PositionerParameters())
    diagnosis = replace(nothing_found(), experiment=experiment, before=PositionerParameters(),
                        runs={'before': plain})
    made = list(repeats(diagnosis, 4, seed=2))
    for name, level in sensor.items():
        raised = experiment.noise[name]
        assert raised > 2.0 * level
        left = [one.measured[name] - plain[name] for one in made]
        assert np.sqrt(np.mean(np.square(left))) == pytest.approx(raised, rel=0.3)


def test_an_experiment_counts_coloured_noise_in_full():
    time = TIME[:6000]
    noise = {'chamber_pressure': Noise(150.0, 0.8), 'valve_position': Noise(8e-6)}
    run = simulate(PositionerParameters(), time, STEPS[:6000], {'chamber_pressure': 100e3})
    rng = np.random.default_rng(10)
    columns = {name: level.added_to(run[name], rng) for name, level in noise.items()}
    experiment = prepare(
        record_of({'time': time, 'control_current': STEPS[:6000], **columns}),
        PositionerParameters())
    for name, level in noise.items():
        assert experiment.noise[name] == pytest.approx(level.level, rel=0.15)


def test_a_repeat_is_the_refitted_model_with_noise_like_that_of_the_record():
    diagnosis = friction_found()
    first, second = repeats(diagnosis, 2, seed=7)
    (again, _) = repeats(diagnosis, 2, seed=7)
    for name, measured in first.measured.items():
        left = measured - diagnosis.runs['before'][name]
        assert np.std(left) == pytest.approx(diagnosis.experiment.noise[name], rel=0.15)
        assert not np.array_equal(measured, second.measured[name])
        assert np.array_equal(measured, again.measured[name])
    start = first.initial.chamber_pressure - diagnosis.runs['before']['chamber_pressure'][0]
    assert 0.0 < abs(start) < 4.0 * diagnosis.experiment.noise['chamber_pressure']


def test_noise_of_measured_drives_reaches_what_is_compared():
    diagnosis = friction_found_in_a_sweep()
    pressure = diagnosis.experiment.pinned['chamber_pressure']
    noisy = pressure + 500.0 * np.random.default_rng(6).standard_normal(len(pressure))
    experiment = replace(diagnosis.experiment, pinned={'chamber_pressure': noisy},
                         drive_noise={'chamber_pressure': DriveNoise(500.0)})
    before = experiment.predict(diagnosis.before)
    diagnosis = replace(diagnosis, experiment=experiment, runs={'before': before})
    (repeat,) = repeats(diagnosis, 1, seed=8)
    assert np.array_equal(repeat.pinned['chamber_pressure'], noisy)
    moved = repeat.measured['valve_position'] - before['valve_position']
    travelling = (before['valve_position'] > 1e-3) & (before['valve_position'] < 15e-3)
    assert np.std(moved[travelling]) > 0.5 * 500.0 * 0.016 / 150e3  # span of the bench set


def test_false_adds_are_counted_with_their_exact_interval():
    diagnosis, friction = nothing_found(), friction_found()
    seen, told = [], []

    def judge(experiment, declared, progress):
        seen.append(experiment)
        progress('half', 0.5)
        assert declared is diagnosis.declared
        return friction if len(seen) == 3 else diagnosis

    found = calibrated(diagnosis, 20, 1, judge, lambda *said: told.append(said)).false_add
    assert len(seen) == 20
    assert (found.runs, found.gained, found.rate) == (20, 1, 0.05)
    assert found.names == {'stem_friction': 1}
    # Clopper and Pearson's interval solves (1 - p)^20 + 20 p (1 - p)^19 = 0.025, and its mirror
    p = found.high
    assert (1 - p) ** 20 + 20 * p * (1 - p) ** 19 == pytest.approx(0.025, rel=1e-4)
    assert 1 - (1 - found.low) ** 20 == pytest.approx(0.025, rel=1e-4)
    assert told[0] == ('calibration 1 of 20: half', 0.5 / 20)
    assert told[-1] == ('calibration 20 of 20: half', 19.5 / 20)


def test_the_report_holds_the_rate_and_says_it_in_a_sentence():
    diagnosis, friction = nothing_found(), friction_found()
    verdicts = iter([friction, diagnosis, diagnosis, diagnosis])
    diagnosis = calibrated(diagnosis, 4, 1, lambda *_: next(verdicts))
    report = report_values(diagnosis, Provenance('plant.csv', 'declared.yaml'))['false_add']
    assert (report['runs'], report['gained'], report['rate']) == (4, 1, 0.25)
    assert report['names'] == {'stem_friction': 1}
    assert report['interval'] == [pytest.approx(0.0063, abs=1e-4), pytest.approx(0.8059, abs=1e-4)]
    assert 'added something in 1 of 4' in verdict_sentences(diagnosis)[-1]
    assert 'stem friction (1)' in verdict_sentences(diagnosis)[-1]


def test_without_calibration_nothing_is_said_of_it():
    values = report_values(nothing_found(), Provenance('plant.csv', 'declared.yaml'))
    assert values['false_add'] is None
    assert 'simulated records' not in values['summary']


def test_a_calibration_without_runs_is_refused():
    with pytest.raises(ValueError, match='at least one'):
        calibrated(nothing_found(), 0, 1, lambda *_: nothing_found())


def test_the_command_calibrates_on_a_short_clean_record(tmp_path, capsys):
    """Of a chamber that is shut off, in which next to nothing can be missing."""
    declared = PositionerParameters()
    declared = declared._replace(booster=declared.booster._replace(opening_gain=0.0))
    time = 0.2 * np.arange(150)
    noise = 100.0 * np.random.default_rng(5).standard_normal(len(time))
    with CsvWriter(tmp_path / 'record.csv', ('time', 'chamber_pressure')) as writer:
        writer.write_rows(np.column_stack([time, 140e3 + noise]))
    write_parameter_file(tmp_path / 'declared.yaml', declared)
    out = tmp_path / 'out'
    status = main(['--record', str(tmp_path / 'record.csv'), '--out', str(out), '--params',
                   str(tmp_path / 'declared.yaml'), '--calibrate', '1', '--seed', '5',
                   '--only', 'chamber_leak', 'pressure_sensor_bias'])
    assert status == 0
    report = json.loads((out / 'report.json').read_text())
    assert report['false_add']['runs'] == 1
    assert report['verdict'] == 'none'
    assert report['false_add']['gained'] == 0
    sentence = 'added something in 0 of 1'
    assert sentence in report['summary']
    assert sentence in capsys.readouterr().out
    assert sentence in (out / 'report.html').read_text()


@pytest.mark.parametrize(('option', 'text'), [('--calibrate', '0'), ('--calibrate', 'ten'),
                                              ('--seed', '-1')])
def test_bad_numbers_are_refused(option, text, capsys):
    with pytest.raises(SystemExit) as stopped:
        main(['--record', 'r', '--params', 'p', '--out', 'o', option, text])
    assert stopped.value.code == 2
    assert repr(text) in capsys.readouterr().err


def test_a_seed_for_no_calibration_is_refused(tmp_path, capsys):
    assert main(['--record', 'r', '--params', 'p', '--out', str(tmp_path), '--seed', '0']) == 2
    assert capsys.readouterr().err == 'close_loop: --seed is for --calibrate, which was not given\n'
