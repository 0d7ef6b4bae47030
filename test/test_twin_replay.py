# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Records that are played to a twin as a bag, and what changes of a valve come to in the table."""

from made_twin import moving_valve
import numpy as np
import pytest

from booster_ros.benchmark.twin_change import NONE, Came
from booster_ros.benchmark.twin_changes_table import table
from booster_ros.benchmark.twin_replay import BEGIN, messages, play, write_bag
from booster_ros.records import CsvWriter

RATE = 20.0


@pytest.mark.ros
def test_two_records_are_played_one_after_the_other_on_the_clock_of_the_bag(tmp_path):
    columns = moving_valve({}, 16.0, RATE, 1.0)
    halves = []
    for name, rows in (('first', slice(0, 160)), ('second', slice(160, None))):
        halves.append(tmp_path / f'{name}.csv')
        with CsvWriter(halves[-1], list(columns)) as writer:
            writer.write_rows(np.column_stack([one[rows] for one in columns.values()]))
    write_bag(halves, tmp_path / 'bag')
    stamps = [stamp for stamp, topic, _ in messages(tmp_path / 'bag') if topic == 'valve_position']
    np.testing.assert_allclose(np.array(stamps) / 1e9, BEGIN + columns['time'], atol=1e-6)
    heard = play(tmp_path / 'bag', {'block': 1.0, 'learning': 60.0})
    assert heard.health.startswith('function check: learning')
    settled = np.array(heard.left['valve_position'][-10:])
    assert np.all(np.abs(settled) < 6.0 * 8e-6)
    assert heard.alarms == []


def came(fault, effects, adoption='', **others):
    given = {
        'seed': 0, 'fault': fault, 'strength': 1.0, 'early': False, 'delay': 5.0,
        'noticed': 4.0, 'kind': 'found',
        'effects': effects, 'places': ['stem'], 'group': [*effects, 'bench_set_shift'],
        'standing': 'confirmed', 'adoption': adoption, 'before': 40.0, 'after': None, **others}
    return Came(**given)


def test_the_table_tells_right_from_wrong():
    told = table([
        came('stem_friction', ['stem_friction'], 'adopted: it is better', after=2.0),
        came('stem_friction', ['stem_friction', 'chamber_leak'], 'adopted: it is better',
             after=4.0),
        came('bench_set_shift', ['spring_rate_change'], 'adopted: it is better', after=1.0),
        came('bench_set_shift', ['chamber_leak'], 'adopted: it is better', delay=None,
             group=['chamber_leak'], after=1.0),
        came('stem_friction', ['chamber_leak'], early=True),
        came(NONE, [], kind='nothing', delay=None, noticed=None)])
    rows = {line.split('|')[1].strip(): [cell.strip() for cell in line.split('|')[2:-1]]
            for line in told.splitlines() if line.startswith('|')}
    assert rows['stem friction'] == [
        '2', '2', '2, 4 s', '2', '2', '2', '1', '1', '0', '0', '40.0 → 3.00']
    assert rows['bench set shift'] == [
        '2', '1', '2, 4 s', '2', '0', '1', '0', '0', '1', '1', '40.0 → 1.00']
    assert rows['no change'] == [
        '1', '0', '0', '1 found nothing', '', '', '', '', '', '0', '']
    assert 'Called unwell before the change: 1 of 6 runs.' in told
