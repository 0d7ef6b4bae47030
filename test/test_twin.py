# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The twin without ROS: samples, prediction, alarms and what is kept."""

from __future__ import annotations

from killed_writer import killed_writer
from made_twin import moving_valve
import numpy as np
import pytest

from booster_ros.model.parameters import ParameterError, from_values
from booster_ros.model.stream import Stream
from booster_ros.twin.aligning import Aligner
from booster_ros.twin.alarm import Alarms, Settings
from booster_ros.twin.detector import Detector, evidence
from booster_ros.twin.health import health
from booster_ros.twin.learning import join_of
from booster_ros.twin.predictor import Predictor, roles, smoothed
from booster_ros.twin.settings import check
from booster_ros.twin.store import Store, StoreError
from booster_ros.twin.summaries import Summary, joined
from booster_ros.twin.trends import Counters
from booster_ros.twin.twin import Twin

pytestmark = pytest.mark.unit

RATE = 10.0
CELL = (0, 0)


def record(values=(), seconds=120.0, seed=0):
    """Return rows of a valve with these parameters that moves every five seconds."""
    return moving_valve(values, seconds, RATE, 5.0, seed)


def feed(twin, rows, begin=0.0):
    """Feed a twin with rows from `begin` s on, a second of them at a time."""
    for k, stamp in enumerate(rows['time'].tolist()):
        for name in ('control_current', 'chamber_pressure', 'valve_position'):
            twin.add(name, begin + stamp, float(rows[name][k]))
        if k % 10 == 9:
            twin.update()


def left_rms(rows, pieces=4):
    predictor = Predictor(from_values({}), frozenset(rows) - {'time'})
    left = {'chamber_pressure': [], 'valve_position': []}
    for places in np.array_split(np.arange(len(rows['time'])), pieces):
        told = predictor.advance({name: values[places] for name, values in rows.items()})
        for name in left:
            left[name].append(told.left[name])
    return {name: float(np.sqrt(np.nanmean(np.concatenate(parts)**2)))
            for name, parts in left.items()}, predictor


# Samples

def test_samples_come_out_in_order_and_what_was_wrong_with_them_is_counted():
    aligner = Aligner(patience=0.099)
    for stamp in (0.0, 0.2, 0.1, 0.2, 0.3):
        aligner.add('valve_position', stamp, stamp)
    aligner.add('valve_position', 0.4, float('nan'))
    aligner.add('control_current', 0.15, 4e-4)
    rows = aligner.rows()
    np.testing.assert_allclose(rows['time'], [0.0, 0.1, 0.15, 0.2])
    np.testing.assert_allclose(rows['valve_position'], [0.0, 0.1, np.nan, 0.2])
    np.testing.assert_allclose(rows['control_current'], [np.nan, np.nan, 4e-4, 4e-4])
    aligner.add('valve_position', 0.05, 0.0)
    counts = aligner.counts
    assert (counts.unordered, counts.repeated, counts.not_finite, counts.late) == (1, 1, 1, 1)


def test_a_jump_of_the_clock_begins_anew():
    aligner = Aligner()
    for stamp in (100.0, 100.1, 3.0, 3.1, 3.5):
        aligner.add('valve_position', stamp, 1e-3)
    assert aligner.counts.jumps == 1
    assert aligner.jumped
    np.testing.assert_allclose(aligner.rows()['time'], [3.0, 3.1])


# Prediction

def test_a_healthy_valve_leaves_little_more_than_noise():
    left, predictor = left_rms(record())
    assert left['chamber_pressure'] < 3.0 * 150.0
    assert left['valve_position'] < 3.0 * 8e-6
    assert predictor.restarts == 0


def test_a_fault_shows_where_it_is_born():
    healthy, _ = left_rms(record())
    rubs, _ = left_rms(record({'actuator.coulomb_friction': 300.0}))
    assert rubs['valve_position'] > 10.0 * healthy['valve_position']
    assert rubs['chamber_pressure'] < 1.5 * healthy['chamber_pressure']
    leaks, _ = left_rms(record({'actuator.leak_area': 2e-7}))
    assert leaks['chamber_pressure'] > 3.0 * healthy['chamber_pressure']
    assert leaks['valve_position'] < 1.5 * healthy['valve_position']


@pytest.mark.parametrize('values', [
    {'sensors.pressure_bias': 5e3, 'sensors.position_span_error': 0.03},
    {'sensors.position_backlash': 3e-4}], ids=['bias', 'play'])
def test_what_a_sensor_adds_is_taken_off_before_its_reading_drives(values):
    rows = record(values)
    left = {'chamber_pressure': [], 'valve_position': []}
    predictor = Predictor(from_values(values), frozenset(rows) - {'time'})
    told = predictor.advance(rows)
    left = {name: float(np.sqrt(np.nanmean(told.left[name][300:]**2))) for name in left}
    assert left['chamber_pressure'] < 500.0
    assert left['valve_position'] < 3e-5


def test_after_a_dropout_the_prediction_begins_anew_and_says_nothing_until_it_has_settled():
    rows = record()
    gap = (rows['time'] > 50.0) & (rows['time'] < 60.0)
    for name in ('chamber_pressure', 'valve_position'):
        rows[name][gap] = np.nan
    left, predictor = left_rms(rows)
    assert predictor.restarts == 2  # once for each part
    assert left['valve_position'] < 3.0 * 8e-6


def test_it_does_not_matter_in_which_portions_samples_come():
    rows = record(seconds=60.0)

    def left(portion):
        predictor = Predictor(from_values({}), frozenset(rows) - {'time'})
        told = [predictor.advance({name: values[k:k + portion] for name, values in rows.items()})
                for k in range(0, len(rows['time']), portion)]
        time = np.concatenate([one.time for one in told])
        np.testing.assert_allclose(time, rows['time'][:len(time)])
        return np.concatenate([one.left['chamber_pressure'] for one in told])

    whole, cut = left(600), left(3)
    settled = slice(round(7.0 * RATE), 590)
    np.testing.assert_allclose(cut[settled], whole[settled], atol=20.0)


def test_parts_are_driven_by_what_is_measured():
    p = from_values({})
    assert roles(p, frozenset({'valve_position'})) == ()
    assert [role.pinned for role in roles(p, frozenset({'chamber_pressure', 'valve_position'}))] \
        == [('chamber_pressure',)]
    loop = from_values({'position_controller.enabled': True})
    told = roles(loop, frozenset({'set_point', 'valve_position'}))
    assert [(role.channel, role.command) for role in told] == [('valve_position', 'set_point')]


def test_a_straight_line_has_its_own_value_and_slope():
    time = np.sort(np.random.default_rng(0).random(200)) + 1e6
    value, slope = smoothed(time, 3.0 + 2.0 * (time - 1e6))
    np.testing.assert_allclose(value, 3.0 + 2.0 * (time - 1e6), atol=1e-4)
    np.testing.assert_allclose(slope[5:-5], 2.0, atol=1e-3)


# Alarms

def test_the_evidence_of_a_healthy_valve_is_one_on_average():
    edges = np.geomspace(1e-12, 1.0, 40_001)
    middle = np.sqrt(edges[1:] * edges[:-1])
    integral = np.sum(np.array([evidence(p) for p in middle]) * np.diff(edges))
    # the part below 1e-12 is missing: 1 / ln 1e12
    assert integral == pytest.approx(1.0 - 1.0 / np.log(1e12), abs=2e-3)


@pytest.mark.parametrize('law', ['heavy tails', 'coloured'])
def test_false_alarms_keep_to_the_promised_rate_and_are_not_rare_for_want_of_power(law):
    """A detector whose p-values or bets were wrong would give many more, or none."""
    mean, length, valves = 20.0, 600, 15
    alarms = 0
    for seed in range(valves):
        random = np.random.default_rng(seed)
        noise = random.standard_t(3, length)
        if law == 'coloured':  # within a block: its mean is what is left of the colour
            rows = random.standard_normal((length, 50))
            for k in range(1, 50):
                rows[:, k] += 0.7 * rows[:, k - 1]
            noise = rows.mean(axis=1)
        detector = Detector(0.0, mean, seed)
        alarms += sum(detector.note(float(k), CELL, float(x)) for k, x in enumerate(noise))
    expected = valves * length / mean
    assert alarms <= expected + 3.0 * np.sqrt(expected)
    assert alarms >= 0.1 * expected


def test_a_drift_within_the_declared_one_is_no_alarm_and_beyond_it_is():
    random = np.random.default_rng(0)
    course = np.sin(2.0 * np.pi * np.arange(4000) / 1000.0)

    def alarms(size: float) -> int:
        detector = Detector(1.0, 100.0)
        return sum(detector.note(float(k), CELL, float(x)) for k, x in enumerate(
            0.1 * random.standard_normal(4000) + size * course))

    assert alarms(0.9) == 0
    detector = Detector(1.0, 1e6)
    numbers = 0.3 * random.standard_normal(2000)
    numbers[1000:] += 4.0
    told = [k for k, x in enumerate(numbers) if detector.note(float(k), CELL, float(x))]
    assert 1000 <= told[0] < 1030


def test_a_clear_change_is_seen_though_its_own_blocks_are_soon_among_those_it_is_compared_with():
    random = np.random.default_rng(0)
    detector = Detector(0.0, 1e8)
    numbers = random.standard_normal(200)
    numbers[100:] += 30.0
    told = [k for k, x in enumerate(numbers) if detector.note(float(k), CELL, float(x))]
    assert 100 < told[0] < 115


def test_a_clear_change_is_seen_where_few_blocks_of_each_cell_were_learnt():
    """Twelve blocks a cell: each block tells little, and most of what there is has to be bet."""
    random = np.random.default_rng(0)
    detector = Detector(0.0, 1e8)
    numbers = random.standard_normal(148)
    numbers[48:] += 30.0
    told = [k for k, x in enumerate(numbers) if detector.note(
        float(k), (k % 4, 0), float(x))]
    assert 48 < told[0] < 78


def test_blocks_that_are_joined_have_the_cell_of_most_of_them():
    cells = [(1, 0), (1, 1), (1, 0), (1, 0)]
    one = joined([block._replace(cells={'valve_position': cell}) for block, cell in zip(
        blocks_of(np.zeros(4)), cells)])
    assert one.cells == {'valve_position': (1, 0)}
    assert (one.begin, one.end) == (0.0, 80.0)


def test_another_operating_point_is_no_alarm():
    random = np.random.default_rng(0)
    detector = Detector(0.0, 1000.0)
    for k in range(400):
        assert not detector.note(float(k), (0, 0), float(random.standard_normal()))
    for k in range(400):
        assert not detector.note(400.0 + k, (2, 2), 50.0 + float(random.standard_normal()))


def blocks_of(numbers):
    return [Summary(20.0 * k, 20.0 * k + 20.0, {'valve_position': CELL},
                    {('valve_position', 'level'): float(x)})
            for k, x in enumerate(numbers)]


def test_blocks_are_joined_until_they_do_not_hang_together():
    random = np.random.default_rng(0)
    white = random.standard_normal(800)
    coloured = white.copy()
    for k in range(1, 800):
        coloured[k] += 0.5 * coloured[k - 1]
    assert join_of(blocks_of(white)) == 1
    assert join_of(blocks_of(coloured)) in (2, 4, 8)


def test_nothing_is_promised_before_the_valve_has_shown_how_it_is():
    random = np.random.default_rng(0)
    alarms = Alarms(Settings(learning=1200.0), [('valve_position', 'level')])
    blocks = blocks_of(1e-3 * random.standard_normal(100))
    for block in blocks[:59]:
        assert alarms.note(block) == []
    assert not alarms.promised
    assert alarms.lacking.startswith('learning: 1180 of 1200 s')
    alarms.note(blocks[59])
    assert alarms.promised
    assert alarms.lacking == ''


@pytest.mark.parametrize('portion', [1, 7, 100])
def test_blocks_have_their_length_however_seldom_samples_are_used(portion):
    rows, blocks = record(seconds=60.0), []
    twin = Twin(from_values({}), Settings(block=2.0, learning=1e6))
    for k in range(len(rows['time'])):
        for name in ('control_current', 'chamber_pressure', 'valve_position'):
            twin.add(name, float(rows['time'][k]), float(rows[name][k]))
        if k % portion == portion - 1:
            twin.update()
            blocks = twin.alarms and twin.alarms.as_values()['first']
    begins = np.array([begin for begin, *_ in blocks])
    np.testing.assert_allclose(np.diff(begins), 2.0)
    assert len(blocks) >= 20


def test_blocks_that_have_too_few_rows_to_be_judged_are_said():
    twin = Twin(from_values({}), Settings(block=1.0, learning=1e6))
    feed(twin, record(seconds=20.0))
    assert twin.health.status == 'function check'
    assert twin.health.reason == ('10 rows have come in a block of 1 s, and 16 are needed: the '
                                  'parameter block has to be larger')


def test_samples_of_a_control_system_a_second_apart_are_predicted_from_one_to_the_next():
    p = from_values({'position_controller.enabled': True})
    time = np.arange(120.0)
    set_point = 4e-3 + 8e-3 * (time % 40.0 >= 20.0)
    read = Stream(p, 0.0, set_point[0]).advance(time, set_point)['valve_position']
    twin, left = Twin(p, Settings(block=20.0, learning=1e6)), []
    for k, stamp in enumerate(time.tolist()):
        twin.add('set_point', stamp, float(set_point[k]))
        twin.add('valve_position', stamp, float(read[k]))
        twin.update()
        if 'valve_position' in twin.now:
            left.append(twin.now['valve_position'].read - twin.now['valve_position'].said)
    assert twin.alarms.seen >= 4
    assert twin.history.end - twin.history.begin > 100.0
    assert np.max(np.abs(left[30:])) < 0.1e-3


def test_a_fault_that_moves_the_valve_to_where_it_never_was_is_seen_where_it_is_born():
    twin = Twin(from_values({}), Settings(block=2.0, learning=160.0, false_alarms=1e3))
    for begin, values in ((0.0, {}), (200.0, {'ep_converter.gain_loss': 0.25})):
        feed(twin, record(values, seconds=200.0), begin)
        assert bool(twin.latched) == bool(values)
    first = min(twin.latched, key=lambda alarm: alarm.time)
    assert first.channel == 'chamber_pressure'
    assert 200.0 < first.time < 240.0


def test_where_no_alarm_can_be_given_the_valve_is_not_called_good_all_the_same():
    """A stop within the travel shows where the valve had not been while it was learnt."""
    limited = {'actuator.upper_travel_lost': 0.4}
    rows = [moving_valve({}, 200.0, RATE, 5.0, 0, 0.41e-3, 0.425e-3),
            moving_valve(limited, 100.0, RATE, 5.0, 1, 0.45e-3, 0.46e-3)]
    twin, told = Twin(from_values({}), Settings(block=2.0, learning=160.0)), []
    for begin, columns in zip((0.0, 200.0), rows):
        feed(twin, columns, begin)
        told.append(twin.health)
    assert told[0].status != 'out of specification', told[0]
    assert not twin.latched
    assert told[1].status == 'out of specification', told[1]
    assert 'the model misses valve_position by' in told[1].reason
    again = Twin(from_values({}), Settings(block=2.0, learning=160.0))
    again.recall(twin.calibration())
    feed(again, {name: values[:600] for name, values in rows[1].items()})
    assert again.health == told[1]._replace(reason=again.health.reason)


# Health, trends, what is kept, parameters

def test_health_says_the_worst_that_holds():
    assert health([], [], [], '').status == 'good'
    assert health([], [], [], 'learning').status == 'function check'
    assert health([], ['it sticks'], [], 'learning').status == 'maintenance required'
    assert health(['valve_position'], ['it sticks'], ['x'], '').status == 'failure'


def test_noise_is_no_way_and_turns_are_counted():
    counters = Counters(1e-4)
    counters.add(1e-5 * np.random.default_rng(0).standard_normal(1000))
    assert counters.values == {'way [m]': 0.0, 'turns': 0.0}
    counters.add(1e-3 * np.sin(np.linspace(0.0, 2.0 * np.pi * 5.0, 1000)))
    assert counters.turns == 10.0
    # the band is lost at each turn
    assert counters.way == pytest.approx(20e-3 - 10 * 2e-4 - 1e-4, rel=0.01)


WRITER = """
import os, sys
from booster_ros.twin.store import Store
store = Store(sys.argv[1])
for k in range(10 ** 9):
    store.trends(float(k), {'a': float(k), 'b': float(-k)})
    os.write(1, b'%d\\n' % k)
"""


def test_what_was_written_outlives_a_kill(tmp_path):
    path = tmp_path / 'trends.sqlite'
    told = killed_writer(WRITER, path, 50)
    kept = Store(path).latest()
    assert kept['a'] >= told
    assert kept['b'] == -kept['a']


def test_a_file_that_is_no_store_is_named(tmp_path):
    path = tmp_path / 'text.sqlite'
    path.write_text('no database at all, but long enough to be read as one' * 40)
    with pytest.raises(StoreError, match=r'text\.sqlite'):
        Store(path)


def test_parameters_that_contradict_each_other_are_refused():
    with pytest.raises(ParameterError, match='24 blocks'):
        check({'block': 100.0, 'learning': 1000.0})
    with pytest.raises(ParameterError, match='did you mean drift'):
        check({'drifts': 0.1})
