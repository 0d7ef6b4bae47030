# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The table of decisions: what is accepted in the place of what, and what may be relied on."""

from dataclasses import replace
from math import log

import numpy as np
import pytest

from booster_ros.diagnosis.selection.decide import (
    TIE, Comparison, compare, standing, why_not)
from booster_ros.diagnosis.selection.score import Score


def found(log_evidence, without_best_block=10.0):
    return Comparison(log_evidence, 10.0, 1.0, without_best_block, 1.0)


TOO_LITTLE = 'the evidence for it is not enough'
ONE_BLOCK = 'its gain rests on a single block of the record'


@pytest.mark.parametrize(('evidence', 'without_best', 'candidates', 'reason'), [
    (TIE + 0.01, 10.0, 1, ''),
    (TIE - 0.01, 10.0, 1, TOO_LITTLE),
    (TIE + 0.01, 10.0, 2, TOO_LITTLE),
    (TIE + log(60) + 0.01, 10.0, 60, ''),
    (TIE + log(60) - 0.01, 10.0, 60, TOO_LITTLE),
    (1e6, TIE + 0.01, 1, ''),
    (1e6, TIE - 0.01, 1, ONE_BLOCK),
    (1e6, -5.0, 60, ONE_BLOCK),
    (-3.0, -5.0, 60, TOO_LITTLE),
    (TIE + 0.01, 10.0, 0, ''),  # no candidate is counted as one
])
def test_a_model_is_accepted_by_its_evidence_and_by_more_than_one_block(
        evidence, without_best, candidates, reason):
    said = found(evidence, without_best)
    assert why_not(said, candidates) == reason


def test_what_chance_changes_of_a_likelihood_has_to_be_gained_on_top():
    luck = 40.0
    for gained, reason in ((TIE + luck - 0.01, TOO_LITTLE), (TIE + luck + 0.01, '')):
        assert why_not(replace(found(gained, gained), luck=luck), 1) == reason
    chancy = replace(score([10.0, 20.0, 30.0, 40.0]), luck=luck)
    for c in (1.0, 4.0):
        assert compare(chancy, score([30.0] * 4), c).luck == luck / c
        assert compare(score([30.0] * 4), chancy, c).luck == 0.0


@pytest.mark.parametrize(('explained', 'left', 'at_bound', 'in_test', 'said'), [
    (1.0, 1.0, False, True, 'confirmed'),
    (0.1, 1.0, False, True, 'confirmed'),
    (1.0, 1.0, False, False, 'likely'),
    (0.9, 20.0, False, True, 'likely'),
    (0.9, 20.0, False, False, 'likely'),
    (0.7, 20.0, False, True, 'candidate'),
    (0.7, 8.9, False, True, 'confirmed'),
    (1.0, 1.0, True, True, 'candidate'),
])
def test_what_may_be_relied_on(explained, left, at_bound, in_test, said):
    assert standing(explained, left, at_bound, in_test) == said


def score(costs):
    """Return the score of a model without variables that leaves these sums of squares."""
    costs = np.array(costs, dtype=float)
    return Score(float(costs.sum()), 0.0, 10 * len(costs), 1.0, costs, np.zeros((0, 0)),
                 np.zeros(0))


def test_differences_are_tempered_and_the_best_block_is_left_out():
    without, better = score([30.0, 30.0, 30.0, 30.0]), score([10.0, 20.0, 30.0, 40.0])
    plain, tempered = (compare(better, without, c) for c in (1.0, 4.0))
    assert plain.log_evidence == pytest.approx(10.0)
    assert plain.gain == pytest.approx(10.0)
    # gains are 10, 5, 0 and -5: their sum's standard error is 2 times their deviation
    assert plain.gain_standard_error == pytest.approx(2.0 * np.std([10.0, 5.0, 0.0, -5.0], ddof=1))
    assert plain.without_best_block == pytest.approx(0.0, abs=1e-12)
    for name in ('log_evidence', 'gain', 'gain_standard_error'):
        assert getattr(tempered, name) == pytest.approx(getattr(plain, name) / 4.0)
    assert tempered.dispersion == 4.0
    other_way = compare(without, better, 1.0)
    assert (other_way.log_evidence, other_way.gain) == pytest.approx((-10.0, -10.0))


@pytest.mark.parametrize(('blocks', 'answer'), [
    ([930.0, 30.0, 30.0, 30.0], False),  # a disturbance that happened once
    ([480.0, 480.0, 30.0, 30.0], True)])
def test_what_comes_back_is_accepted_and_what_happened_once_is_not(blocks, answer):
    said = compare(score([30.0] * 4), score(blocks), 1.0)
    assert said.gain == pytest.approx(450.0)
    assert (not why_not(said, 60)) is answer


def test_of_one_block_no_standard_error_is_known():
    assert compare(score([1.0]), score([9.0]), 1.0).gain_standard_error == 0.0
    assert why_not(compare(score([1.0]), score([900.0]), 1.0), 1)


def test_a_tie_is_odds_of_twenty():
    assert pytest.approx(log(20.0)) == TIE
