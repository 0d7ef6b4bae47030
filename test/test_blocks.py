# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Records are cut into blocks to train and to test by, whatever their length and gaps."""

from collections import Counter

import numpy as np
import pytest

from booster_ros.diagnosis.data.blocks import (
    FEWEST_BLOCKS, Segment, rows_of, split, split_sweep, training_blocks)
from booster_ros.records import RecordError


def test_every_part_of_a_sweep_trains_and_tests():
    segments = split_sweep(43)
    assert [(s.first, s.last) for s in segments][:2] == [(0, 2), (2, 4)]
    assert segments[-1].last == 43
    rows = {role: [s.first for s in segments if s.role == role]
            for role in ('train', 'test')}
    for first in rows.values():
        assert min(first) < 10
        assert max(first) > 30
    assert len(rows['train']) > 4 * len(rows['test'])


@pytest.mark.parametrize('seconds', [3.0, 7.0, 24.0, 150.0])
def test_a_short_record_is_cut_finer_so_that_each_part_is_there(seconds):
    time = np.arange(0.0, seconds, 0.01)
    roles = Counter(segment.role for segment in split(time, np.where(time % 6.0 < 3.0, 0.0, 1.0)))
    assert roles['train'] >= 4
    assert roles['test'] >= 1


@pytest.mark.parametrize('interval', [1.0, 24.0, 48.0, 120.0])
def test_rows_far_apart_are_cut_into_pieces_of_several_rows_for_every_part(interval):
    time = interval * np.arange(600)
    segments = split(time, np.arange(600) // 10 % 2 * 1.0)
    assert [s.first for s in segments[1:]] == [s.last for s in segments[:-1]]
    assert min(s.last - s.first for s in segments) >= 4
    roles = Counter(s.role for s in segments)
    assert roles['train'] > 40
    assert roles['test'] > 10


def test_a_record_too_short_to_hold_anything_back_is_refused():
    time = np.arange(0.0, 0.5, 0.01)
    with pytest.raises(RecordError, match=r'too short, 50 rows over 0\.49 s'):
        split(time, np.zeros(50))


def test_a_pause_in_a_record_is_an_edge_and_takes_no_time():
    time = np.concatenate([np.arange(0.0, 20.0, 0.02), 320.0 + np.arange(0.0, 100.0, 0.02)])
    segments = split(time, np.where(time % 8.0 < 4.0, 0.0, 1.0))
    assert any(segment.first == 1000 for segment in segments)
    locked = sum(segment.last - segment.first for segment in segments if segment.role == 'test')
    assert 0.15 < locked / len(time) < 0.25
    assert min(time[s.last - 1] - time[s.first] for s in segments) > 2.5


def test_the_test_set_is_the_last_fifth():
    time = np.arange(0.0, 150.0, 0.01)
    segments = split(time, np.where(time % 6.0 < 3.0, 0.0, 1.0))
    roles = [segment.role for segment in segments]
    assert roles == sorted(roles, reverse=True)  # all that trains comes first
    tested = rows_of(segments, 'test', len(time))
    assert np.mean(tested) == pytest.approx(0.2, abs=0.03)
    assert np.array_equal(rows_of(segments, 'train', len(time)), ~tested)


def test_each_training_block_has_a_number_and_no_other_row_has_one():
    segments = [Segment(10 * k, 10 * (k + 1), 'train') for k in range(9)]
    block = training_blocks([*segments, Segment(90, 100, 'test')], 100)
    assert np.array_equal(block[:90], np.arange(90) // 10)
    assert set(block[90:]) == {-1}


def test_few_training_blocks_are_cut_into_equal_parts():
    block = training_blocks([Segment(0, 40, 'train'), Segment(40, 100, 'train')], 100)
    numbers, rows = np.unique(block, return_counts=True)
    assert len(numbers) == FEWEST_BLOCKS
    assert set(rows) == {10, 15}
    assert (np.diff(block) >= 0).all()
