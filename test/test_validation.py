# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What is said of another record on which a diagnosis is judged."""

from dataclasses import replace

from made_diagnosis import BENT, DECLARED, record_of, timed_columns, unknown_found
import numpy as np

from booster_ros.diagnosis.prepare.preparation import prepare
from booster_ros.diagnosis.judging.validation import validated
from booster_ros.report.notes import notes


def test_a_term_asked_for_what_it_has_not_seen_is_said():
    found = unknown_found()
    within = prepare(record_of(timed_columns(BENT, seed=2)), DECLARED)
    assert notes(validated(found, within)) == notes(found)

    narrow = found.unknown._replace(knots=tuple(np.linspace(0.004, 0.01, 12)))
    said = notes(validated(replace(found, unknown=narrow), within))
    seen = within.measured['valve_position']
    share = np.mean((seen < narrow.knots[1]) | (seen > narrow.knots[-2]))
    assert said[-1].startswith(f'{100.0 * share:.0f} % of the other record lies beyond the valve ')


def test_what_drove_the_other_record_and_is_compared_in_it_is_said_where_it_is_not_the_same():
    found = unknown_found()
    columns = timed_columns(BENT, seed=2)
    del columns['control_current']
    said = notes(validated(found, prepare(record_of(columns), DECLARED)))[len(notes(found)):]
    assert said == (
        'the other record is driven by chamber_pressure and compared in valve_position, the first '
        'is driven by control_current and compared in chamber_pressure and valve_position',)


def test_what_goes_by_time_since_the_record_began_is_said_of_the_other_record():
    found = unknown_found()
    another = prepare(record_of(timed_columns(BENT, seed=2)), DECLARED)
    swinging = found.after._replace(supply=found.after.supply._replace(ripple=2e3))
    said = set(notes(validated(replace(found, after=swinging), another))) - set(notes(found))
    assert sum('the other record is judged as if it began like the first' in one
               for one in said) == 1


def test_what_was_dropped_from_the_other_record_is_said():
    found = unknown_found()
    another = prepare(record_of(timed_columns(BENT, seed=2)), DECLARED)
    said = notes(validated(found, another, ('rows 7 to 9, column time: dropped',)))
    assert said[len(notes(found)):] == ('the other record: rows 7 to 9, column time: dropped',)
