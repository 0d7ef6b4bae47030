# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""When a term without a name is the verdict."""

import numpy as np
import pytest

from booster_ros.diagnosis.nameless import preferable
from booster_ros.diagnosis.search import Candidate, clearly_better
from booster_ros.diagnosis.selection import Tried

SAMPLES = 1000
UNNAMED = 'unknown: ep_converter over time'


def scored(effects, *by_segment):
    """Return a model that scored so, in units of the noise, on segments of equal length."""
    each = SAMPLES / len(by_segment)
    return Candidate(effects, None, None, each * np.array(by_segment), 0.0, SAMPLES)


def tried(named):
    refit = scored((), 40.0, 40.0, 40.0, 40.0)
    return Tried(refit, named, (refit, named), {})


UNEVEN = scored((UNNAMED,), 1.0, 14.0, 1.0, 14.0)


@pytest.mark.parametrize(('named', 'wins'), [
    (scored(('ep_drift', 'seat_load'), 9.0, 9.0, 9.0, 9.0), True),
    (scored(('ep_drift',), 9.0, 9.0, 9.0, 9.0), False),
    (scored(('ep_drift', 'seat_load'), 7.0, 7.0, 7.0, 7.0), False),
])
def test_several_effects_that_leave_structure_give_way_to_a_term_that_leaves_less(named, wins):
    assert not clearly_better(UNEVEN, named)
    assert preferable(UNEVEN, tried(named)) is wins


def test_several_effects_that_leave_little_do_not_give_way():
    named = scored(('ep_drift', 'seat_load'), 2.5, 2.5, 2.5, 2.5)
    term = scored((UNNAMED,), 1.0, 3.6, 1.0, 3.6)
    assert not preferable(term, tried(named))
    assert preferable(scored((UNNAMED,), 1.0, 1.1, 1.0, 1.1), tried(named))


def test_where_no_name_was_found_a_term_is_the_verdict():
    refit = scored((), 40.0, 40.0, 40.0, 40.0)
    assert preferable(UNEVEN, Tried(refit, refit, (refit,), {}))
