# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which channels of a record drive the model, and which are compared with it."""

from made_diagnosis import DECLARED
from made_record import BACK, CHAMBER, FLOW, POSITION, ROWS, SUPPLY, TIME, record_of
import numpy as np
import pytest

from booster_ros.diagnosis.prepare.preparation import prepare
from booster_ros.records import RecordError, read_record

SHUT = DECLARED._replace(booster=DECLARED.booster._replace(opening_gain=0.0))
CURRENT = {'control_current': np.linspace(0.40e-3, 0.46e-3, ROWS)}
DROP = {'pressure_drop': np.linspace(1e5, 3e5, ROWS)}
NO_CURRENT = {'control_current': np.zeros(ROWS)}


@pytest.mark.parametrize(('columns', 'pinned', 'compared'), [
    (TIME | CURRENT | CHAMBER | POSITION, (), ('chamber_pressure', 'valve_position')),
    (TIME | CURRENT | BACK | SUPPLY | CHAMBER, ('supply_pressure',),
     ('back_pressure', 'chamber_pressure')),
    (TIME | BACK | CHAMBER | POSITION, ('back_pressure',), ('chamber_pressure', 'valve_position')),
    (TIME | BACK | FLOW | CHAMBER, ('back_pressure',), ('mass_flow', 'chamber_pressure')),
    (BACK | FLOW | CHAMBER | SUPPLY, ('back_pressure', 'chamber_pressure', 'supply_pressure'),
     ('mass_flow',)),
    (TIME | CHAMBER | POSITION, ('chamber_pressure',), ('valve_position',)),
    (CHAMBER | POSITION, ('chamber_pressure',), ('valve_position',)),
    (TIME | CURRENT | DROP | CHAMBER | POSITION, ('pressure_drop',),
     ('chamber_pressure', 'valve_position')),
    (TIME | BACK | SUPPLY | DROP | POSITION, ('back_pressure', 'supply_pressure', 'pressure_drop'),
     ('valve_position',)),
    (TIME | CHAMBER | POSITION | DROP, ('chamber_pressure', 'pressure_drop'), ('valve_position',)),
    (CHAMBER | POSITION | DROP, ('chamber_pressure', 'pressure_drop'), ('valve_position',)),
    (BACK | FLOW | CHAMBER | DROP, ('back_pressure', 'chamber_pressure'), ('mass_flow',)),
])
def test_the_most_upstream_channels_drive_and_the_others_are_compared(columns, pinned, compared):
    experiment = prepare(record_of(**columns), DECLARED)
    assert tuple(experiment.pinned) == pinned
    assert experiment.channels == compared
    assert np.ptp(experiment.current) == (np.ptp(CURRENT['control_current'])
                                          if 'control_current' in columns else 0.0)
    assert experiment.quasi_static == ('time' not in columns)


@pytest.mark.parametrize(('columns', 'pinned', 'compared'), [
    (TIME | CHAMBER, (), ('chamber_pressure',)),
    (TIME | CHAMBER | SUPPLY, ('supply_pressure',), ('chamber_pressure',)),
    (TIME | CHAMBER | DROP, (), ('chamber_pressure',)),
    (TIME | NO_CURRENT | CHAMBER | POSITION, (), ('chamber_pressure', 'valve_position')),
])
def test_a_record_that_nothing_drives_is_of_a_chamber_that_is_declared_shut(
        columns, pinned, compared):
    experiment = prepare(record_of(**columns), SHUT)
    assert tuple(experiment.pinned) == pinned
    assert experiment.channels == compared
    with pytest.raises(RecordError, match=r'^plant\.csv: nothing drives the model'):
        prepare(record_of(**columns), DECLARED)


@pytest.mark.parametrize('columns', [
    TIME | CURRENT, TIME | POSITION, TIME | FLOW, TIME | SUPPLY, CHAMBER, BACK | SUPPLY,
    CURRENT | SUPPLY, TIME | POSITION | DROP,
])
def test_a_record_without_a_drive_and_a_response_is_refused_in_one_sentence(columns):
    with pytest.raises(RecordError, match=r'^plant\.csv: nothing can be compared') as caught:
        prepare(record_of(**columns), DECLARED)
    for name in columns.keys() - {'time'}:
        assert name in str(caught.value)


def test_a_column_that_was_ignored_may_be_the_one_that_lacks(tmp_path):
    """A name that is nearly one of a record's is asked for where nothing can be compared."""
    csv = tmp_path / 'plant.csv'
    csv.write_text('time,control_current,chamber_presure,pos_mm\n' + ''.join(
        f'{row / 10},0.0004,{1000 * row},{row}\n' for row in range(40)))
    with pytest.raises(RecordError) as caught:
        prepare(read_record(csv), DECLARED)
    sentence = str(caught.value)
    assert 'has control_current, and nothing downstream of that to compare' in sentence
    assert 'column chamber_presure: not a column of a record, ignored (is it chamber_pressure?)' \
        in sentence
    assert 'column pos_mm' in sentence


def test_flow_without_a_known_opening_is_left_out_and_that_is_said():
    experiment = prepare(record_of(**TIME, **CHAMBER, **POSITION, **FLOW), DECLARED)
    assert experiment.channels == ('valve_position',)
    assert any('mass_flow is not compared' in note for note in experiment.notes)


def test_a_current_that_is_none_throughout_a_sweep_did_not_drive_it():
    by_hand = {**CHAMBER, **POSITION}
    started = np.where(np.arange(ROWS) > 0, 0.0, 0.4e-3)  # the first row only begins
    for current in (np.zeros(ROWS), started):
        with pytest.raises(RecordError, match='leave out a current that did not drive the valve'):
            prepare(record_of(control_current=current, **by_hand), DECLARED)
    assert prepare(record_of(**by_hand), DECLARED).drives == ('chamber_pressure',)


def test_what_is_of_the_stem_beside_the_flow_of_a_bench_is_left_out_and_that_is_said():
    experiment = prepare(
        record_of(**BACK, **FLOW, **CHAMBER, **SUPPLY, **POSITION, **DROP), DECLARED)
    assert experiment.channels == ('mass_flow',)
    for name in ('valve_position', 'pressure_drop'):
        assert any(f'{name} is not used' in note for note in experiment.notes)


def test_a_drop_that_drives_alone_is_left_out_and_that_is_said():
    experiment = prepare(record_of(**TIME, **CHAMBER, **DROP), SHUT)
    assert any('pressure_drop is not used' in note for note in experiment.notes)
