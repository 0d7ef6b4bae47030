# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The figures of a valve, where the response is known by formula."""

from itertools import pairwise
import json
import math

import numpy as np
import pytest

from booster_ros.metrics.figures import Figures, figures_of
from booster_ros.metrics.segments import Course, noise_level
from booster_ros.metrics.stick_slip import stick_slip_index
from booster_ros.programs import metrics as program
from booster_ros.records import Record, RecordError

TRAVEL = 0.016
ROW = 0.01
NOISE = 5e-6


def record_of(time, set_point, position) -> Record:
    columns = {'time': time, 'set_point': set_point, 'valve_position': position}
    return Record(columns, 'made', (), np.arange(2, len(time) + 2))


def noisy(values, level=NOISE):
    return values + level * np.random.default_rng(3).standard_normal(len(values))


def answers(levels, dwell, response):
    """Return time, set point and the sum of the responses (to a unit step) to steps of it."""
    time = np.arange(round(len(levels) * dwell / ROW)) * ROW
    place = np.minimum((time / dwell + 1e-9).astype(int), len(levels) - 1)
    set_point = np.array(levels)[place]
    position = np.full(len(time), levels[0])
    for k, (before, after) in enumerate(pairwise(levels), 1):
        position += (after - before) * response(time - k * dwell)
    return time, set_point, position


def first_order(since, dead_time=0.25, lag=0.4):
    return np.where(since > dead_time, 1.0 - np.exp(-(since - dead_time) / lag), 0.0)


def second_order(since, damping=0.4, natural=6.0):
    root = math.sqrt(1.0 - damping**2)
    t = np.maximum(since, 0.0)
    return 1.0 - np.exp(-damping * natural * t) * (
        np.cos(root * natural * t) + damping / root * np.sin(root * natural * t))


def found(levels, response, dwell=8.0, level=NOISE) -> Figures:
    time, set_point, position = answers(levels, dwell, response)
    return figures_of(record_of(time, set_point, noisy(position, level)))


def test_a_lag_behind_a_dead_time():
    """T at a share s of the change is T_d - τ ln(1 - s)."""
    figures = found([4e-3, 8e-3, 6e-3], first_order)
    assert figures.noise == pytest.approx(NOISE, rel=0.1)
    assert [step.size for step in figures.steps] == pytest.approx([4e-3, -2e-3])
    assert [step.first for step in figures.steps] == [802, 1602]
    for step in figures.steps:
        assert step.settled
        assert step.gain == pytest.approx(1.0, abs=0.01)
        assert step.overshoot == 0.0
        assert step.dead_time == pytest.approx(0.25, abs=0.02)
        for value, share in ((step.t63, 0.632), (step.t86, 0.865), (step.t98, 0.98)):
            assert value == pytest.approx(0.25 - 0.4 * math.log(1.0 - share), abs=0.04), share


@pytest.mark.parametrize('damping', [0.3, 0.6])
def test_an_overshoot_is_that_of_the_formula(damping):
    figures = found([4e-3, 8e-3], lambda since: second_order(since, damping))
    expected = math.exp(-math.pi * damping / math.sqrt(1.0 - damping**2))
    assert figures.steps[0].overshoot == pytest.approx(expected, abs=0.01)


def test_a_travel_gain_and_an_offset():
    figures = found([4e-3, 8e-3], lambda since: 0.9 * first_order(since))
    assert figures.steps[0].gain == pytest.approx(0.9, abs=0.005)
    assert figures.steps[0].offset == pytest.approx(0.4e-3, abs=10e-6)


def test_a_step_whose_end_is_not_seen_has_no_times():
    figures = found([4e-3, 8e-3, 4e-3], lambda since: first_order(since, 0.2, 3.0), dwell=4.0)
    assert not figures.steps[0].settled
    assert figures.steps[0].t63 is None
    assert figures.steps[0].gain is None


def test_noise_beyond_two_per_cent_of_a_step_hides_t98_alone():
    step = found([4e-3, 4.2e-3], first_order).steps[0]
    assert step.t98 is None
    assert step.t63 == pytest.approx(0.25 + 0.4, abs=0.05)


def behind_play(set_point, width, lag=0.1):
    """Return a position that follows the set point through a play, then a lag."""
    place = followed = set_point[0]
    out = []
    for value in set_point:
        place = min(max(place, value - 0.5 * width), value + 0.5 * width)
        followed += (place - followed) * ROW / lag
        out.append(followed)
    return np.array(out)


@pytest.mark.parametrize('width', [60e-6, 150e-6])
def test_small_steps_bracket_a_dead_band(width):
    """Steps of 40 µm, four up and four down: those that come after a turn, added up, count."""
    levels = 4e-3 + 40e-6 * np.array([0, 1, 2, 3, 4, 5, 6, 5, 4, 3, 2, 1, 0, -1, 0, 1, 2, 3, 4, 5])
    time, set_point, _ = answers(levels.tolist(), 3.0, first_order)
    figures = figures_of(record_of(time, set_point, noisy(behind_play(set_point, width), 1e-6)))
    low, high = figures.dead_band.without_motion, figures.dead_band.with_motion
    assert low <= width <= high
    assert high - low == pytest.approx(40e-6, abs=1e-9)
    assert figures.resolution.without_motion is None
    assert figures.resolution.with_motion == pytest.approx(40e-6)
    # the stem stands half a play below where it is approached from below, half a play above else
    assert figures.hysteresis.difference == pytest.approx(width, rel=0.15)


def test_a_triangle_shows_the_dead_band_where_it_turns():
    time = np.arange(0.0, 160.0, ROW)
    set_point = 6e-3 + 2e-3 * np.abs(np.mod(time / 20.0, 2.0) - 1.0)
    position = behind_play(set_point, 200e-6)
    figures = figures_of(record_of(time, set_point, noisy(position, 2e-6)))
    changes = [turn.change for turn in figures.turns]
    assert len(changes) == 7
    assert changes == pytest.approx([200e-6] * 7, rel=0.2)
    assert max(ramp.jumpiness for ramp in figures.ramps) < 0.25


def test_a_record_without_steps_says_so():
    time = np.arange(0.0, 30.0, ROW)
    figures = figures_of(record_of(time, np.full_like(time, 4e-3), noisy(np.full_like(time, 4e-3))))
    assert figures.steps == ()
    assert figures.dead_band.rows == ()
    assert figures.hysteresis is None
    assert figures.limit_cycles == ()


WAVES = {
    'jumps': (lambda phase: np.sign(np.sin(phase)), 0.95, 1.0),
    'sine': (np.sin, 0.1, 0.4),
    'triangle': (lambda phase: 2.0 / np.pi * np.arcsin(np.sin(phase)), 0.0, 0.15),
}


@pytest.mark.parametrize('wave', WAVES)
def test_a_swing_at_a_standing_set_point_is_a_limit_cycle(wave):
    form, least, most = WAVES[wave]
    time = np.arange(0.0, 160.0, ROW)
    position = 4e-3 + 0.1e-3 * form(2.0 * np.pi * time / 9.0)
    figures = figures_of(record_of(time, np.full_like(time, 4e-3), noisy(position, 1e-6)))
    (cycle,) = figures.limit_cycles
    assert cycle.amplitude == pytest.approx(0.2e-3, rel=0.05)
    assert cycle.period == pytest.approx(9.0, rel=0.03)
    assert least <= cycle.jumpiness <= most


def test_noise_alone_is_no_limit_cycle_and_a_random_walk_neither():
    time = np.arange(0.0, 160.0, ROW)
    walk = 4e-3 + np.cumsum(2e-6 * np.random.default_rng(5).standard_normal(len(time)))
    for position in (noisy(np.full_like(time, 4e-3)), walk):
        figures = figures_of(record_of(time, np.full_like(time, 4e-3), position))
        assert figures.limit_cycles == ()


def test_stairs_are_stick_slip_and_a_ramp_is_not():
    time = np.arange(0.0, 40.0, ROW)
    ramp = 4e-3 + 50e-6 * time
    stairs = np.floor(ramp / 200e-6) * 200e-6
    assert stick_slip_index(time, noisy(stairs, 2e-6), 2e-6) > 0.7
    assert stick_slip_index(time, noisy(ramp, 2e-6), 2e-6) < 0.3
    assert stick_slip_index(time, noisy(np.full_like(time, 4e-3)), NOISE) is None


def test_the_noise_of_a_reading_in_steps_is_that_of_its_rounding():
    time = np.arange(0.0, 20.0, ROW)
    position = np.round((4e-3 + 1e-3 * np.sin(0.2 * time)) / 4e-6) * 4e-6
    assert noise_level(Course(time, position, position)) >= 0.999 * 4e-6 / math.sqrt(12.0)


@pytest.mark.parametrize('lacking', ['time', 'set_point', 'valve_position'])
def test_a_record_that_lacks_a_column_is_refused(lacking):
    time, set_point, position = answers([4e-3, 8e-3], 2.0, first_order)
    columns = dict(record_of(time, set_point, position).columns)
    del columns[lacking]
    with pytest.raises(RecordError, match=f'made: there is no column {lacking}'):
        figures_of(Record(columns, 'made', (), np.arange(len(time))))


def write(path, text):
    path.write_text(text, encoding='utf-8')
    return path


def table():
    time, set_point, position = answers([4e-3, 8e-3, 6e-3], 8.0, first_order)
    rows = np.column_stack((time, set_point, noisy(position)))
    return 'time,set_point,valve_position\n' + ''.join(
        f'{t:.2f},{r:.9f},{y:.9f}\n' for t, r, y in rows)


def test_the_program_prints_and_writes_the_figures(tmp_path, capsys):
    source, out = write(tmp_path / 'record.csv', table()), tmp_path / 'figures.json'
    assert program.main(['--record', str(source), '--travel', '0.016', '--out', str(out)]) == 0
    printed = capsys.readouterr().out
    assert 'Lengths in % of travel' in printed
    assert '25.000' in printed  # 4 of 16 mm
    figures = json.loads(out.read_text())
    assert figures['steps'][0]['t63'] == pytest.approx(0.65, abs=0.04)
    assert [entry.name for entry in tmp_path.iterdir() if entry.name.startswith('.')] == []


def test_the_program_refuses_in_a_sentence(tmp_path, capsys):
    source = write(tmp_path / 'record.csv', 'time,valve_position\n0,0.004\n1,0.004\n')
    assert program.main(['--record', str(source)]) == 2
    assert capsys.readouterr().err == (
        f'metrics: {source}: there is no column set_point; figures of a valve need time, '
        'set_point, valve_position\n')
    assert program.main(['--record', str(source), '--out', str(source)]) == 2
    assert 'choose another --out' in capsys.readouterr().err
    with pytest.raises(SystemExit):
        program.main(['--record', str(source), '--travel', '16 mm'])
    assert 'must be metres' in capsys.readouterr().err


def test_a_stem_that_creeps_on_has_not_answered_a_step():
    time, set_point, position = answers([4e-3, 5e-3, 4.9e-3], 8.0, first_order)
    creeps = np.where(time > 16.0, position[1599] + 1e-6 * (time - 16.0), position)
    steps = figures_of(record_of(time, set_point, noisy(creeps, 1e-8))).steps
    assert [step.change == 0.0 for step in steps] == [False, True]
