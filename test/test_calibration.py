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
    timed_columns,
)
import numpy as np
import pytest
from scipy.signal import lfilter

from booster_ros.diagnosis.calibration import calibrated, repeats
from booster_ros.diagnosis.experiment.experiment import DriveNoise
from booster_ros.diagnosis.experiment.noise_colour import (
    FEWEST_PIECES, MOST_ROWS, Noise, noise_of, rests_of)
from booster_ros.diagnosis.preparing.preparation import prepare
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


def settling(time=TIME, drive=STEPS):
    """Return a signal (of size 1) that follows the drive with a lag and creeps a little."""
    share = 1.0 - np.exp(-(time[1] - time[0]) / 0.3)
    followed = lfilter([share], [1.0, share - 1.0], (drive - drive[0]) / np.ptp(drive))
    return followed + 0.1 * np.sin(time / 20.0)


@pytest.mark.parametrize('correlation', [-0.5, 0.5, 0.9])
def test_colour_and_level_of_noise_are_found_at_rests_of_a_moving_signal(correlation):
    noise = Noise(2e-3, correlation)
    shown = noise.added_to(settling(), np.random.default_rng(3))
    found = noise_of(shown, rests_of(TIME, [STEPS]))
    assert found.correlation == pytest.approx(correlation, abs=0.06)
    assert found.level == pytest.approx(2e-3, rel=0.15)


def test_slow_noise_that_is_rounded_is_nearly_as_loud_as_it_is():
    """Of slow noise some pieces hold far more than others: that is no valve which has moved."""
    rests = [slice(100 * k, 100 * k + 100) for k in range(0, 140, 2)]
    found = []
    for seed in range(20):
        shown = Noise(150.0, 0.95).added_to(np.zeros(15000), np.random.default_rng(seed))
        found.append(noise_of(25.0 * np.round(shown / 25.0), rests).level)
    assert np.mean(found) == pytest.approx(150.0, rel=0.1)


@pytest.mark.parametrize('step', [0.0, 0.5])
@pytest.mark.parametrize(('correlation', 'pieces'), [(0.8, 12), (0.9, 21), (0.95, 21)])
def test_short_pieces_of_slow_noise_tell_its_level_to_within_a_half(correlation, pieces, step):
    """Most likely is at times a noise that hardly fades at all, four times as loud as it is."""
    rests = [slice(50 * k, 50 * k + 50) for k in range(0, 2 * pieces, 2)]
    found = []
    for seed in range(40):
        shown = Noise(1.0, correlation).added_to(
            np.zeros(100 * pieces), np.random.default_rng(seed))
        found.append(noise_of(shown if not step else step * np.round(shown / step), rests).level)
    assert 0.75 < np.median(found) < 1.15
    assert np.quantile(found, 0.05) > 0.5
    assert np.quantile(found, 0.95) < 1.6


def test_noise_of_a_quantised_white_record_is_found_again_in_what_is_simulated_with_it():
    rng = np.random.default_rng(4)
    step = 1e-3
    shown = step * np.round((settling() + 2e-3 * rng.standard_normal(len(TIME))) / step)
    found = noise_of(shown, rests_of(TIME, [STEPS]))
    assert found.correlation == 0.0
    assert found.resolution == pytest.approx(step)
    again = found.added_to(settling(), rng)
    assert np.allclose(again / step, np.round(again / step))
    assert np.std(again - settling()) == pytest.approx(np.hypot(2e-3, step / np.sqrt(12)), rel=0.03)


def test_a_ripple_at_rests_is_not_taken_for_noise():
    rng = np.random.default_rng(9)
    shown = settling() + 4e-3 * np.sin(2.0 * np.pi * 5.0 * TIME)
    shown += 2e-3 * rng.standard_normal(len(TIME))
    found = noise_of(shown, rests_of(TIME, [STEPS]))
    assert found.correlation == 0.0
    assert found.level == pytest.approx(2e-3, rel=0.05)


def test_a_valve_that_slips_at_rests_is_not_taken_for_noise():
    rng = np.random.default_rng(11)
    slips = 20e-3 * rng.standard_normal(len(TIME)) * (rng.random(len(TIME)) < 0.05)
    hunting = lfilter([1.0], [1.0, -0.9], slips)
    shown = settling() + hunting + 1e-3 * rng.standard_normal(len(TIME))
    assert noise_of(shown, rests_of(TIME, [STEPS])).correlation == 0.0


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


def test_without_rests_noise_is_white_and_of_the_level_of_differences():
    ramp = np.linspace(0.36e-3, 0.46e-3, len(TIME))
    assert rests_of(TIME, [ramp]) == []
    shown = Noise(2e-3).added_to(settling(), np.random.default_rng(5))
    found = noise_of(shown, [])
    assert found.correlation == 0.0
    assert found.level == pytest.approx(2e-3, rel=0.05)


def test_a_rest_begins_when_all_drives_have_settled_and_holds_no_gap():
    supply = 400e3 + np.where(TIME > 100.0, 5e3, 0.0)
    time = TIME + np.where(TIME > 50.0, 7.0, 0.0)
    moves = np.flatnonzero(np.diff(STEPS) + np.diff(supply))
    changes = time[moves + 1]
    rests = rests_of(time, [STEPS, supply])
    assert len(rests) > 40
    for rest in rests:
        inside = time[rest]
        assert inside[-1] - inside[0] < 2.0
        assert not any(inside[0] - 2.9 < change < inside[-1] for change in changes)


def test_a_rest_of_a_fast_record_is_cut_into_pieces_that_can_be_reckoned_with():
    time = 2e-4 * np.arange(40_000)
    rests = rests_of(time, [np.zeros(len(time))])
    assert len(rests) >= FEWEST_PIECES
    assert all(rest.stop - rest.start == MOST_ROWS for rest in rests)


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

    found = calibrated(diagnosis, 20, 1, lambda *said: told.append(said), judge).false_add
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
    diagnosis = calibrated(diagnosis, 4, 1, None, lambda *_: next(verdicts))
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
        calibrated(nothing_found(), 0, 1)


def test_the_command_calibrates_on_a_short_clean_record(tmp_path, capsys):
    columns = timed_columns(seconds=40.0)
    with CsvWriter(tmp_path / 'record.csv', tuple(columns)) as writer:
        writer.write_rows(np.column_stack(list(columns.values())))
    write_parameter_file(tmp_path / 'declared.yaml', PositionerParameters())
    out = tmp_path / 'out'
    status = main(['--record', str(tmp_path / 'record.csv'), '--out', str(out), '--params',
                   str(tmp_path / 'declared.yaml'), '--calibrate', '1', '--seed', '5'])
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
