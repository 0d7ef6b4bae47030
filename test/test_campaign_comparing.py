# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Comparing two campaigns case by case."""

from made_outcome import FRICTION, LEAK, found, outcome
import pytest

from booster_ros.campaign.cases import CampaignError
from booster_ros.campaign.comparing import (
    comparison, error_ratio, mcnemar, most_moved, paired, same_answer)
from booster_ros.campaign.scoring import TIMEOUT, Interval


@pytest.mark.parametrize(('both', 'only_first', 'only_second', 'neither', 'p'), [
    (10, 0, 0, 3, 1.0),
    (90, 6, 0, 4, 0.03125),  # 2 / 2**6
    (90, 1, 1, 0, 1.0),
    (50, 5, 15, 7, 0.041389),  # R: binom.test(5, 20)
    (50, 15, 5, 7, 0.041389),
    (0, 1, 9, 0, 0.021484),  # 22 / 2**10
])
def test_mcnemar_is_exact(both, only_first, only_second, neither, p):
    first = [True] * both + [True] * only_first + [False] * only_second + [False] * neither
    second = [True] * both + [False] * only_first + [True] * only_second + [False] * neither
    test = mcnemar(first, second)
    assert (test.only_first, test.only_second) == (only_first, only_second)
    assert test.p == pytest.approx(p, abs=1e-6)


def test_cases_are_paired_by_set_and_name_or_by_name_alone():
    first = [outcome('a', set='x'), outcome('b', set='x')]
    assert [p[1].case for p in paired(first, [outcome('b', set='x'), outcome('c', set='x')])] == [
        'b']
    disturbed = [outcome('b', set='x_disturbed'), outcome('a', set='x_disturbed')]
    assert [(p[0].case, p[1].case) for p in paired(first, disturbed)] == [('a', 'a'), ('b', 'b')]
    with pytest.raises(CampaignError, match='no case in common'):
        paired(first, [outcome('c')])
    twice = [outcome('a', set='y'), outcome('a', set='z')]  # which of them is not to be guessed
    with pytest.raises(CampaignError, match='no case in common'):
        paired(first, twice)


def test_errors_are_compared_by_channel():
    first = outcome('a', after={'chamber_pressure': 100.0, 'valve_position': 1e-5})
    second = outcome('a', after={'chamber_pressure': 200.0, 'valve_position': 2e-5})
    assert error_ratio(first, second) == pytest.approx(2.0)
    assert error_ratio(second, first) == pytest.approx(0.5)
    assert error_ratio(first, outcome('a', after=None)) is None


def test_an_answer_is_the_same_by_verdict_and_names():
    assert same_answer(outcome('a', LEAK, FRICTION), outcome('a', FRICTION, LEAK))
    assert not same_answer(outcome('a', LEAK), outcome('a', FRICTION))
    assert not same_answer(outcome('a', LEAK), outcome('a'))
    lost = outcome('a', status=TIMEOUT, verdict='')
    assert not same_answer(lost, lost)


def test_a_size_moves_in_widths_of_its_interval():
    def sized(leak: float, other: float):
        return outcome('a', found('chamber_leak', 'chamber', a__leak=(leak, 1.0, 3.0)),
                       found('dead_time', 'ep_converter', e__time=(other, 0.0, 10.0)))

    moved = most_moved(sized(2.0, 5.0), sized(2.1, 5.1))
    assert moved.parameter == 'a.leak'
    assert moved.widths == pytest.approx(0.05)
    assert most_moved(sized(2.0, 5.0), sized(2.0, 5.0)).widths == 0.0
    assert most_moved(sized(2.0, 5.0), outcome('a', LEAK)).widths == 0.0


def test_a_comparison_says_what_differs():
    leaks = {'names': ['chamber_leak'], 'location': 'chamber'}
    near, far = {'chamber_pressure': 150.0}, {'chamber_pressure': 300.0}

    def leak(leak_area: float):
        return found('chamber_leak', 'chamber', a__leak=(leak_area, 1.0, 3.0))

    held = Interval('a.leak', True, 2.0, 2.0, 1.0, 3.0)
    missed = Interval('a.leak', True, 5.0, 2.0, 1.0, 3.0)
    first = [outcome('clean', after=near), outcome('one', leak(2.0), after=near, **leaks),
             outcome('two', leak(2.0), after=near, intervals=[held], **leaks)]
    second = [outcome('clean', LEAK, after=far, seconds=20.0),
              outcome('one', leak(2.4), after=near, **leaks),
              outcome('two', leak(2.0), after=far, intervals=[missed], **leaks),
              outcome('three')]
    text = comparison(first, second, ('A', 'B'))
    assert '3 cases are in both; 1 in B only.' in text
    assert '| name | 3 of 3 | 2 of 3 | 1 | 0 | 1 |' in text
    assert '| clean ones left alone | 1 of 1 | 0 of 1 | 1 | 0 | 1 |' in text
    assert '| second record within 1.5 × noise | 3 of 3 | 1 of 3 | 2 | 0 | 0.5 |' in text
    assert '| 95 % intervals of sizes that hold the truth | 1 of 1 | 0 of 1 |' in text
    assert '| largest error of a size, interval widths | 0 | 1.5 |' in text
    assert ('- Error on the second record, B over A: median 2.000, quartiles 1.500 and 2.000 '
            '(3 cases)') in text
    assert ('Same verdict and names: 2 of 3 (66.7 %); of these, all sizes within 0.1 of their '
            'interval: 1 of 2. Largest change of a size: 0.2 interval widths, `a.leak` of set/one'
            ) in text
    assert ('| clean | none | none | chamber_leak | right → wrong | right → wrong | '
            'right → wrong |') in text
    assert '| one |' not in text
    same = comparison(first, first, ('A', 'A again'))
    assert 'No size differs.' in same
    assert 'No case was answered differently.' in same
